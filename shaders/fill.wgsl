// Closes one ring of small holes from the planes of their neighbours.
// One thread per pixel. CPU twin: `fill_pixel` in src/gbuffer/fill.rs.
#import ring
#import neighbours

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override MIN_NEIGHBOURS: u32;

@group(0) @binding(0) var<uniform> params: RingParams;
// A pixel that is filled in this ring says so in its validity, so that its neighbours do not take it for their own.
@group(0) @binding(1) var<storage, read_write> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> albedo: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> material: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = params.pinhole.size;
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= size.x || y >= params.rows.y {
        return;
    }
    let here = y * size.x + x - params.first_pixel;
    if material[here].w >= 1.0 {
        return;
    }
    let ring = f32(params.ring);
    var seen = neighbours(params.pinhole, params.first_pixel, x, y, 1.0, ring);
    if seen.count * 8u < MIN_NEIGHBOURS * seen.existing {
        // A leak that stays open is a hole.
        if material[here].w > 0.0 {
            surface[here] = vec4f(0.0);
            albedo[here] = vec4f(0.0);
            material[here] = vec4f(0.0);
        }
        return;
    }
    let best = vote(&seen);
    let chosen = seen.all[best.chosen];
    var normal = vec3f(0.0);
    var depth = 0.0;
    var colour = vec4f(0.0);
    var finish = vec4f(0.0);
    for (var j = 0u; j < seen.count; j++) {
        let voter = seen.all[j];
        if agree(chosen, voter) {
            normal += surface[voter.pixel].xyz;
            depth += voter.depth;
            colour += albedo[voter.pixel];
            finish += material[voter.pixel];
        }
    }
    let inverse = 1.0 / f32(best.votes);
    let length = sqrt(dot3(normal, normal));
    if length > 1e-6 {
        normal /= length;
    } else {
        normal = surface[chosen.pixel].xyz;
    }
    surface[here] = vec4f(normal, depth * inverse);
    albedo[here] = colour * inverse;
    material[here] = vec4f(finish.xyz * inverse, 1.0 + ring);
}
