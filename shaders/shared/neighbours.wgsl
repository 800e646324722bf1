// The neighbours of a pixel, and their vote on a surface. Twin: src/gbuffer/fill.rs.
// Reads the grids `surface`, `albedo` and `material` of the kernel that imports it.
#import plane_depth

override AGREE_SPACINGS: f32;

// Validity of a pixel that pass `leak` found, until pass `fill` closes it or empties it.
const LEAK: f32 = 0.5;

struct Neighbour {
    pixel: u32,     // in the bindings
    depth: f32,     // of its plane, on the ray of the pixel whose neighbour it is
    radius: f32,
    mirror: bool,
}

struct Neighbours {
    all: array<Neighbour, 8>,
    count: u32,     // that show something
    existing: u32,  // that lie in the picture
}

// The pixel at `at`, as the one whose ray is `towards` takes it for its neighbour.
fn neighbour(pinhole: Pinhole, pixel: u32, at: vec2u, towards: vec3f) -> Neighbour {
    let plane = surface[pixel];
    let depth = plane_depth(plane.xyz, direction_of(pinhole, at.x, at.y), plane.w, towards);
    return Neighbour(pixel, depth, material[pixel].z, albedo[pixel].w > 0.0);
}

// The neighbours of column `x`, row `y` whose validity is `lowest` to `highest`.
fn neighbours(pinhole: Pinhole, first_pixel: u32, x: u32, y: u32, lowest: f32, highest: f32) -> Neighbours {
    var seen: Neighbours;
    let towards = direction_of(pinhole, x, y);
    for (var k = 0u; k < 9u; k++) {
        let u = i32(x) + i32(k % 3u) - 1;
        let v = i32(y) + i32(k / 3u) - 1;
        if k == 4u || u < 0 || v < 0 || u >= i32(pinhole.size.x) || v >= i32(pinhole.size.y) {
            continue;
        }
        seen.existing++;
        let pixel = u32(v) * pinhole.size.x + u32(u) - first_pixel;
        let validity = material[pixel].w;
        if !(validity >= lowest && validity <= highest) {
            continue;
        }
        seen.all[seen.count] = neighbour(pinhole, pixel, vec2u(u32(u), u32(v)), towards);
        seen.count++;
    }
    return seen;
}

fn agree(a: Neighbour, b: Neighbour) -> bool {
    return a.mirror == b.mirror && abs(a.depth - b.depth) <= AGREE_SPACINGS * a.radius;
}

struct Vote {
    chosen: u32, // among the neighbours that show something
    votes: u32,
}

// The neighbour on whose surface most agree; the nearer where two have as many.
fn vote(seen: ptr<function, Neighbours>) -> Vote {
    var best = Vote(0u, 0u);
    for (var i = 0u; i < (*seen).count; i++) {
        var votes = 0u;
        for (var j = 0u; j < (*seen).count; j++) {
            votes += select(0u, 1u, agree((*seen).all[i], (*seen).all[j]));
        }
        let nearer = (*seen).all[i].depth < (*seen).all[best.chosen].depth;
        if votes > best.votes || (votes == best.votes && nearer) {
            best = Vote(i, votes);
        }
    }
    return best;
}
