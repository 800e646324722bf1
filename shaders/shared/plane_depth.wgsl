// Twin: `plane_depth` in src/gbuffer/fill.rs.
#import pinhole

// The ray through the centre of a pixel, scaled to 1 along the axis.
fn direction_of(pinhole: Pinhole, x: u32, y: u32) -> vec3f {
    return direction_from_pixel(pinhole, vec2f(f32(x) + 0.5, f32(y) + 0.5));
}

// Depth at which the plane of a pixel meets the ray `towards`; the pixel's own where it is seen too flatly.
fn plane_depth(normal: vec3f, direction: vec3f, depth: f32, towards: vec3f) -> f32 {
    let met = dot3(normal, direction) / dot3(normal, towards) * depth;
    return select(depth, met, met > 0.5 * depth && met < 2.0 * depth);
}
