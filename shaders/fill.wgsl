// Closes one ring of small holes from the planes of their neighbours.
// One thread per pixel. CPU twin: `fill_pixel` in src/gbuffer/fill.rs.
#import plane_depth

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override MIN_NEIGHBOURS: u32;
override AGREE_SPACINGS: f32;

struct FillParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    ring: u32,          // counted from 1
}

@group(0) @binding(0) var<uniform> params: FillParams;
// A pixel that is filled in this ring says so in its validity, so that its neighbours do not take it for their own.
@group(0) @binding(1) var<storage, read_write> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> material: array<vec4f>;

struct Neighbour {
    pixel: u32,
    depth: f32,     // of its plane, on the hole's ray
    radius: f32,
    mirror: bool,
}

fn agree(a: Neighbour, b: Neighbour) -> bool {
    return a.mirror == b.mirror && abs(a.depth - b.depth) <= AGREE_SPACINGS * a.radius;
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = params.pinhole.size;
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= size.x || y >= params.rows.y {
        return;
    }
    let here = y * size.x + x - params.first_pixel;
    if material[here].w != 0.0 {
        return;
    }
    let ring = f32(params.ring);
    let towards = direction_of(params.pinhole, x, y);

    // Each neighbour's plane on this pixel's ray.
    var seen: array<Neighbour, 8>;
    var count = 0u;
    for (var k = 0u; k < 9u; k++) {
        let u = i32(x) + i32(k % 3u) - 1;
        let v = i32(y) + i32(k / 3u) - 1;
        if k == 4u || u < 0 || v < 0 || u >= i32(size.x) || v >= i32(size.y) {
            continue;
        }
        let pixel = u32(v) * size.x + u32(u) - params.first_pixel;
        let its = material[pixel];
        if !(its.w > 0.0 && its.w <= ring) {
            continue;
        }
        let plane = surface[pixel];
        let direction = direction_of(params.pinhole, u32(u), u32(v));
        let depth = plane_depth(plane.xyz, direction, plane.w, towards);
        seen[count] = Neighbour(pixel, depth, its.z, albedo[pixel].w > 0.0);
        count++;
    }
    if count < MIN_NEIGHBOURS {
        return;
    }

    // The surface on which most neighbours agree; the nearer where two have as many.
    var best = 0u;
    var best_votes = 0u;
    for (var i = 0u; i < count; i++) {
        var votes = 0u;
        for (var j = 0u; j < count; j++) {
            votes += select(0u, 1u, agree(seen[i], seen[j]));
        }
        if votes > best_votes || (votes == best_votes && seen[i].depth < seen[best].depth) {
            best = i;
            best_votes = votes;
        }
    }

    // Their mean.
    var normal = vec3f(0.0);
    var depth = 0.0;
    var colour = vec4f(0.0);
    var finish = vec4f(0.0);
    for (var j = 0u; j < count; j++) {
        if agree(seen[best], seen[j]) {
            normal += surface[seen[j].pixel].xyz;
            depth += seen[j].depth;
            colour += albedo[seen[j].pixel];
            finish += material[seen[j].pixel];
        }
    }
    let inverse = 1.0 / f32(best_votes);
    let length = sqrt(dot3(normal, normal));
    if length > 1e-6 {
        normal /= length;
    } else {
        normal = surface[seen[best].pixel].xyz;
    }
    surface[here] = vec4f(normal, depth * inverse);
    albedo[here] = colour * inverse;
    material[here] = vec4f(finish.xyz * inverse, 1.0 + ring);
}
