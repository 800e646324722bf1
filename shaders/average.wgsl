// Turns sums into the one surfel that a pixel shows.
// One thread per pixel. CPU twin: `average` in src/gbuffer/average.rs.
#import splat
#import depth_key
#import average

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

@group(0) @binding(0) var<uniform> params: SplatParams;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read> sums: array<vec4i>;
@group(0) @binding(3) var<storage, read_write> surface: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> albedo: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> material: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.pinhole.size.x || y >= params.rows.y {
        return;
    }
    let pixel = y * params.pinhole.size.x + id.x - params.first_pixel;
    let key = keys[pixel];
    let depth_sums = vec4f(sums[pixel * 3u]);
    if key == EMPTY || depth_sums.x <= 0.0 {
        surface[pixel] = vec4f(0.0);
        albedo[pixel] = vec4f(0.0);
        material[pixel] = vec4f(0.0);
        return;
    }
    let shown = averaged(key_depth(key), depth_sums, vec4f(sums[pixel * 3u + 1u]), vec4f(sums[pixel * 3u + 2u]));
    surface[pixel] = shown.surface;
    albedo[pixel] = shown.albedo;
    material[pixel] = shown.material;
}
