// Adds the light of one spot to the radiance of every pixel towards the eye.
// One thread per pixel. CPU twin: `shade` in src/gi/shade.rs.
#import plane_depth
#import light

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct ShadeParams {
    pinhole: Pinhole,   // the eye's
    light: LightParams,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: ShadeParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
// The light map, in two bindings where one is too small.
@group(0) @binding(4) var<storage, read> low_keys: array<u32>;
@group(0) @binding(5) var<storage, read> high_keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.pinhole.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.pinhole.size.x + x - params.first_pixel;
    let its = material[here];
    if its.w <= 0.0 {
        radiance[here] = vec4f(0.0);
        return;
    }
    let plane = surface[here];
    let colour = albedo[here];
    let direction = direction_of(params.pinhole, x, y);
    let position = params.pinhole.eye + direction * plane.w;
    let view = -direction / sqrt(dot3(direction, direction));
    var sum = vec3f(0.0);
    if params.light.first == 0u {
        sum = radiance[here].xyz;
    }
    // A mirror's own part is weighted by what its reflectance leaves.
    sum += spot_radiance(position, plane.xyz, view, colour.xyz, its) * (1.0 - colour.w);
    radiance[here] = vec4f(sum, 1.0);
}
