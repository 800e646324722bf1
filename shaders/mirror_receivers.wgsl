// What the mirrors show, as indirect light takes it.
// One thread per pixel. CPU twin: `Receivers::of_mirror` in src/gi/receivers.rs.
#import receiver

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct MirrorReceiverParams {
    rows: vec2u,        // first row, and one past the last
    width: u32,         // of the picture, pixels
    first_pixel: u32,   // number of the bindings' first pixel, row by row
}

@group(0) @binding(0) var<uniform> params: MirrorReceiverParams;
@group(0) @binding(1) var<storage, read> origin: array<vec4f>;
@group(0) @binding(2) var<storage, read> ray: array<vec4f>;
@group(0) @binding(3) var<storage, read> surface: array<vec4f>;
@group(0) @binding(4) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(5) var<storage, read> material: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> positions: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> normals: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> views: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.width || y >= params.rows.y {
        return;
    }
    let here = y * params.width + x - params.first_pixel;
    let place = origin[here].xyz + ray[here].xyz * surface[here].w;
    let r = receiver(surface[here], albedo[here], material[here], place, ray[here].xyz);
    positions[here] = r.position;
    normals[here] = r.normal;
    views[here] = r.view;
}
