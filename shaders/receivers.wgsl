// What the camera sees, as indirect light takes it.
// One thread per pixel. CPU twin: `Receivers::of` in src/gi/receivers.rs.
#import plane_depth
#import receiver

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct ReceiverParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: ReceiverParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> positions: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> normals: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> views: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.pinhole.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.pinhole.size.x + x - params.first_pixel;
    let direction = direction_of(params.pinhole, x, y);
    let place = params.pinhole.eye + direction * surface[here].w;
    let r = receiver(surface[here], albedo[here], material[here], place, direction);
    positions[here] = r.position;
    normals[here] = r.normal;
    views[here] = r.view;
}
