// Where the searches of all points end: how many found and lost their point in each pixel, after how many steps.
// One thread per point. CPU twin: `search_heat` in src/reflect/sscr/heat.rs.
#import root_find

override POINT_GROUP: u32 = 64u; // threads per workgroup
override RESIDUAL_SCALE: f32;
override MAX_RESIDUAL: f32;

@group(0) @binding(0) var<uniform> params: RootFindParams;
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read> regions: array<Region>;
@group(0) @binding(3) var<storage, read> mirror_position: array<vec4u>;
@group(0) @binding(4) var<storage, read> mirror_normal: array<vec4f>;
@group(0) @binding(5) var<storage, read> mirror_to_eye: array<vec4f>;
@group(0) @binding(6) var<storage, read> mirror_right: array<vec4f>;
// Six to a pixel of the rectangle, in the order of `HeatSums`.
@group(0) @binding(7) var<storage, read_write> sums: array<atomic<u32>>;

// Adds to a sum of 64 bits, its low word first. The carries are as many in whatever order values come.
fn add(slot: u32, value: u32) {
    let before = atomicAdd(&sums[slot], value);
    if before > 0xffffffffu - value {
        atomicAdd(&sums[slot + 1u], 1u);
    }
}

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let point = params.first_point + id.x;
    if point >= params.end_point {
        return;
    }
    let index = params.band_start + point;
    let outcome = root_find(index, places[point].xyz, distribute(index));
    if !outcome.placed {
        return;
    }
    let pixel = vec2u(outcome.pixel) - params.first;
    let slot = (pixel.y * params.size.x + pixel.x) * 6u;
    if !outcome.found {
        atomicAdd(&sums[slot + 5u], 1u);
        return;
    }
    add(slot, outcome.steps);
    add(slot + 2u, u32(min(outcome.residual, MAX_RESIDUAL) * RESIDUAL_SCALE));
    atomicAdd(&sums[slot + 4u], 1u);
}
