// Turns sums into the one surfel that a mirror pixel shows.
// One thread per pixel. CPU twin: averaging in `Context::passes` of src/reflect/sscr/accumulate.rs.
#import hit_params
#import average
#import depth_key

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

@group(0) @binding(0) var<uniform> params: HitParams;
@group(0) @binding(1) var<storage, read> fronts: array<u32>;
@group(0) @binding(2) var<storage, read> sums: array<vec4i>;
@group(0) @binding(3) var<storage, read_write> surface: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> albedo: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> material: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> count: array<u32>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let pixel = y * params.size.x + id.x - params.first_pixel;
    let depth_sums = vec4f(sums[pixel * 3u]);
    let key = ~fronts[pixel * 3u];
    if key == EMPTY || depth_sums.x <= 0.0 {
        return;
    }
    let shown = averaged(key_depth(key), depth_sums, vec4f(sums[pixel * 3u + 1u]), vec4f(sums[pixel * 3u + 2u]));
    surface[pixel] = shown.surface;
    albedo[pixel] = shown.albedo;
    material[pixel] = shown.material;
    count[pixel] = fronts[pixel * 3u + 2u];
}
