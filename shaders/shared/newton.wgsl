// Gauss-Newton steps towards the place where the mirrors show a point. Twin: src/reflect/sscr/newton.rs.
#import field
#import pinhole

override MAX_STEPS: u32;
override LONGEST_STEP: f32;     // pixels
override HALVINGS: u32;
override LAST_STEP: f32;        // pixels
override RESIDUAL: f32;
override RESIDUAL_FLOOR: f32;
override FOLD: f32;
override DAMPING: f32;

struct Step {
    step: vec2f,            // pixels
    left_squared: f32,      // what it leaves of the error's square
    slopes_squared: f32,
    distance: f32,          // from the mirror's point to the point
    magnification: vec2f,   // pixels a unit sideways, at most
}

fn newton_step(s: Sample, point: vec3f, damped: bool) -> Step {
    let to_point = point - s.point;
    let distance = sqrt(dot3(to_point, to_point));
    let inverse = 1.0 / distance;
    let l = to_point * inverse;
    let error = s.ray - l;
    let right = s.ray_x + (s.point_x - l * dot3(l, s.point_x)) * inverse;
    let down = s.ray_y + (s.point_y - l * dot3(l, s.point_y)) * inverse;
    var a = dot3(right, right);
    let b = dot3(right, down);
    var c = dot3(down, down);
    let gx = dot3(right, error);
    let gy = dot3(down, error);
    let slopes_squared = a + c;
    var determinant = a * c - b * b;
    if damped && determinant < FOLD * a * c {
        a *= 1.0 + DAMPING;
        c *= 1.0 + DAMPING;
        determinant = a * c - b * b;
    }
    let over = 1.0 / determinant;
    var out: Step;
    out.step = vec2f(gy * b - gx * c, gx * b - gy * a) * over;
    out.left_squared = dot3(error, error) + out.step.x * gx + out.step.y * gy;
    out.slopes_squared = slopes_squared;
    out.distance = distance;
    out.magnification = vec2f(sqrt(abs(c * over)), sqrt(abs(a * over))) * inverse;
    return out;
}

struct Place {
    at: vec2f,
    inside: bool,   // the field
}

// The place that a step leads to; a step that leaves the field is halved.
fn take_step(origin: vec2f, first_step: vec2f) -> Place {
    var step = first_step;
    var place: Place;
    for (var k = 0u; k <= HALVINGS; k++) {
        place.at = origin + step;
        place.inside = sides(place.at) > 0u;
        if place.inside {
            break;
        }
        step *= 0.5;
    }
    return place;
}

struct Root {
    found: bool,
    at: vec2f,
    distance: f32,
    magnification: vec2f,
    spacing: f32,
    at_end: bool,
    steps: u32,
}

// Searches from a place of the field on, no farther than `reach` from `centre` along either axis.
fn newton(start: vec2f, point: vec3f, centre: vec2f, reach: f32) -> Root {
    var root: Root;
    var at = start;
    for (var steps = 1u; steps <= MAX_STEPS; steps++) {
        root.steps = steps;
        let here = field_sample(at);
        let s = newton_step(here, point, true);
        let length = sqrt(s.step.x * s.step.x + s.step.y * s.step.y);
        // What is not a number ends the search.
        if !(length < 3.4e38) {
            return root;
        }
        let last = length < LAST_STEP;
        if last && s.left_squared >= RESIDUAL_FLOOR + RESIDUAL * s.slopes_squared {
            return root;
        }
        let taken = s.step * min(LONGEST_STEP / length, 1.0);
        let off = abs(at + taken - centre);
        if !(max(off.x, off.y) <= reach) {
            return root;
        }
        let next = take_step(at, taken);
        if !next.inside {
            return root;
        }
        at = next.at;
        if last {
            root.found = is_inside(at);
            root.at = at;
            root.distance = s.distance;
            root.magnification = s.magnification;
            root.spacing = here.spacing;
            root.at_end = sides(at) > 1u;
            return root;
        }
    }
    return root;
}
