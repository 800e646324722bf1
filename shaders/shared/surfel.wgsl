// Twin: `Place` and `Finish` in src/cloud/surfels.rs. A place is xyz and radius; a finish four packed words.
//
// The clamps change no value. They keep a compiler from moving the constant factor behind later products, which would
// round otherwise than the twin does.

fn snorm16(bits: u32) -> f32 {
    return clamp(f32(extractBits(bitcast<i32>(bits), 0u, 16u)) * (1.0 / 32767.0), -1.0, 1.0);
}

fn unorm16(bits: u32) -> f32 {
    return min(f32(bits & 0xffffu) * (1.0 / 65535.0), 1.0);
}

fn unorm8(bits: u32) -> f32 {
    return min(f32(bits & 0xffu) * (1.0 / 255.0), 1.0);
}

fn finish_normal(finish: vec4u) -> vec3f {
    return vec3f(snorm16(finish.x), snorm16(finish.x >> 16u), snorm16(finish.y));
}

fn finish_albedo(finish: vec4u) -> vec3f {
    return vec3f(unorm16(finish.y >> 16u), unorm16(finish.z), unorm16(finish.z >> 16u));
}

fn finish_mirror(finish: vec4u) -> f32 {
    return unorm8(finish.w);
}

fn finish_specular(finish: vec4u) -> f32 {
    return unorm8(finish.w >> 8u);
}

// On the scale log2(1 + s) / 16, on which it is blended.
fn finish_shininess_log(finish: vec4u) -> f32 {
    return unorm16(finish.w >> 16u);
}

// What a viewer sees of a surfel. Twin: `attributes` in src/gbuffer/visibility.rs.
struct Attributes {
    normal: vec3f,
    albedo: vec4f,      // and mirror reflectance
    gloss: vec2f,       // specular reflectance and shininess (logarithmic)
}

// Seen from behind, a diffuse surfel turns its normal, and a mirror is opaque and black.
fn attributes(finish: vec4u, behind: bool) -> Attributes {
    var its: Attributes;
    its.normal = finish_normal(finish);
    its.albedo = vec4f(finish_albedo(finish), finish_mirror(finish));
    its.gloss = vec2f(finish_specular(finish), finish_shininess_log(finish));
    if behind {
        its.normal = -its.normal;
        if its.albedo.w > 0.0 {
            its.albedo = vec4f(0.0);
            its.gloss = vec2f(0.0);
        }
    }
    return its;
}
