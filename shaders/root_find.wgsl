// Searches each point in the region that it is given, and appends the pixels that show them.
// One thread per point. CPU twin: `root_find` in src/reflect/sscr/root_find.rs.
#import root_find
#import hits

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: RootFindParams;
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read> regions: array<Region>;
@group(0) @binding(3) var<storage, read> mirror_position: array<vec4u>;
@group(0) @binding(4) var<storage, read> mirror_normal: array<vec4f>;
@group(0) @binding(5) var<storage, read> mirror_to_eye: array<vec4f>;
@group(0) @binding(6) var<storage, read> mirror_right: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> hits: array<Hit>;
// Hits in the list; then, for each dispatch, the steps of its searches.
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;

var<workgroup> group_steps: atomic<u32>;

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    let point = params.first_point + id.x;
    if point < params.end_point {
        let index = params.band_start + point;
        let outcome = root_find(index, places[point].xyz, distribute(index));
        if outcome.steps > 0u {
            atomicAdd(&group_steps, outcome.steps);
        }
        if outcome.found {
            // Splats shrink with the distance to one pixel.
            let nearness = max(1.0 - outcome.distance / params.far, 0.0);
            let reach = 0.5 * (1.0 + (params.max_splat - 1.0) * nearness);
            append(Hit(outcome.pixel, vec2f(reach), index, outcome.distance));
        }
    }
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&counts[1u + params.chunk], atomicLoad(&group_steps));
    }
}
