// The mirrors of a picture, laid out for the search in the rectangle around all regions.
// One thread per pixel of it. CPU twin: `MirrorPixels` in src/reflect/sscr/mirror_pixels.rs.
#import eye
#import unit
#import mirror_space

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct MirrorPixelsParams {
    eye: EyeParams,
    right: vec3f,       // the picture's x axis in the scene, unit vector
    width: u32,         // of the picture, pixels
    first: vec2u,       // of the rectangle, pixels
    size: vec2u,        // of the rectangle, pixels
    rows: vec2u,        // first row, and one past the last, of the picture
    first_pixel: u32,   // number of the first pixel of the picture's bindings, row by row
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: MirrorPixelsParams;
@group(0) @binding(1) var<storage, read> point: array<vec4f>;
@group(0) @binding(2) var<storage, read> normal: array<vec4f>;
@group(0) @binding(3) var<storage, read> eyes: array<vec4f>;
@group(0) @binding(4) var<storage, read> region: array<u32>;
// As `shared/mirror_space.wgsl` reads them.
@group(0) @binding(5) var<storage, read_write> mirror_position: array<vec4u>;
@group(0) @binding(6) var<storage, read_write> mirror_normal: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> mirror_to_eye: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> mirror_right: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.width + params.first.x + id.x - params.first_pixel;
    let out = (y - params.first.y) * params.size.x + id.x;
    let its_region = region[here];
    let at = point[here];
    if its_region == 0u || at.w <= 0.0 {
        mirror_position[out] = vec4u(0u);
        mirror_normal[out] = vec4f(0.0);
        mirror_to_eye[out] = vec4f(0.0);
        mirror_right[out] = vec4f(0.0);
        return;
    }
    let its = normal[here];
    let to_eye = unit_or_zero(eye_of(params.eye, here) - at.xyz);
    let right = unit_or_zero(params.right - to_eye * dot3(params.right, to_eye));
    let n = mirror_space(right, to_eye, its.xyz);
    let reflected = n.xy / max(n.z, SMALLEST_COSINE);
    mirror_position[out] = vec4u(bitcast<vec3u>(at.xyz), its_region);
    mirror_normal[out] = its;
    mirror_to_eye[out] = vec4f(to_eye, reflected.x);
    mirror_right[out] = vec4f(right, reflected.y);
}
