// Sums the attributes of all fragments within a tolerance of the nearest, in fixed point.
// One thread per surfel. CPU twin: `visibility` in src/gbuffer/visibility.rs.
#import disc
#import depth_key

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: SplatParams;
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(3) var<storage, read> keys: array<u32>;
@group(0) @binding(4) var<storage, read> counts: array<u32>;
// Twelve to a pixel, in the order of `Sums`.
@group(0) @binding(5) var<storage, read_write> sums: array<atomic<i32>>;

// Scale of the sums of a pixel with `count` fragments: count times scale stays within 2^30.
fn sum_scale(count: u32) -> f32 {
    let bits = 32u - countLeadingZeros(count);
    return bitcast<f32>((157u - min(bits, 30u)) << 23u);
}

// Most materials are neither glossy nor mirrors: nothing is cheaper than adding nothing.
fn add(slot: u32, value: f32) {
    let fixed = i32(value);
    if fixed != 0 {
        atomicAdd(&sums[slot], fixed);
    }
}

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let point = params.first_point + id.x;
    if point >= params.end_point {
        return;
    }
    let finish = finishes[point];
    let place = places[point];
    let d = disc(place, finish, params);
    if !d.seen {
        return;
    }

    // Seen from behind, a diffuse surfel turns its normal, and a mirror is opaque and black.
    var normal = finish_normal(finish);
    var albedo = vec4f(finish_albedo(finish), finish_mirror(finish));
    var gloss = vec2f(finish_specular(finish), finish_shininess_log(finish));
    if d.behind {
        normal = -normal;
        if albedo.w > 0.0 {
            albedo = vec4f(0.0);
            gloss = vec2f(0.0);
        }
    }

    for (var y = d.first.y; y < d.end.y; y++) {
        let row = y * params.pinhole.size.x - params.first_pixel;
        for (var x = d.first.x; x < d.end.x; x++) {
            let f = fragment(d, x, y, params.pinhole);
            let key = keys[row + x];
            if !f.covered || key == EMPTY || key_class(key) != d.class_bits {
                continue;
            }
            let depth = key_depth(bitcast<u32>(f.depth));
            let front = key_depth(key);
            if abs(depth - front) > d.tolerance {
                continue;
            }
            let inverse_front = 1.0 / front;
            let s = weight(f.distance_squared * d.inverse_half_squared) * sum_scale(counts[row + x]);
            let slot = (row + x) * 12u;
            add(slot, s);
            add(slot + 1u, min((depth - front) * inverse_front, 1.0) * s);
            add(slot + 2u, gloss.x * s);
            add(slot + 3u, gloss.y * s);
            add(slot + 4u, albedo.x * s);
            add(slot + 5u, albedo.y * s);
            add(slot + 6u, albedo.z * s);
            add(slot + 7u, albedo.w * s);
            add(slot + 8u, normal.x * s);
            add(slot + 9u, normal.y * s);
            add(slot + 10u, normal.z * s);
            add(slot + 11u, min(place.w * inverse_front, 1.0) * s);
        }
    }
}
