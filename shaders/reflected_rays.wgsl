// The ray of every mirror pixel: where it starts, and where it goes.
// One thread per pixel. CPU twin: `MirrorGBuffer::of` in src/reflect/mirror_gbuffer.rs.
#import eye
#import unit

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct ReflectedRaysParams {
    eye: EyeParams,
    size: vec2u,        // pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: ReflectedRaysParams;
@group(0) @binding(1) var<storage, read> point: array<vec4f>;
@group(0) @binding(2) var<storage, read> normal: array<vec4f>;
@group(0) @binding(3) var<storage, read> eyes: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> origin: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> direction: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + id.x - params.first_pixel;
    let at = point[here];
    let n = normal[here].xyz;
    let view = at.xyz - eye_of(params.eye, here);
    let towards = unit_or_zero(view - n * (2.0 * dot3(view, n)));
    if at.w <= 0.0 || all(towards == vec3f(0.0)) {
        origin[here] = vec4f(0.0);
        direction[here] = vec4f(0.0);
        return;
    }
    origin[here] = vec4f(at.xyz, 1.0);
    direction[here] = vec4f(towards, 0.0);
}
