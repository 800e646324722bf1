// What one dispatch of a splatting pass works on. Twin: `SplatParams` in src/backend/gpu/splat.rs.
#import pinhole

struct SplatParams {
    pinhole: Pinhole,
    rows: vec2u,            // first row, and one past the last
    first_pixel: u32,       // number of the bindings' first pixel, row by row
    first_point: u32,
    end_point: u32,
    size: f32,              // half width of a splat over the surfel's radius
    depth_tolerance: f32,   // over the surfel's radius
    min_half_width: f32,    // pixels; not a constant, which a compiler might multiply in another order
}
