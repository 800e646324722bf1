// Adds the light of one spot to the radiance that every mirror pixel shows.
// One thread per pixel. CPU twin: `shade_mirror` in src/gi/shade.rs.
#import light

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct ShadeMirrorParams {
    light: LightParams,
    size: vec2u,        // of the picture, pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: ShadeMirrorParams;
@group(0) @binding(1) var<storage, read> origin: array<vec4f>;
@group(0) @binding(2) var<storage, read> direction: array<vec4f>;
@group(0) @binding(3) var<storage, read> surface: array<vec4f>;
@group(0) @binding(4) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(5) var<storage, read> material: array<vec4f>;
// The light map, in two bindings where one is too small.
@group(0) @binding(6) var<storage, read> low_keys: array<u32>;
@group(0) @binding(7) var<storage, read> high_keys: array<u32>;
@group(0) @binding(8) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + id.x - params.first_pixel;
    let its = material[here];
    if its.w <= 0.0 {
        radiance[here] = vec4f(0.0);
        return;
    }
    let plane = surface[here];
    let colour = albedo[here];
    let towards = direction[here].xyz;
    let position = origin[here].xyz + towards * plane.w;
    var sum = vec3f(0.0);
    if params.light.first == 0u {
        sum = radiance[here].xyz;
    }
    // A mirror seen in a mirror is black but for what its reflectance leaves.
    sum += spot_radiance(position, plane.xyz, -towards, colour.xyz, its) * (1.0 - colour.w);
    radiance[here] = vec4f(sum, 1.0);
}
