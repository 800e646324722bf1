// What one dispatch of `leak` or `fill` works on. Twin: `RingParams` in src/backend/gpu/fill.rs.
#import pinhole

struct RingParams {
    pinhole: Pinhole,
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first pixel, row by row
    ring: u32,          // that `fill` closes, counted from 1
}
