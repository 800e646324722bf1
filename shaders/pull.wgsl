// A level of the pyramid that fills holes, from the finer one below it.
// One thread per cell. CPU twin: `pull_push` in src/gbuffer/pull_push.rs.
#import pull

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

@group(0) @binding(0) var<uniform> params: PullParams;
@group(0) @binding(1) var<storage, read> below: array<Cell>;
@group(0) @binding(2) var<storage, read_write> cells: array<Cell>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    var four = array<Cell, 4>();
    for (var k = 0u; k < 4u; k++) {
        let u = 2u * id.x + (k & 1u);
        let v = 2u * y + (k >> 1u);
        if u < params.below.x && v < params.below.y {
            four[k] = below[v * params.below.x + u - params.first_below];
        }
    }
    cells[y * params.size.x + id.x - params.first_cell] = pull(&four);
}
