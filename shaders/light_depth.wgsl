// The nearest fragment of every texel of a light's map.
// One thread per surfel. CPU twin: `depth` in src/gbuffer/depth.rs, without count and rims.
#import disc
#import depth_key

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: SplatParams;
@group(0) @binding(1) var<storage, read> places: array<vec4f>;
@group(0) @binding(2) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> keys: array<atomic<u32>>;

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let point = params.first_point + id.x;
    if point >= params.end_point {
        return;
    }
    let d = disc(places[point], finishes[point], params);
    if !d.seen {
        return;
    }
    for (var y = d.first.y; y < d.end.y; y++) {
        let row = y * params.pinhole.size.x - params.first_pixel;
        for (var x = d.first.x; x < d.end.x; x++) {
            let f = fragment(d, x, y, params.pinhole);
            if f.covered {
                atomicMin(&keys[row + x], depth_key(f.depth, d.class_bits, false));
            }
        }
    }
}
