// Counts the mirrors' pixels that show something.
// One thread per pixel. CPU twin: `MirrorGBuffer::coverage` in src/reflect/mirror_gbuffer.rs.
#import coverage

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

@group(0) @binding(0) var<uniform> params: CoverageParams;
@group(0) @binding(1) var<storage, read> origin: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read> material: array<vec4f>;
// Of mirrors; of them, those that show something; of these, those that show a mirror.
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>, 3>;

var<workgroup> group_counts: array<atomic<u32>, 3>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    let y = params.first_row + id.y;
    if id.x < params.width && y < params.end_row {
        let pixel = y * params.width + id.x - params.first_pixel;
        if origin[pixel].w > 0.0 {
            atomicAdd(&group_counts[0], 1u);
        }
        if material[pixel].w > 0.0 {
            atomicAdd(&group_counts[1], 1u);
            if albedo[pixel].w > 0.0 {
                atomicAdd(&group_counts[2], 1u);
            }
        }
    }
    workgroupBarrier();
    if thread < 3u {
        atomicAdd(&counts[thread], atomicLoad(&group_counts[thread]));
    }
}
