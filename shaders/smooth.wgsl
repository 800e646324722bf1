// Smooths the normals and depths of mirrors: a joint bilateral Gaussian.
// One thread per pixel. CPU twin: `smooth_pixel` in src/gbuffer/smooth.rs.
#import plane_depth

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override DEPTH_SPACINGS: f32;
override NORMAL_DIFFERENCE: f32;

struct SmoothParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    reach: i32,         // of the window, pixels
}

@group(0) @binding(0) var<uniform> params: SmoothParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
// The Gaussian over a pixel's neighbours, row by row.
@group(0) @binding(4) var<storage, read> gaussian: array<f32>;
@group(0) @binding(5) var<storage, read_write> smoothed: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = params.pinhole.size;
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= size.x || y >= params.rows.y {
        return;
    }
    let here = y * size.x + x - params.first_pixel;
    let plane = surface[here];
    if albedo[here].w <= 0.0 {
        smoothed[here] = plane;
        return;
    }
    let normal = plane.xyz;
    let depth = plane.w;
    let direction = direction_of(params.pinhole, x, y);
    let limit = DEPTH_SPACINGS * material[here].z;
    var normals = vec3f(0.0);
    var offsets = 0.0;
    var weights = 0.0;
    for (var dy = -params.reach; dy <= params.reach; dy++) {
        for (var dx = -params.reach; dx <= params.reach; dx++) {
            let u = i32(x) + dx;
            let v = i32(y) + dy;
            if u < 0 || v < 0 || u >= i32(size.x) || v >= i32(size.y) {
                continue;
            }
            let there = u32(v) * size.x + u32(u) - params.first_pixel;
            if albedo[there].w <= 0.0 {
                continue;
            }
            let other = surface[there];
            let other_direction = direction_of(params.pinhole, u32(u), u32(v));

            // By the other's plane to here, and by this plane to there: their mean is free of curvature.
            let carried_here = plane_depth(other.xyz, other_direction, other.w, direction) - depth;
            let carried_there = other.w - plane_depth(normal, direction, depth, other_direction);
            let offset = 0.5 * (carried_here + carried_there);
            let bend = other.xyz - normal;
            let turn = dot3(bend, bend) / (NORMAL_DIFFERENCE * NORMAL_DIFFERENCE);
            let apart = (offset / limit) * (offset / limit);
            let similar = max(1.0 - turn, 0.0) * max(1.0 - apart, 0.0);
            let near = gaussian[(dy + params.reach) * (2 * params.reach + 1) + dx + params.reach];
            let weight = near * similar * similar;
            normals += other.xyz * weight;
            offsets += offset * weight;
            weights += weight;
        }
    }
    let length_squared = dot3(normals, normals);
    var mean = normal;
    if length_squared > 0.0 {
        mean = normals / sqrt(length_squared);
    }
    smoothed[here] = vec4f(mean, depth + offsets / max(weights, 1.1754944e-38));
}
