// Direct light of one spot on a surfel. Twin: src/gi/shade.rs.
// Reads `params` and the light's map `low_keys`, `high_keys` of the kernel that imports it.
#import pinhole
#import depth_key

override RECEIVER_COSINE: f32;

const PI: f32 = 3.14159265;

struct LightParams {
    pinhole: Pinhole,   // of the light's map
    position: vec3f,    // of the light, relative to the scene's origin
    inner_angle: f32,   // half angle, radians
    axis: vec3f,        // of the light, unit
    outer_angle: f32,   // half angle, radians
    intensity: vec3f,   // W/sr per channel
    bias: f32,          // over the local spacing
    split: u32,         // number of the first texel that `high_keys` holds
    first: u32,         // 1: the radiance so far is none
    pyramid: u32,       // 1: the cone is a square pyramid, full all over
    albedo_scale: f32,
}

fn light_key(texel: vec2i) -> u32 {
    let size = vec2i(params.light.pinhole.size);
    if any(texel < vec2i(0)) || any(texel >= size) {
        return EMPTY;
    }
    let index = u32(texel.y) * params.light.pinhole.size.x + u32(texel.x);
    if index >= params.light.split {
        return high_keys[index - params.light.split];
    }
    return low_keys[index];
}

// The light's share that reaches a point: bilinear over the four nearest texels, each compared with the receiver's own
// plane at that texel. Empty texels are lit.
fn light_visibility(position: vec3f, world_normal: vec3f, bias: f32) -> f32 {
    let pinhole = params.light.pinhole;
    let view = view_from_world(pinhole, position);
    if view.z < pinhole.near {
        return 0.0;
    }
    let normal = view_from_world_direction(pinhole, world_normal);
    let along = dot3(normal, view);
    let pixel = pixel_from_view(pinhole, view) - 0.5;
    let base = floor(pixel);
    let fraction = pixel - base;
    let flat = abs(along) <= RECEIVER_COSINE * sqrt(dot3(view, view));
    var lit = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let corner = vec2f(f32(k & 1u), f32(k >> 1u));
        let weights = abs(1.0 - corner - fraction);
        let texel = base + corner;
        let slope = slope_from_pixel(pinhole, texel + 0.5);
        let towards = normal.x * slope.x + normal.y * slope.y + normal.z;

        // A plane that turns away within a texel has no depth there.
        let plane = along / towards;
        let own = select(view.z, plane, !flat && plane > 0.5 * view.z && plane < 2.0 * view.z);
        let key = light_key(vec2i(clamp(texel, vec2f(-1.0), vec2f(pinhole.size))));
        if key == EMPTY || key_depth(key) >= own - bias {
            lit += weights.x * weights.y;
        }
    }
    return lit;
}

// The share of the intensity, 0 to 1, in a unit direction.
fn falloff_towards(d: vec3f) -> f32 {
    let along = dot3(d, params.light.axis);
    if params.light.pyramid == 0u {
        let width = max(params.light.outer_angle - params.light.inner_angle, 1e-6);
        return clamp((params.light.outer_angle - acos(clamp(along, -1.0, 1.0))) / width, 0.0, 1.0);
    }
    // Edges belong to the first axis that they touch.
    let size = abs(d);
    var inside = size.x < along && size.y < along;
    if params.light.axis.x != 0.0 {
        inside = size.y <= along && size.z <= along;
    } else if params.light.axis.y != 0.0 {
        inside = size.x < along && size.z <= along;
    }
    return select(0.0, 1.0, inside && along > 0.0);
}

fn spot_radiance(position: vec3f, normal: vec3f, view: vec3f, colour: vec3f, its: vec4f) -> vec3f {
    let to_light = params.light.position - position;
    let distance_squared = dot3(to_light, to_light);
    if distance_squared <= 0.0 {
        return vec3f(0.0);
    }
    let direction = to_light / sqrt(distance_squared);
    let cosine = dot3(normal, direction);
    let falloff = falloff_towards(-direction);
    if cosine <= 0.0 || falloff <= 0.0 {
        return vec3f(0.0);
    }
    let lit = light_visibility(position, normal, params.light.bias * its.z);
    let irradiance = params.light.intensity * (falloff * cosine / distance_squared * lit);
    var reflected = colour * params.light.albedo_scale / PI;
    if its.x > 0.0 {
        let mirrored = normal * (2.0 * cosine) - direction;
        let base = max(dot3(mirrored, view), 0.0);
        // 0 to the power 0 is 1; the shader language leaves it open.
        let lobe = select(pow(base, its.y), select(0.0, 1.0, its.y == 0.0), base == 0.0);
        reflected += its.x * lobe * (its.y + 2.0) / (2.0 * PI);
    }
    return reflected * irradiance;
}
