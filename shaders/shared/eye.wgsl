// From where a mirror is seen. Twin: `Eye` in src/reflect/mod.rs.
// Reads the grid `eyes` of the kernel that imports it.

struct EyeParams {
    point: vec3f,       // relative to the scene's origin
    per_pixel: u32,     // 1: a point of its own for every pixel
}

// The eye of a pixel of the bindings.
fn eye_of(eye: EyeParams, pixel: u32) -> vec3f {
    if eye.per_pixel == 1u {
        return eyes[pixel].xyz;
    }
    return eye.point;
}
