// Adds what photons give, which came by way of mirrors.
// One thread per pixel. CPU twin: `photons` in src/gi/photons.rs.
#import dot3

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct Photon {
    position: vec3f,    // relative to the scene's origin
    pad0: f32,
    normal: vec3f,
    pad1: f32,
    irradiance: vec3f,  // where it landed, W/m2
    pad2: f32,
}

struct PhotonParams {
    corner: vec3f,          // smallest, of the cubes
    cell: f32,              // side of a cube
    cells: vec3u,           // along each axis
    inverse_square: f32,    // 1 over the squared distance that a photon reaches
    rows: vec2u,            // first row, and one past the last
    width: u32,             // of the picture, pixels
    first_pixel: u32,       // number of the bindings' first pixel, row by row
    first_photon: u32,      // that is bound
    end_photon: u32,        // one past the last
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: PhotonParams;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(2) var<storage, read> normals: array<vec4f>;
@group(0) @binding(3) var<storage, read> starts: array<u32>;
@group(0) @binding(4) var<storage, read> photons: array<Photon>;
@group(0) @binding(5) var<storage, read_write> irradiance: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.width || y >= params.rows.y {
        return;
    }
    let here = y * params.width + x - params.first_pixel;
    let position = positions[here].xyz;
    if !(positions[here].w > 0.0) {
        return;
    }
    let normal = normals[here].xyz;
    let at = floor((position - params.corner) / params.cell);
    let last = vec3f(params.cells) - 1.0;
    let low_edge = max(at - 1.0, vec3f(0.0));
    let high_edge = min(at + 1.0, last);
    if any(high_edge < low_edge) {
        return;
    }
    let low = vec3u(low_edge);
    let high = vec3u(high_edge);
    var arrived = irradiance[here].xyz;
    for (var z = low.z; z <= high.z; z++) {
        for (var row = low.y; row <= high.y; row++) {
            let first_cell = (z * params.cells.y + row) * params.cells.x;
            let first = max(starts[first_cell + low.x], params.first_photon);
            let end = min(starts[first_cell + high.x + 1u], params.end_photon);
            for (var p = first; p < end; p++) {
                let between = position - photons[p - params.first_photon].position;
                let near = 1.0 - dot3(between, between) * params.inverse_square;
                let facing = dot3(normal, photons[p - params.first_photon].normal);
                if near > 0.0 && facing > 0.0 {
                    arrived += photons[p - params.first_photon].irradiance * (near * facing);
                }
            }
        }
    }
    irradiance[here] = vec4f(arrived, irradiance[here].w);
}
