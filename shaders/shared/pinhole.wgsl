// Twin: `Pinhole` in src/camera.rs. View space: x right, y up, z forward.
#import dot3

struct Pinhole {
    eye: vec3f,           // relative to the scene's origin
    focal: f32,           // pixels per unit of slope
    right: vec3f,         // unit
    near: f32,
    up: vec3f,            // unit
    far: f32,
    forward: vec3f,       // unit
    inverse_focal: f32,
    centre: vec2f,        // principal point, pixels
    size: vec2u,          // pixels
}

fn view_from_world_direction(pinhole: Pinhole, d: vec3f) -> vec3f {
    return vec3f(dot3(pinhole.right, d), dot3(pinhole.up, d), dot3(pinhole.forward, d));
}

fn view_from_world(pinhole: Pinhole, point: vec3f) -> vec3f {
    return view_from_world_direction(pinhole, point - pinhole.eye);
}

// Slopes x/z, y/z of the ray through the point `pixel`.
fn slope_from_pixel(pinhole: Pinhole, pixel: vec2f) -> vec2f {
    return vec2f(
        (pixel.x - pinhole.centre.x) * pinhole.inverse_focal,
        (pinhole.centre.y - pixel.y) * pinhole.inverse_focal,
    );
}

fn pixel_from_view(pinhole: Pinhole, view: vec3f) -> vec2f {
    return vec2f(
        pinhole.centre.x + pinhole.focal * view.x / view.z,
        pinhole.centre.y - pinhole.focal * view.y / view.z,
    );
}

// The ray through `pixel`, scaled to 1 along the axis.
fn direction_from_pixel(pinhole: Pinhole, pixel: vec2f) -> vec3f {
    let slope = slope_from_pixel(pinhole, pixel);
    return pinhole.right * slope.x + pinhole.up * slope.y + pinhole.forward;
}

fn world_from_pixel(pinhole: Pinhole, pixel: vec2f, depth: f32) -> vec3f {
    return pinhole.eye + direction_from_pixel(pinhole, pixel) * depth;
}
