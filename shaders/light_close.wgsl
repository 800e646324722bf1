// Closes single texels of a light's map through which light leaks: a texel deeper than at least seven of its eight
// neighbours takes the depth of the seventh.
// One thread per texel. CPU twin: `light_close` in src/gi/light_close.rs.
#import depth_key

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side

struct LightCloseParams {
    size: vec2u,        // texels
    rows: vec2u,        // first row, and one past the last
    first_pixel: u32,   // number of the bindings' first texel, row by row
    pad: u32,
}

@group(0) @binding(0) var<uniform> params: LightCloseParams;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read_write> closed: array<u32>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= params.size.x || y >= params.rows.y {
        return;
    }
    // The two deepest neighbours.
    var deepest = 0u;
    var second = 0u;
    for (var k = 0u; k < 9u; k++) {
        if k == 4u {
            continue;
        }
        let u = i32(x) + i32(k % 3u) - 1;
        let v = i32(y) + i32(k / 3u) - 1;
        var key = EMPTY;
        if u >= 0 && v >= 0 && u < i32(params.size.x) && v < i32(params.size.y) {
            key = keys[u32(v) * params.size.x + u32(u) - params.first_pixel];
        }
        second = max(second, min(key, deepest));
        deepest = max(deepest, key);
    }
    let here = y * params.size.x + x - params.first_pixel;
    closed[here] = min(keys[here], second);
}
