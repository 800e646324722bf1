// Merges interleaved pixels in one direction: across the rows, or down the columns.
// One thread per pixel. CPU twin: `indirect_filter` in src/gi/indirect_filter.rs.
#import dot3

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override PLANE_SLOPE: f32;
override PLANE_SPACINGS: f32;
override NORMAL_COSINE: f32;
override ALIKE: f32;

struct FilterParams {
    size: vec2u,        // of the picture, pixels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    width: i32,         // pixels of the window on each side
    stride: i32,        // from pixel to pixel of the window
    down: u32,          // 1: down the columns
}

@group(0) @binding(0) var<uniform> params: FilterParams;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(2) var<storage, read> normals: array<vec4f>;
@group(0) @binding(3) var<storage, read> irradiance: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> filtered: array<vec4f>;

// How much alike two receivers are, 0 to 1.
fn likeness(position: vec4f, normal: vec3f, other: vec4f, other_normal: vec3f) -> f32 {
    let between = other.xyz - position.xyz;
    // On an edge a blended normal is neither side's: either plane may be the one.
    let off = min(abs(dot3(normal, between)), abs(dot3(other_normal, between)));
    let spacing = PLANE_SPACINGS * position.w;
    let limit_squared = PLANE_SLOPE * PLANE_SLOPE * dot3(between, between) + spacing * spacing;
    let plane = max(1.0 - off * off / limit_squared, 0.0);
    let turned = (dot3(normal, other_normal) - NORMAL_COSINE) / (1.0 - NORMAL_COSINE);
    return plane * max(turned, 0.0);
}

// What a pixel of the window adds.
struct Tap {
    value: vec4f,
    weight: f32,
}

fn tap(id: vec2i, step: i32, share: f32, position: vec4f, normal: vec3f) -> Tap {
    var pixel = id;
    if params.down == 1u {
        pixel.y += step * params.stride;
    } else {
        pixel.x += step * params.stride;
    }
    if any(pixel < vec2i(0)) || any(pixel >= vec2i(params.size)) {
        return Tap(vec4f(0.0), 0.0);
    }
    let there = u32(pixel.y) * params.size.x + u32(pixel.x) - params.first_pixel;
    if !(positions[there].w > 0.0) {
        return Tap(vec4f(0.0), 0.0);
    }
    let weight = share * likeness(position, normal, positions[there], normals[there].xyz);
    return Tap(irradiance[there] * weight, weight);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + x - params.first_pixel;
    let position = positions[here];
    if !(position.w > 0.0) {
        filtered[here] = vec4f(0.0);
        return;
    }
    let normal = normals[here].xyz;
    let pixel = vec2i(i32(x), i32(y));
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var step = 0; step < params.width; step++) {
        let share = f32(step) / f32(params.width);
        let one = tap(pixel, step, 1.0 - share, position, normal);
        let other = tap(pixel, step - params.width, share, position, normal);
        let pair = one.weight + other.weight;
        if pair > 0.0 {
            let counts = min(pair / ALIKE, 1.0);
            sum += (one.value + other.value) * (counts / pair);
            weights += counts;
        }
    }
    if weights > 0.0 {
        filtered[here] = sum / weights;
    } else {
        filtered[here] = irradiance[here];
    }
}
