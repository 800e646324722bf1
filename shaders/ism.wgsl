// The shadow maps of virtual point lights: the nearest disc of every texel of a paraboloid.
// One thread per surfel of a slice, and map. CPU twin: `ism` in src/gi/ism.rs.
#import ism
#import surfel

override POINT_GROUP: u32 = 64u; // threads per workgroup
override EDGE_ON_COSINE_SQUARED: f32;
override REACH: f32;
override OWN_COSINE: f32;
override OWN_HEIGHT: f32;
override OWN_REACH: f32;

struct IsmParams {
    side: u32,              // of a map, texels
    points: u32,            // surfels in a slice
    pool: u32,              // surfels from which slices are taken
    first_map: u32,         // of this dispatch
    first_key_map: u32,     // whose keys are bound
    first_point: u32,       // of the bound surfels
    end_point: u32,         // one past the last
    half_width: f32,        // of a disc, over the surfel's radius
    min_half_width: f32,    // texels
    texel: f32,             // 2 / side
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: IsmParams;
@group(0) @binding(1) var<storage, read> vpls: array<Vpl>;
@group(0) @binding(2) var<storage, read> places: array<vec4f>;
@group(0) @binding(3) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(4) var<storage, read_write> keys: array<atomic<u32>>;

// First and one past the last texel whose centres lie within `reach` of `middle`.
fn texels(middle: f32, reach: f32) -> vec2u {
    let side = f32(params.side);
    let first = clamp(middle - reach + 0.5, 0.0, side);
    let end = clamp(middle + reach + 0.5, 0.0, side);
    return vec2u(u32(first), u32(end));
}

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= params.points {
        return;
    }
    let number = params.first_map + id.y;
    let position = vpls[number].position;
    let right = vpls[number].right;
    let up = vpls[number].up;
    let along_axis = vpls[number].normal;
    var surfel = vpls[number].slice + id.x;
    if surfel >= params.pool {
        surfel -= params.pool;
    }
    if surfel < params.first_point || surfel >= params.end_point {
        return;
    }
    surfel -= params.first_point;
    let place = places[surfel];
    let to = place.xyz - position;
    let centre = vec3f(dot3(to, right), dot3(to, up), dot3(to, along_axis));
    if !(centre.z > 0.0) {
        return;
    }
    let n = finish_normal(finishes[surfel]);
    let normal = vec3f(dot3(n, right), dot3(n, up), dot3(n, along_axis));
    let along = dot3(normal, centre);
    let distance_squared = dot3(centre, centre);
    let cosine_squared = along * along / distance_squared;
    if !(cosine_squared >= EDGE_ON_COSINE_SQUARED) {
        return;
    }
    let scale = 0.5 * f32(params.side) / (sqrt(distance_squared) + centre.z);
    let half = max(params.half_width * place.w, params.min_half_width / scale);

    // Curved and noisy surfaces lie a little before their own lights.
    let own = abs(normal.z) > OWN_COSINE && abs(along) < OWN_HEIGHT * half
        && distance_squared < OWN_REACH * OWN_REACH * half * half;
    if own {
        return;
    }
    let half_squared = half * half;
    let middle = 0.5 * f32(params.side);
    let reach = half * scale * REACH;
    let columns = texels(centre.x * scale + middle, reach);
    let rows = texels(centre.y * scale + middle, reach);
    let first_texel = (number - params.first_key_map) * params.side * params.side;
    for (var row = rows.x; row < rows.y; row++) {
        for (var column = columns.x; column < columns.y; column++) {
            let u = (f32(column) + 0.5) * params.texel - 1.0;
            let v = (f32(row) + 0.5) * params.texel - 1.0;
            let square = u * u + v * v;
            let towards = vec3f(2.0 * u, 2.0 * v, 1.0 - square);
            let t = along / dot3(normal, towards);
            let from_centre = vec3f(
                towards.x * t - centre.x,
                towards.y * t - centre.y,
                towards.z * t - centre.z,
            );
            if t > 0.0 && dot3(from_centre, from_centre) <= half_squared {
                atomicMin(&keys[first_texel + row * params.side + column], ism_key(t * (1.0 + square), id.x));
            }
        }
    }
}
