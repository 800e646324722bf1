// A cell of the pyramid that fills holes. Twin: `Cell` and `pull` in src/gbuffer/pull_push.rs.
#import pinhole

struct Cell {
    surface: vec4f,     // unit normal, and distance
    albedo: vec4f,      // and mirror reflectance
    material: vec4f,    // specular, shininess, radius; w is the cell's weight, 0 where it shows nothing
    position: vec4f,    // relative to the scene's origin; w is 0
}

struct PullParams {
    size: vec2u,        // of the level, cells
    below: vec2u,       // of the level below
    rows: vec2u,        // of the level: first, and one past the last
    first_cell: u32,    // number of the level's first cell in its binding, row by row
    first_below: u32,   // as `first_cell`, of the level below
}

fn weight_of(cells: ptr<function, array<Cell, 4>>, mirror: bool) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let its = (*cells)[k].material.w;
        if its > 0.0 && ((*cells)[k].albedo.w > 0.0) == mirror {
            sum += its;
        }
    }
    return sum;
}

// Mirrors and other points never blend: the class of most of the four, of the others where both have as many.
fn pull(cells: ptr<function, array<Cell, 4>>) -> Cell {
    var pulled = Cell();
    let mirrors = weight_of(cells, true);
    let others = weight_of(cells, false);
    let mirror = mirrors > others;
    let total = select(others, mirrors, mirror);
    if total <= 0.0 {
        return pulled;
    }
    for (var k = 0u; k < 4u; k++) {
        let cell = (*cells)[k];
        if cell.material.w > 0.0 && (cell.albedo.w > 0.0) == mirror {
            let share = cell.material.w / total;
            pulled.surface += cell.surface * share;
            pulled.albedo += cell.albedo * share;
            pulled.material += cell.material * share;
            pulled.position += cell.position * share;
        }
    }
    let normal = pulled.surface.xyz;
    let inverse = 1.0 / sqrt(dot3(normal, normal));
    let sound = inverse > 0.0 && inverse <= 3.4028235e38;
    pulled.surface = vec4f(select(vec3f(0.0, 0.0, 1.0), normal * inverse, sound), pulled.surface.w);

    // Coarser levels count pixels, not weight: a lone pixel fills as well as four.
    pulled.material.w = min(total, 1.0);
    return pulled;
}
