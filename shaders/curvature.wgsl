// How the mirrors bend, and where they break off: one byte a pixel.
// One thread per four pixels, which share a word. CPU twin: `curvature` in src/reflect/sscr/curvature.rs.
#import unit

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override CONCAVE: u32;
override CONVEX: u32;
override PLANAR: u32;
override Y_SHIFT: u32;
override X_STEP: u32;
override Y_STEP: u32;
override MIN_STEP_SINE: f32;

struct CurvatureParams {
    right: vec3f,               // along what the normal's change is measured, unit vectors
    planar_threshold: f32,      // change of the unit normal per pixel
    down: vec3f,
    depth_step: f32,            // over the local spacing
    size: vec2u,                // pixels
    words: vec2u,               // first, and one past the last; of the whole picture
    first_pixel: u32,           // number of the bindings' first pixel, row by row
    threads: u32,               // in a row of the dispatch
    screen: u32,                // 1: along `right` and `down`; 0: along the way from the previous pixel
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: CurvatureParams;
@group(0) @binding(1) var<storage, read> point: array<vec4f>;
@group(0) @binding(2) var<storage, read> normal: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;

struct Bend {
    class_bits: u32,
    step: bool,
}

// Class and step from the mirror at the pixel `previous`, if there is one, to that at `here`.
fn compare(here: u32, previous: u32, axis: vec3f) -> Bend {
    let before = point[previous];
    if before.w <= 0.0 {
        return Bend(PLANAR, false);
    }
    let way = point[here].xyz - before.xyz;
    let n = normal[here];
    let other = normal[previous];
    let gap = 0.5 * abs(dot3(n.xyz + other.xyz, way));
    let limit = params.depth_step * max(n.w, other.w);
    // What is not a number breaks off.
    if !(gap <= max(limit, MIN_STEP_SINE * sqrt(dot3(way, way)))) {
        return Bend(PLANAR, true);
    }
    var along = axis;
    if params.screen == 0u {
        along = unit_or_zero(way);
    }
    let change = dot3(n.xyz - other.xyz, along);
    if change > params.planar_threshold {
        return Bend(CONVEX, false);
    }
    if change < -params.planar_threshold {
        return Bend(CONCAVE, false);
    }
    return Bend(PLANAR, false);
}

// The byte of a pixel, counted row by row over the whole picture.
fn cell(pixel: u32) -> u32 {
    let here = pixel - params.first_pixel;
    if pixel >= params.size.x * params.size.y || point[here].w <= 0.0 {
        return 0u;
    }
    var x = Bend(PLANAR, false);
    var y = Bend(PLANAR, false);
    if pixel % params.size.x > 0u {
        x = compare(here, here - 1u, params.right);
    }
    if pixel >= params.size.x {
        y = compare(here, here - params.size.x, params.down);
    }
    return x.class_bits | (y.class_bits << Y_SHIFT) | select(0u, X_STEP, x.step) | select(0u, Y_STEP, y.step);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let word = params.words.x + id.y * params.threads + id.x;
    if id.x >= params.threads || word >= params.words.y {
        return;
    }
    var bytes = 0u;
    for (var k = 0u; k < 4u; k++) {
        bytes |= cell(word * 4u + k) << (8u * k);
    }
    cells[word - params.first_pixel / 4u] = bytes;
}
