// Fills the mirrors' holes from one level of the pyramid; finer levels come first.
// One thread per pixel. CPU twin: `pull_push` in src/gbuffer/pull_push.rs.
#import pull

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct PushParams {
    size: vec2u,        // of the picture, pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    first_cell: u32,    // number of the level's first cell in its binding, row by row
    width: u32,         // of the level, cells
    level: u32,         // halvings
}

@group(0) @binding(0) var<uniform> params: PushParams;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> origin: array<vec4f>;
@group(0) @binding(3) var<storage, read> direction: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> surface: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> albedo: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> material: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> level: array<f32>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let y = params.rows.x + id.y;
    if id.x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + id.x - params.first_pixel;
    if origin[here].w == 0.0 || material[here].w > 0.0 {
        return;
    }
    let cell = cells[(y >> params.level) * params.width + (id.x >> params.level) - params.first_cell];
    if cell.material.w <= 0.0 {
        return;
    }
    // Where the pixel's ray meets the cell's plane; the distance of the cell itself where it meets it too flatly.
    let normal = cell.surface.xyz;
    let to_position = cell.position.xyz - origin[here].xyz;
    let met = dot3(normal, to_position) / dot3(normal, direction[here].xyz);
    let own = sqrt(dot3(to_position, to_position));
    surface[here] = vec4f(normal, select(own, met, met > 0.5 * own && met < 2.0 * own));
    albedo[here] = cell.albedo;
    material[here] = vec4f(cell.material.xyz, 1.0);
    level[here] = f32(params.level);
}
