// Marks gaps through which the background shows between the points of a nearer surface.
// One thread per pixel. CPU twin: `leaks` in src/gbuffer/leak.rs.
#import ring
#import neighbours

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override LEAK_NEIGHBOURS: u32;
override LEAK_REACH: i32;
override LEAK_SPACINGS: f32;

@group(0) @binding(0) var<uniform> params: RingParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
// A marked pixel still counts as seen for its neighbours, so that their order does not matter.
@group(0) @binding(3) var<storage, read_write> material: array<vec4f>;

// A nearer pixel in one direction.
struct Edge {
    steps: i32,     // to it, from 1; 0 where there is none
    spacing: f32,   // of its surface, pixels
}

// Step to the neighbour `k` of nine, row by row; 4 is the pixel itself.
fn step_of(k: u32) -> vec2i {
    return vec2i(i32(k % 3u) - 1, i32(k / 3u) - 1);
}

fn pixel_of(at: vec2u) -> u32 {
    return at.y * params.pinhole.size.x + at.x - params.first_pixel;
}

// The first pixel from `start` along `step` that is nearer than `depth` by more than the tolerance.
fn edge(start: vec2i, step: vec2i, depth: f32) -> Edge {
    for (var steps = 1; steps <= LEAK_REACH; steps++) {
        let at = start + steps * step;
        if any(at < vec2i(0)) || any(at >= vec2i(params.pinhole.size)) {
            break;
        }
        let pixel = pixel_of(vec2u(at));
        // Empty pixels have depth 0.
        let its_depth = surface[pixel].w;
        if its_depth > 0.0 && its_depth < depth {
            let radius = material[pixel].z;
            if its_depth + AGREE_SPACINGS * radius < depth {
                return Edge(steps, radius * params.pinhole.focal / its_depth);
            }
        }
    }
    return Edge(0, 0.0);
}

// Whether the gap between two edges, in opposite directions along `step`, is one that points leave.
fn narrow(a: Edge, b: Edge, step: vec2i) -> bool {
    if a.steps == 0 || b.steps == 0 {
        return false;
    }
    let width = f32(a.steps + b.steps - 1) * sqrt(f32(step.x * step.x + step.y * step.y));
    return a.steps + b.steps == 2 || width <= LEAK_SPACINGS * min(a.spacing, b.spacing);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = params.pinhole.size;
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= size.x || y >= params.rows.y {
        return;
    }
    let here = y * size.x + x - params.first_pixel;
    if material[here].w <= 0.0 {
        return;
    }
    let depth = surface[here].w;
    let towards = direction_of(params.pinhole, x, y);

    // Few pixels have nearer ones all around: only they are worth the vote.
    var seen: Neighbours;
    var edges: array<Edge, 9>;
    var direct = 0u;
    var missing = 0u;
    for (var k = 0u; k < 9u; k++) {
        if k == 4u {
            continue;
        }
        let found = edge(vec2i(i32(x), i32(y)), step_of(k), depth);
        if found.steps == 0 {
            missing++;
            if missing + LEAK_NEIGHBOURS > 8u {
                return;
            }
            continue;
        }
        edges[k] = found;
        direct += select(0u, 1u, found.steps == 1);
        let at = vec2u(vec2i(i32(x), i32(y)) + found.steps * step_of(k));
        seen.all[seen.count] = neighbour(params.pinhole, pixel_of(at), at, towards);
        seen.count++;
    }
    // Opposite directions are as far from either end.
    var all_narrow = true;
    for (var k = 0u; k < 4u; k++) {
        all_narrow = all_narrow && narrow(edges[k], edges[8u - k], step_of(k));
    }
    if direct < LEAK_NEIGHBOURS && !all_narrow {
        return;
    }
    let best = vote(&seen);
    let chosen = seen.all[best.chosen];
    if best.votes >= LEAK_NEIGHBOURS && chosen.depth + AGREE_SPACINGS * chosen.radius < depth {
        material[here].w = LEAK;
    }
}
