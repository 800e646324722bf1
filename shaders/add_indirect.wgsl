// Adds the radiance of the indirect light.
// One thread per pixel. CPU twin: `add_indirect` in src/gi/add_indirect.rs.

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override MIN_LUMINANCE: f32;

const PI: f32 = 3.14159265;

struct AddParams {
    rows: vec2u,        // first row, and one past the last
    width: u32,         // of the picture, pixels
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    albedo_scale: f32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: AddParams;
@group(0) @binding(1) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(2) var<storage, read> irradiance: array<vec4f>;
@group(0) @binding(3) var<storage, read> residual: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.width || y >= params.rows.y {
        return;
    }
    let here = y * params.width + x - params.first_pixel;
    let arrived = irradiance[here].xyz + residual[here].xyz;
    let luminance = 0.2126 * arrived.x + 0.7152 * arrived.y + 0.0722 * arrived.z;
    let glossy = arrived * (irradiance[here].w / max(luminance, MIN_LUMINANCE));
    let sent = albedo[here].xyz * params.albedo_scale / PI * arrived + glossy;
    radiance[here] += vec4f(sent * (1.0 - albedo[here].w), 0.0);
}
