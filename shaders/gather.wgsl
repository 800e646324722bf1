// What virtual point lights send to every pixel, as far as their maps let them; added to what is there.
// One thread per pixel. CPU twin: `gather` in src/gi/gather.rs.
#import ism

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override BIAS: f32;
override BIAS_TEXELS: f32;
override RESIDUAL_SOFTENING: f32;

struct GatherParams {
    size: vec2u,            // of the picture, pixels
    rows: vec2u,            // first row, and one past the last
    first_pixel: u32,       // number of the bindings' first pixel, row by row
    interleave: u32,        // n
    vpl_count: u32,         // lights of the batch
    first_vpl: u32,         // whose maps are bound
    end_vpl: u32,           // one past the last
    side: u32,              // of a map, texels
    bias: f32,              // over the local spacing
    pad0: u32,
}

@group(0) @binding(0) var<uniform> params: GatherParams;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(2) var<storage, read> normals: array<vec4f>;
@group(0) @binding(3) var<storage, read> views: array<vec4f>;
@group(0) @binding(4) var<storage, read> vpls: array<Vpl>;
@group(0) @binding(5) var<storage, read> keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> residual: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.size.x || y >= params.rows.y {
        return;
    }
    let here = y * params.size.x + x - params.first_pixel;
    let place = positions[here];
    if !(place.w > 0.0) {
        return;
    }
    let normal = normals[here].xyz;
    let specular = normals[here].w;
    let view = views[here].xyz;
    let shininess = views[here].w;

    // This pixel's part of the lights.
    let n = params.interleave;
    let parts = n * n;
    let part = (y % n) * n + x % n;
    let first = params.vpl_count * part / parts;
    let end = params.vpl_count * (part + 1u) / parts;
    let side = params.side;
    let middle = 0.5 * f32(side);
    var sum = irradiance[here];
    var left_out_sum = residual[here].xyz;
    for (var v = max(first, params.first_vpl); v < min(end, params.end_vpl); v++) {
        let to = place.xyz - vpls[v].position;
        let along = dot3(to, vpls[v].normal);
        let facing = -dot3(to, normal);
        if !(along > 0.0 && facing > 0.0) {
            continue;
        }
        let distance_squared = dot3(to, to);
        let distance = sqrt(distance_squared);

        // Whether its map lets it.
        let scale = 0.5 * f32(side) / (distance + along);
        let column = min(u32(max(dot3(to, vpls[v].right) * scale + middle, 0.0)), side - 1u);
        let row = min(u32(max(dot3(to, vpls[v].up) * scale + middle, 0.0)), side - 1u);
        let cosine = facing / distance;
        let key = keys[((v - params.first_vpl) * side + row) * side + column];
        if key != UNSEEN {
            let slope = sqrt(max(1.0 / (cosine * cosine) - 1.0, 0.0));
            let shown = ism_distance(key);
            let limit = shown * (1.0 + BIAS + BIAS_TEXELS * slope / f32(side)) + params.bias * place.w;
            if distance > limit {
                continue;
            }
        }

        let facing_both = along * cosine / (distance * PI);
        let softening = vpls[v].softening;
        let bounded = 1.0 / (distance_squared + softening);
        let left_out = 1.0 / (distance_squared + softening * RESIDUAL_SOFTENING) - bounded;
        var flux = vpls[v].flux;
        if vpls[v].specular > 0.0 {
            let base = max(dot3(vpls[v].mirrored, to / distance), 0.0);
            let exponent = vpls[v].shininess;
            let lobe = power(base, exponent) * (exponent + 2.0) / (2.0 * PI);
            flux += vpls[v].incident * (vpls[v].specular * lobe * PI);
        }
        let arrived = flux * (facing_both * bounded);
        var glossy = 0.0;
        if specular > 0.0 {
            let mirrored = normal * (2.0 * cosine) + to / distance;
            let base = max(dot3(mirrored, view), 0.0);
            let lobe = power(base, shininess) * (shininess + 2.0) / (2.0 * PI);
            glossy = specular * lobe * luminance(arrived);
        }
        sum += vec4f(arrived, glossy);
        left_out_sum += flux * (facing_both * left_out);
    }
    irradiance[here] = sum;
    residual[here] = vec4f(left_out_sum, 0.0);
}
