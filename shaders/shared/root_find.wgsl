// The search for the pixel of a mirror region that shows a point. Twin: `RootFinder` in src/reflect/sscr/root_find.rs.
// Reads `params`, `regions` and the buffers `mirror_...` of the kernel that imports it.
#import mirror_space
#import distribute

override SMALLEST_STEP: f32;    // pixels

struct RootFindParams {
    distribute: DistributeParams,
    first: vec2u,           // of the rectangle that the mirrors are laid out in, pixels
    size: vec2u,            // of that, pixels
    first_point: u32,       // of the band
    end_point: u32,         // of the band
    band_start: u32,        // number of the band's first point in the cloud
    seed_attempts: u32,
    step_attempts: u32,
    max_steps: u32,
    initial_step: f32,      // over the region's box
    threshold: f32,         // pixels
    self_hit: f32,          // over the local spacing
    max_splat: f32,         // pixels
    far: f32,               // where splats are one pixel
    chunk: u32,             // number of the dispatch, whose counts go to a place of their own
}

// A place in the region, and the error there.
struct Probe {
    inside: bool,
    at: vec2f,
    error: vec2f,
}

struct Outcome {
    found: bool,
    placed: bool,       // both seeds lay in the region
    pixel: vec2f,       // where the point is seen, or where the search ended
    distance: f32,
    residual: f32,
    steps: u32,
}

// The steps of both axes.
struct Steps {
    direction: vec2f,
    size: vec2f,
}

// One step of a permuted linear congruence. Twin: src/reflect/sscr/random.rs.
fn scramble(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn random(state: ptr<function, u32>) -> f32 {
    *state = scramble(*state);
    return f32(*state >> 8u) * (1.0 / 16777216.0);
}

// Where the mirror at a place is laid out; `NOWHERE` outside of the region.
const NOWHERE: u32 = 0xffffffffu;

fn mirror_at(at: vec2f, label: u32) -> u32 {
    let first = vec2f(params.first);
    let end = vec2f(params.first + params.size);
    if !(at.x >= first.x && at.y >= first.y && at.x < end.x && at.y < end.y) {
        return NOWHERE;
    }
    let pixel = vec2u(at) - params.first;
    let index = pixel.y * params.size.x + pixel.x;
    return select(NOWHERE, index, mirror_position[index].w == label);
}

fn error_at(mirror: u32, point: vec3f) -> vec2f {
    let to_eye = mirror_to_eye[mirror];
    let right = mirror_right[mirror];
    let to_point = point - bitcast<vec3f>(mirror_position[mirror].xyz);
    return mirror_error(right.xyz, to_eye.xyz, vec2f(to_eye.w, right.w), to_point);
}

fn probe(at: vec2f, point: vec3f, label: u32) -> Probe {
    let mirror = mirror_at(at, label);
    if mirror == NOWHERE {
        return Probe(false, at, vec2f(0.0));
    }
    return Probe(true, at, error_at(mirror, point));
}

fn seed(region: Region, point: vec3f, label: u32, state: ptr<function, u32>) -> Probe {
    var seeded = Probe(false, vec2f(0.0), vec2f(0.0));
    for (var k = 0u; k <= params.seed_attempts && !seeded.inside; k++) {
        let u = random(state);
        let v = random(state);
        let within = floor(vec2f(u, v) * vec2f(region.size)) + 0.5;
        seeded = probe(vec2f(region.first) + within, point, label);
    }
    return seeded;
}

fn opposite(a: vec2f, b: vec2f) -> vec2<bool> {
    return (a < vec2f(0.0)) != (b < vec2f(0.0));
}

// Turns round, and halves the step, as the errors before and after a step say.
fn turn(steps: ptr<function, Steps>, before: vec2f, after: vec2f) {
    let passed = opposite(before, after);
    let farther = abs(after) >= abs(before);
    (*steps).direction *= select(vec2f(1.0), vec2f(-1.0), passed | farther);
    (*steps).size *= select(vec2f(1.0), vec2f(0.5), passed);
}

// Where between two places the error vanishes, if it runs straight.
fn between(first: f32, last: f32, first_error: f32, last_error: f32) -> f32 {
    let a = abs(first_error);
    let sum = a + abs(last_error);
    var part = 0.5;
    if sum > 0.0 {
        part = a / sum;
    }
    return first + (last - first) * part;
}

// The root between two places, unless the point lies behind the mirror there, or belongs to it.
fn accept(first: Probe, second: Probe, point: vec3f, label: u32, steps: u32) -> Outcome {
    let lost = Outcome(false, true, second.at, 0.0, 0.0, steps);
    let a = floor(first.at) + 0.5;
    let b = floor(second.at) + 0.5;
    let pixel = vec2f(
        between(a.x, b.x, first.error.x, second.error.x),
        between(a.y, b.y, first.error.y, second.error.y),
    );
    // Between two pixels of the region there may be one of another.
    var mirror = mirror_at(pixel, label);
    if mirror == NOWHERE {
        mirror = mirror_at(b, label);
    }
    if mirror == NOWHERE {
        return lost;
    }
    let to_point = point - bitcast<vec3f>(mirror_position[mirror].xyz);
    let distance = sqrt(dot3(to_point, to_point));
    let normal = mirror_normal[mirror];
    if dot3(normal.xyz, to_point) <= 0.0 || distance < params.self_hit * normal.w {
        return lost;
    }
    let error = error_at(mirror, point);
    return Outcome(true, true, pixel, distance, sqrt(error.x * error.x + error.y * error.y), steps);
}

// Searches a region (counted from 0) for the point of that number in the cloud.
fn root_find(index: u32, point: vec3f, region_index: u32) -> Outcome {
    let region = regions[region_index];
    let label = region_index + 1u;
    var state = scramble(index);
    var first = seed(region, point, label, &state);
    if !first.inside {
        return Outcome();
    }
    var second = seed(region, point, label, &state);
    if !second.inside {
        return Outcome();
    }
    var steps = Steps(
        select(vec2f(1.0), vec2f(-1.0), second.at < first.at),
        vec2f(region.size) * params.initial_step,
    );
    for (var count = 0u; count <= params.max_steps; count++) {
        // The root lies between two near places of opposite errors.
        let apart = first.at - second.at;
        let near = apart.x * apart.x + apart.y * apart.y < params.threshold * params.threshold;
        if near && all(opposite(first.error, second.error)) {
            return accept(first, second, point, label, count);
        }
        turn(&steps, first.error, second.error);
        if count == params.max_steps || max(steps.size.x, steps.size.y) < SMALLEST_STEP {
            return Outcome(false, true, second.at, 0.0, 0.0, count);
        }
        // A step that leaves the region is halved.
        var next = probe(second.at + steps.direction * steps.size, point, label);
        for (var k = 0u; k < params.step_attempts && !next.inside; k++) {
            steps.size *= 0.5;
            next = probe(second.at + steps.direction * steps.size, point, label);
        }
        if !next.inside {
            return Outcome(false, true, second.at, 0.0, 0.0, count);
        }
        first = second;
        second = next;
    }
    return Outcome(false, true, second.at, 0.0, 0.0, params.max_steps);
}
