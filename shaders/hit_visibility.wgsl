// Sums the attributes of all visible fragments of every mirror pixel, in fixed point.
// One thread per hit. CPU twin: visibility in `Context::passes` of src/reflect/sscr/accumulate.rs.
#import hit_splat
#import sums

override POINT_GROUP: u32 = 64u; // threads per workgroup

@group(0) @binding(0) var<uniform> params: HitParams;
@group(0) @binding(1) var<storage, read> hits: array<Hit>;
@group(0) @binding(2) var<storage, read> places: array<vec4f>;
@group(0) @binding(3) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(4) var<storage, read> region: array<u32>;
@group(0) @binding(5) var<storage, read> origin: array<vec4f>;
@group(0) @binding(6) var<storage, read> direction: array<vec4f>;
// As pass `hit_depth` leaves them; visible fragments are counted here.
@group(0) @binding(7) var<storage, read_write> fronts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<i32>>;

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
            if !f.covered {
                continue;
            }
            let nearest = ~atomicLoad(&fronts[pixel * 3u]);
            let own = hit_key(s, f);
            let front = key_depth(nearest);
            let near = key_class(own) == key_class(nearest) && f.distance - front <= f.tolerance;
            if !select(near, own == nearest, params.nearest == 1u) {
                continue;
            }
            let scale = f.weight * sum_scale(atomicLoad(&fronts[pixel * 3u + 1u]));
            let behind = min((f.distance - front) / front, 1.0);
            let radius = min(s.radius / front, 1.0);
            add_surfel(pixel, attributes(s.finish, f.behind), scale, behind, radius);
            atomicAdd(&fronts[pixel * 3u + 2u], 1u);
        }
    }
}
