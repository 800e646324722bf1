// Eye-dome lighting: the albedo, darkened where neighbours stand out in front.
// One thread per pixel. CPU twin: `edl` in src/gbuffer/edl.rs.
#import plane_depth

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct EdlParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    straight: i32,      // distance of the neighbours beside, above and below, pixels
    diagonal: i32,      // distance of the others along each axis, pixels
    gain: f32,          // darkening per summed logarithmic depth difference
    pad: vec2u,
}

@group(0) @binding(0) var<uniform> params: EdlParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> picture: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = i32(id.x);
    let y = i32(params.rows.x + id.y);
    let size = vec2i(params.pinhole.size);
    if x >= size.x || y >= i32(params.rows.y) {
        return;
    }
    let here = u32(y) * params.pinhole.size.x + id.x - params.first_pixel;
    if material[here].w <= 0.0 {
        picture[here] = vec4f(0.0);
        return;
    }
    let depth = surface[here].w;
    let normal = surface[here].xyz;
    let direction = direction_of(params.pinhole, id.x, u32(y));
    var response = 0.0;
    for (var k = 0; k < 9; k++) {
        let dx = k % 3 - 1;
        let dy = k / 3 - 1;
        let distance = select(params.straight, params.diagonal, dx != 0 && dy != 0);
        let u = x + dx * distance;
        let v = y + dy * distance;
        if k == 4 || u < 0 || v < 0 || u >= size.x || v >= size.y {
            continue;
        }
        let there = u32(v) * params.pinhole.size.x + u32(u) - params.first_pixel;
        if material[there].w > 0.0 {
            let towards = direction_of(params.pinhole, u32(u), u32(v));
            let expected = plane_depth(normal, direction, depth, towards);
            response += max(log2(expected / surface[there].w), 0.0);
        }
    }
    picture[here] = vec4f(albedo[here].xyz * exp(-params.gain * response), 1.0);
}
