// The mirrors that the camera sees from the front: their points and normals.
// One thread per pixel. CPU twin: `Surface::of` in src/reflect/surface.rs.
#import plane_depth

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct SurfaceParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: SurfaceParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
// Relative to the scene's origin; w is 1 on a mirror.
@group(0) @binding(4) var<storage, read_write> point: array<vec4f>;
// Unit normal, and the local spacing.
@group(0) @binding(5) var<storage, read_write> normal: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.pinhole.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.pinhole.size.x + id.x - params.first_pixel;
    let its = material[here];
    if its.w <= 0.0 || albedo[here].w <= 0.0 {
        point[here] = vec4f(0.0);
        normal[here] = vec4f(0.0);
        return;
    }
    let plane = surface[here];
    let at = params.pinhole.eye + direction_of(params.pinhole, id.x, y) * plane.w;
    point[here] = vec4f(at, 1.0);
    normal[here] = vec4f(plane.xyz, its.z);
}
