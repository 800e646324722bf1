// What one dispatch over hits works on. Twin: `HitParams` in src/backend/gpu/accumulate.rs.
struct HitParams {
    size: vec2u,            // of the picture, pixels
    rows: vec2u,            // first row, and one past the last
    first_pixel: u32,       // number of the bindings' first pixel, row by row
    first_hit: u32,
    end_hit: u32,
    band_start: u32,        // number of the point band's first point in the cloud
    band_points: u32,       // in the band
    nearest: u32,           // 1: only the nearest is visible; 0: also what lies a little behind
    depth_offset: f32,      // how little, over the local spacing
    disc: f32,              // half width of a splat's disc over its radius; 0: splats are squares of the hit's reach
    own_layer: f32,         // points of mirrors nearer before a mirror are its own; over the local spacing
    enlarged: f32,          // how much larger surfels are drawn
    pad0: u32,
    pad1: u32,
}
