// What one dispatch that counts pixels works on. Twin: `CoverageParams` in src/backend/gpu/fill.rs.
struct CoverageParams {
    width: u32,         // pixels
    first_row: u32,
    end_row: u32,
    first_pixel: u32,   // number of the bindings' first pixel, row by row
}
