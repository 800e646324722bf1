// What one dispatch over hits works on. Twin: `HitParams` in src/backend/gpu/accumulate.rs.
struct HitParams {
    size: vec2u,            // of the picture, pixels
    rows: vec2u,            // first row, and one past the last
    first_pixel: u32,       // number of the bindings' first pixel, row by row
    first_hit: u32,
    end_hit: u32,
    band_start: u32,        // number of the point band's first point in the cloud
    band_points: u32,       // in the band
    depth_offset: f32,      // over the local spacing
    nearest: u32,           // 1: only the nearest is visible; 0: also what lies `depth_offset` behind
    pad: u32,
}
