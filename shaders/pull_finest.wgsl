// The finest level of the pyramid that fills holes: what four mirror pixels show.
// One thread per cell. CPU twin: `pull_push` in src/gbuffer/pull_push.rs.
#import pull

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

@group(0) @binding(0) var<uniform> params: PullParams;
@group(0) @binding(1) var<storage, read> origin: array<vec4f>;
@group(0) @binding(2) var<storage, read> direction: array<vec4f>;
@group(0) @binding(3) var<storage, read> surface: array<vec4f>;
@group(0) @binding(4) var<storage, read> albedo: array<vec4f>;
@group(0) @binding(5) var<storage, read> material: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> cells: array<Cell>;

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
        if u >= params.below.x || v >= params.below.y {
            continue;
        }
        let pixel = v * params.below.x + u - params.first_below;
        if material[pixel].w > 0.0 {
            let its = surface[pixel];
            let position = origin[pixel].xyz + direction[pixel].xyz * its.w;
            four[k] = Cell(its, albedo[pixel], vec4f(material[pixel].xyz, 1.0), vec4f(position, 0.0));
        }
    }
    cells[y * params.size.x + id.x - params.first_cell] = pull(&four);
}
