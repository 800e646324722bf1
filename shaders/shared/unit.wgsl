// Twin: `normalize_or_zero` of glam.
#import pinhole

// Unit length, or zero where there is no direction.
fn unit_or_zero(v: vec3f) -> vec3f {
    let inverse = 1.0 / sqrt(dot3(v, v));
    return select(vec3f(0.0), v * inverse, inverse > 0.0 && inverse <= 3.4028235e38);
}
