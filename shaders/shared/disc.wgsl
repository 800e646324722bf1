// A surfel as the oriented disc that a pinhole sees, and its fragments. Twin: src/gbuffer/disc.rs.
#import splat
#import surfel
#import weight

override EDGE_ON_COSINE_SQUARED: f32;
override MAX_TOLERANCE_SLOPE: f32;
override RIM: f32;
override BOUNDS_SLACK: f32;   // pixels

struct Disc {
    seen: bool,
    centre: vec3f,       // view space
    plane: vec3f,        // 1 / depth is linear in the ray's slopes with these factors
    half_squared: f32,
    inverse_half_squared: f32,
    tolerance: f32,      // a fragment this far from the nearest is still blended
    class_bits: u32,     // what it may blend with: 0 diffuse points, 1 fronts, 2 backs of mirrors
    behind: bool,        // seen from behind
    first: vec2u,        // pixels that it may cover
    end: vec2u,
}

// First and one past the last pixel between two coordinates.
fn pixel_span(first: f32, last: f32, size: u32) -> vec2u {
    let limit = f32(size);
    let start = clamp(first + 0.5 - BOUNDS_SLACK, 0.0, limit);
    let end = clamp(last + 0.5 + BOUNDS_SLACK, 0.0, limit);
    return vec2u(u32(start), u32(end));
}

fn low_slope(v: f32, nearest: f32, farthest: f32) -> f32 {
    return v * select(farthest, nearest, v < 0.0);
}

fn high_slope(v: f32, nearest: f32, farthest: f32) -> f32 {
    return v * select(farthest, nearest, v > 0.0);
}

fn extent(half: f32, n: f32) -> f32 {
    return half * sqrt(max(1.0 - n * n, 0.0));
}

fn disc(place: vec4f, finish: vec4u, params: SplatParams) -> Disc {
    var d: Disc;
    let pinhole = params.pinhole;
    let centre = view_from_world(pinhole, place.xyz);
    if !(centre.z >= pinhole.near && centre.z <= pinhole.far) {
        return d;
    }
    let normal = view_from_world_direction(pinhole, finish_normal(finish));
    let along = dot3(normal, centre);
    let cosine_squared = along * along / dot3(centre, centre);
    if !(cosine_squared >= EDGE_ON_COSINE_SQUARED) {
        return d;
    }
    let half = max(params.size * place.w, params.min_half_width * centre.z * pinhole.inverse_focal);

    // Pixels under the box around the disc.
    let reach = vec3f(extent(half, normal.x), extent(half, normal.y), extent(half, normal.z));
    let nearest = 1.0 / max(centre.z - reach.z, pinhole.near);
    let farthest = 1.0 / (centre.z + reach.z);
    let left = pinhole.centre.x + pinhole.focal * low_slope(centre.x - reach.x, nearest, farthest);
    let right = pinhole.centre.x + pinhole.focal * high_slope(centre.x + reach.x, nearest, farthest);
    let top = pinhole.centre.y - pinhole.focal * high_slope(centre.y + reach.y, nearest, farthest);
    let bottom = pinhole.centre.y - pinhole.focal * low_slope(centre.y - reach.y, nearest, farthest);
    let columns = pixel_span(left, right, pinhole.size.x);
    let rows = pixel_span(top, bottom, pinhole.size.y);

    let slope = min(sqrt(max(1.0 / cosine_squared - 1.0, 0.0)), MAX_TOLERANCE_SLOPE);
    let inverse = 1.0 / along;
    d.seen = true;
    d.centre = centre;
    d.plane = vec3f(normal.x * inverse, normal.y * inverse, normal.z * inverse);
    d.half_squared = half * half;
    d.inverse_half_squared = 1.0 / d.half_squared;
    d.tolerance = place.w * (params.depth_tolerance + slope);
    d.behind = along > 0.0;
    if finish_mirror(finish) > 0.0 {
        d.class_bits = select(1u, 2u, d.behind);
    }
    d.first = vec2u(columns.x, max(rows.x, params.rows.x));
    d.end = vec2u(columns.y, min(rows.y, params.rows.y));
    return d;
}

struct Fragment {
    covered: bool,
    depth: f32,
    distance_squared: f32, // from the disc's centre
}

fn fragment(d: Disc, x: u32, y: u32, pinhole: Pinhole) -> Fragment {
    let slope = slope_from_pixel(pinhole, vec2f(f32(x) + 0.5, f32(y) + 0.5));
    // The row's share first: a compiler may reorder a sum of two products and a term, but not this.
    let inverse_depth = d.plane.x * slope.x + (d.plane.y * slope.y + d.plane.z);
    let depth = 1.0 / inverse_depth;
    let from_centre = vec3f(slope.x * depth - d.centre.x, slope.y * depth - d.centre.y, depth - d.centre.z);
    var f: Fragment;
    f.depth = depth;
    f.distance_squared = dot3(from_centre, from_centre);
    f.covered = f.distance_squared <= d.half_squared && depth >= pinhole.near && depth <= pinhole.far;
    return f;
}
