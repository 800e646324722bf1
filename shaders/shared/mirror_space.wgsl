// Mirror space, and how far a mirror's reflection misses a point. Twin: src/reflect/sscr/mirror_error.rs.
#import pinhole

// Smallest cosine between normal and view that is divided by.
override SMALLEST_COSINE: f32;

// A direction in mirror space: right, up, towards the eye.
fn mirror_space(right: vec3f, to_eye: vec3f, d: vec3f) -> vec3f {
    let up = vec3f(
        to_eye.y * right.z - right.y * to_eye.z,
        to_eye.z * right.x - right.z * to_eye.x,
        to_eye.x * right.y - right.x * to_eye.y,
    );
    return vec3f(dot3(right, d), dot3(up, d), dot3(to_eye, d));
}

// Error of a mirror that reflects the eye to `reflected`, towards a point `to_point` away: right and up.
fn mirror_error(right: vec3f, to_eye: vec3f, reflected: vec2f, to_point: vec3f) -> vec2f {
    let q = mirror_space(right, to_eye, to_point);
    let distance = sqrt(dot3(q, q));
    let pole = max(SMALLEST_COSINE * distance, 1.1754944e-38);
    let seen = 1.0 / max(distance + q.z, pole);
    return vec2f(reflected.x - q.x * seen, reflected.y - q.y * seen);
}
