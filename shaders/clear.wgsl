// Sets depth keys to "nothing seen". One thread per pixel. CPU twin: `Grid::new(size, EMPTY)`.
#import depth_key

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct ClearParams {
    width: u32,   // pixels
    pixels: u32,  // in the binding
}

@group(0) @binding(0) var<uniform> params: ClearParams;
@group(0) @binding(1) var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.y * params.width + id.x;
    if id.x >= params.width || pixel >= params.pixels {
        return;
    }
    keys[pixel] = EMPTY;
}
