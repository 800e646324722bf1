// The nearest fragment of every mirror pixel, and how many there are.
// One thread per hit. CPU twin: depth in `Context::passes` of src/reflect/sscr/accumulate.rs.
#import hit_splat

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: HitParams;
@group(0) @binding(1) var<storage, read> hits: array<Hit>;
@group(0) @binding(2) var<storage, read> places: array<vec4f>;
@group(0) @binding(3) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(4) var<storage, read> region: array<u32>;
@group(0) @binding(5) var<storage, read> origin: array<vec4f>;
@group(0) @binding(6) var<storage, read> direction: array<vec4f>;
// Three to a pixel: the complement of the nearest's key, so that 0 is nothing; fragments; those of them that are visible.
@group(0) @binding(7) var<storage, read_write> fronts: array<atomic<u32>>;

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let hit = params.first_hit + id.x;
    if hit >= params.end_hit {
        return;
    }
    let s = hit_splat(hits[hit]);
    if !s.seen {
        return;
    }
    for (var y = s.first.y; y < s.end.y; y++) {
        for (var x = s.first.x; x < s.end.x; x++) {
            let pixel = y * params.size.x + x - params.first_pixel;
            let f = hit_fragment(s, x, y, pixel);
            if f.covered {
                atomicMax(&fronts[pixel * 3u], ~hit_key(s, f));
                atomicAdd(&fronts[pixel * 3u + 1u], 1u);
            }
        }
    }
}
