// Puts what closed holes of mirrors show to where the nearest found pixel around lies.
// One thread per pixel. CPU twin: `settle` in src/gi/settle.rs.
#import dot3

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override REACH: i32;            // pixels
override NORMAL_COSINE: f32;

struct SettleParams {
    size: vec2u,        // of the picture, pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: SettleParams;
@group(0) @binding(1) var<storage, read> level: array<f32>;
@group(0) @binding(2) var<storage, read> positions: array<vec4f>;
@group(0) @binding(3) var<storage, read> normals: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> settled: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + x - params.first_pixel;
    var place = positions[here];
    if place.w > 0.0 && level[here] > 0.0 {
        let normal = normals[here].xyz;
        var nearest = REACH * REACH + 1;
        for (var v = -REACH; v <= REACH; v++) {
            for (var u = -REACH; u <= REACH; u++) {
                let pixel = vec2i(i32(x) + u, i32(y) + v);
                let far = u * u + v * v;
                if far >= nearest || any(pixel < vec2i(0)) || any(pixel >= vec2i(params.size)) {
                    continue;
                }
                let there = u32(pixel.y) * params.size.x + u32(pixel.x) - params.first_pixel;
                let found = positions[there].w > 0.0 && level[there] <= 0.0;
                if found && dot3(normal, normals[there].xyz) > NORMAL_COSINE {
                    nearest = far;
                    place = positions[there];
                }
            }
        }
    }
    settled[here] = place;
}
