// A hit as a splat in the mirror, and its fragments. Twin: src/reflect/sscr/accumulate.rs.
// Reads `params`, `places`, `finishes`, `region`, `origin` and `direction` of the kernel that imports it.
#import hit
#import hit_params
#import pinhole
#import surfel
#import weight
#import depth_key

override DEPTH_RANGE: f32;
override LARGEST_REACH: f32;            // pixels
override EDGE_ON_COSINE_SQUARED: f32;
override MAX_TOLERANCE_SLOPE: f32;

struct HitSplat {
    seen: bool,
    place: vec4f,
    finish: vec4u,
    normal: vec3f,
    pixel: vec2f,
    reach: vec2f,
    distance: f32,
    radius: f32,        // of the surfel as it is drawn
    region: u32,
    first: vec2u,       // pixels that it may cover
    end: vec2u,
}

struct HitFragment {
    covered: bool,
    distance: f32,
    weight: f32,
    behind: bool,       // the surfel is seen from behind
    tolerance: f32,     // how far behind the nearest it may lie and still be averaged with it
}

fn cut(v: f32, limit: u32) -> u32 {
    return u32(clamp(v, 0.0, f32(limit)));
}

// First and one past the last pixel whose centres a splat covers along one axis, at least the one it lies in.
fn hit_span(at: f32, reach: f32, size: u32) -> vec2u {
    return vec2u(
        min(cut(at - reach + 0.5, size), cut(at, size)),
        max(cut(at + reach + 0.5, size), cut(at + 1.0, size)),
    );
}

fn hit_splat(hit: Hit) -> HitSplat {
    var s: HitSplat;
    var reach = hit.reach;
    if params.disc > 0.0 {
        // What is not a number, where the mirror's picture folds, is as large as can be.
        reach *= params.enlarged;
        reach = select(vec2f(LARGEST_REACH), reach, reach < vec2f(LARGEST_REACH));
    }
    let columns = hit_span(hit.pixel.x, reach.x, params.size.x);
    let rows = hit_span(hit.pixel.y, reach.y, params.size.y);
    s.first = vec2u(columns.x, max(rows.x, params.rows.x));
    s.end = vec2u(columns.y, min(rows.y, params.rows.y));
    let point = hit.point - params.band_start;
    if hit.point < params.band_start || point >= params.band_points || any(s.first >= s.end) {
        return s;
    }
    s.seen = true;
    if params.disc <= 0.0 {
        // The window's bindings hold the pixel of every square that reaches into it.
        let at = vec2u(hit.pixel);
        s.region = region[at.y * params.size.x + at.x - params.first_pixel];
        s.seen = s.region != 0u;
    }
    s.place = places[point];
    s.finish = finishes[point];
    s.normal = finish_normal(s.finish);
    s.pixel = hit.pixel;
    s.reach = reach;
    s.radius = s.place.w * params.enlarged;
    s.distance = hit.distance;
    return s;
}

// Where the ray of a pixel meets the surfel's disc.
fn disc_fragment(s: HitSplat, to_surfel: vec3f, towards: vec3f) -> HitFragment {
    var f: HitFragment;
    let cosine = dot3(s.normal, towards);
    f.distance = dot3(s.normal, to_surfel) / cosine;
    let half = params.disc * s.radius;
    let from_surfel = towards * f.distance - to_surfel;
    let off = dot3(from_surfel, from_surfel) / (half * half);
    // What is not a number fails.
    let met = off <= 1.0 && f.distance > 0.0 && cosine * cosine >= EDGE_ON_COSINE_SQUARED;
    // A ray leaves the mirror's own layer of points from their backs.
    let layer = params.own_layer * s.radius;
    let own = finish_mirror(s.finish) > 0.0 && cosine > 0.0 && f.distance * cosine <= layer;
    let slope = min(sqrt(max(1.0 / (cosine * cosine) - 1.0, 0.0)), MAX_TOLERANCE_SLOPE);
    f.covered = met && !own;
    f.weight = weight(off);
    f.behind = cosine > 0.0;
    f.tolerance = s.radius * (params.depth_offset + slope);
    return f;
}

// A part of the hit's square: it counts the less the farther off the surfel the pixel's ray passes.
fn square_fragment(s: HitSplat, to_surfel: vec3f, towards: vec3f, centre: vec2f) -> HitFragment {
    var f: HitFragment;
    let along = dot3(s.normal, to_surfel);
    let met = along / dot3(s.normal, towards);
    let near = met > s.distance / DEPTH_RANGE && met < s.distance * DEPTH_RANGE;
    f.distance = select(s.distance, met, near);
    let from_surfel = towards * f.distance - to_surfel;
    let aside = sqrt(dot3(from_surfel, from_surfel)) / s.radius;
    let from_centre = (centre - s.pixel) / s.reach;
    let t = 0.5 * (from_centre.x * from_centre.x + from_centre.y * from_centre.y);
    f.covered = true;
    f.weight = weight(min(t, 1.0)) / (1.0 + aside * aside);
    f.behind = along > 0.0;
    f.tolerance = params.depth_offset * s.radius;
    return f;
}

// A splat's part in the pixel at column `x`, row `y`, which the bindings hold at `pixel`.
fn hit_fragment(s: HitSplat, x: u32, y: u32, pixel: u32) -> HitFragment {
    let from_mirror = origin[pixel];
    if from_mirror.w <= 0.0 {
        return HitFragment();
    }
    let to_surfel = s.place.xyz - from_mirror.xyz;
    let towards = direction[pixel].xyz;
    if params.disc > 0.0 {
        return disc_fragment(s, to_surfel, towards);
    }
    if region[pixel] != s.region {
        return HitFragment();
    }
    return square_fragment(s, to_surfel, towards, vec2f(f32(x) + 0.5, f32(y) + 0.5));
}

fn hit_key(s: HitSplat, f: HitFragment) -> u32 {
    let mirror = select(1u, 2u, f.behind);
    return depth_key(f.distance, select(0u, mirror, finish_mirror(s.finish) > 0.0), false);
}
