// What receives indirect light in a pixel. Twin: `receiver` in src/gi/receivers.rs.

struct Receiver {
    position: vec4f,    // and local spacing; 0 where nothing is to be lit
    normal: vec4f,      // and specular reflectance
    view: vec4f,        // and exponent of the specular lobe
}

// Of what is seen along `direction` at `place`; nothing where it has no part of its own.
fn receiver(surface: vec4f, own: vec4f, material: vec4f, place: vec3f, direction: vec3f) -> Receiver {
    var r: Receiver;
    if material.w <= 0.0 || own.w >= 1.0 {
        return r;
    }
    let d = direction;
    let length = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    r.position = vec4f(place, material.z);
    r.normal = vec4f(surface.xyz, material.x);
    r.view = vec4f(-d / length, material.y);
    return r;
}
