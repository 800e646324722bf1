// Sums the attributes of all fragments within a tolerance of the nearest, in fixed point.
// One thread per surfel. CPU twin: `visibility` in src/gbuffer/visibility.rs.
#import disc
#import depth_key
#import sums

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: SplatParams;
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(3) var<storage, read> keys: array<u32>;
@group(0) @binding(4) var<storage, read> counts: array<u32>;
// Twelve to a pixel, in the order of `Sums`.
@group(0) @binding(5) var<storage, read_write> sums: array<atomic<i32>>;

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
    let its = attributes(finish, d.behind);
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
            let behind = min((depth - front) * inverse_front, 1.0);
            add_surfel(row + x, its, s, behind, min(place.w * inverse_front, 1.0));
        }
    }
}
