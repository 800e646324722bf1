// A point of the cloud, and the mirror pixel that shows it. Twin: `Hit` in src/reflect/mod.rs.
struct Hit {
    pixel: vec2f,       // where the point is seen (centres at + 0.5)
    reach: vec2f,       // half the sides of its splat, pixels
    point: u32,         // index of the surfel in the whole cloud
    distance: f32,      // from the mirror point
}
