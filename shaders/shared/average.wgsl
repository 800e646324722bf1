// The one surfel that the sums of a pixel make. Twin: `average` in src/gbuffer/average.rs.
#import pinhole

override SHININESS_LOG_RANGE: f32;

struct Shown {
    surface: vec4f,     // unit normal, and depth
    albedo: vec4f,      // and mirror reflectance
    material: vec4f,    // specular, shininess, radius, 1
}

// `front` is the depth of the nearest; the sums are those of the pixel, the first weight above 0.
fn averaged(front: f32, depth_sums: vec4f, albedo_sums: vec4f, normal_sums: vec4f) -> Shown {
    let inverse = 1.0 / depth_sums.x;
    let mean = normal_sums * inverse;

    // Opposite normals that cancel leave none: any unit vector is as good, and none is NaN.
    let length_squared = dot3(mean.xyz, mean.xyz);
    var normal = vec3f(0.0, 0.0, 1.0);
    if length_squared > 1e-12 {
        normal = mean.xyz / sqrt(length_squared);
    }
    return Shown(
        vec4f(normal, front + depth_sums.y * inverse * front),
        albedo_sums * inverse,
        vec4f(
            depth_sums.z * inverse,
            exp2(depth_sums.w * inverse * SHININESS_LOG_RANGE) - 1.0,
            mean.w * front,
            1.0,
        ),
    );
}
