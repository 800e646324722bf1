// A hit as a splat in the mirror, and its fragments. Twin: src/reflect/sscr/accumulate.rs.
// Reads `params`, `places`, `finishes`, `region`, `origin` and `direction` of the kernel that imports it.
#import hit
#import hit_params
#import pinhole
#import surfel
#import weight
#import depth_key

override DEPTH_RANGE: f32;

struct HitSplat {
    seen: bool,
    place: vec4f,
    finish: vec4u,
    normal: vec3f,
    pixel: vec2f,
    reach: vec2f,
    distance: f32,
    region: u32,
    first: vec2u,       // pixels that it may cover
    end: vec2u,
}

struct HitFragment {
    covered: bool,
    distance: f32,
    weight: f32,
    behind: bool,       // the surfel is seen from behind
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
    let columns = hit_span(hit.pixel.x, hit.reach.x, params.size.x);
    let rows = hit_span(hit.pixel.y, hit.reach.y, params.size.y);
    s.first = vec2u(columns.x, max(rows.x, params.rows.x));
    s.end = vec2u(columns.y, min(rows.y, params.rows.y));
    let point = hit.point - params.band_start;
    if hit.point < params.band_start || point >= params.band_points || any(s.first >= s.end) {
        return s;
    }
    // The window's bindings hold the pixel of every splat that reaches into it.
    let at = vec2u(hit.pixel);
    s.region = region[at.y * params.size.x + at.x - params.first_pixel];
    s.seen = s.region != 0u;
    s.place = places[point];
    s.finish = finishes[point];
    s.normal = finish_normal(s.finish);
    s.pixel = hit.pixel;
    s.reach = hit.reach;
    s.distance = hit.distance;
    return s;
}

// A splat's part in the pixel at column `x`, row `y`, which the bindings hold at `pixel`.
fn hit_fragment(s: HitSplat, x: u32, y: u32, pixel: u32) -> HitFragment {
    var f: HitFragment;
    if region[pixel] != s.region {
        return f;
    }
    let towards = direction[pixel].xyz;
    let to_surfel = s.place.xyz - origin[pixel].xyz;
    let along = dot3(s.normal, to_surfel);
    let met = along / dot3(s.normal, towards);
    let near = met > s.distance / DEPTH_RANGE && met < s.distance * DEPTH_RANGE;
    f.distance = select(s.distance, met, near);
    let from_surfel = towards * f.distance - to_surfel;
    let aside = sqrt(dot3(from_surfel, from_surfel)) / s.place.w;
    let from_centre = (vec2f(f32(x) + 0.5, f32(y) + 0.5) - s.pixel) / s.reach;
    let t = 0.5 * (from_centre.x * from_centre.x + from_centre.y * from_centre.y);
    f.weight = weight(min(t, 1.0)) / (1.0 + aside * aside);
    f.behind = along > 0.0;
    f.covered = true;
    return f;
}

fn hit_key(s: HitSplat, f: HitFragment) -> u32 {
    let mirror = select(1u, 2u, f.behind);
    return depth_key(f.distance, select(0u, mirror, finish_mirror(s.finish) > 0.0), false);
}
