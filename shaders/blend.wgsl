// What the mirrors show over the points' own part.
// One thread per pixel. CPU twin: `blend` in src/reflect/blend.rs.

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct BlendParams {
    size: vec2u,        // of the picture, pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    lit: u32,           // 1: mirrors show `shown`; 0: there is no light, and they show albedo
    pad: vec2u,
}

@group(0) @binding(0) var<uniform> params: BlendParams;
// Of the points that the camera sees.
@group(0) @binding(1) var<storage, read> own_albedo: array<vec4f>;
// Of what the mirrors show.
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
@group(0) @binding(4) var<storage, read> shown: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + id.x - params.first_pixel;
    let reflectance = own_albedo[here].w;
    if reflectance <= 0.0 {
        return;
    }
    var own = radiance[here];
    var reflected = vec3f(0.0);
    if params.lit == 1u {
        reflected = shown[here].xyz;
    } else {
        // Unlit, the own part is not yet weighted.
        own = vec4f(own.xyz * (1.0 - reflectance), own.w);
        if material[here].w > 0.0 {
            let seen = albedo[here];
            reflected = seen.xyz * (1.0 - seen.w);
        }
    }
    radiance[here] = vec4f(own.xyz + reflected * reflectance, own.w);
}
