// Marks single pixels through which the background shows between the points of a nearer surface.
// One thread per pixel. CPU twin: `leaks` in src/gbuffer/leak.rs.
#import ring
#import neighbours

override PIXEL_GROUP: u32 = 8u; // threads per workgroup side
override LEAK_NEIGHBOURS: u32;

@group(0) @binding(0) var<uniform> params: RingParams;
@group(0) @binding(1) var<storage, read> surface: array<vec4f>;
@group(0) @binding(2) var<storage, read> albedo: array<vec4f>;
// A marked pixel still counts as seen for its neighbours, so that their order does not matter.
@group(0) @binding(3) var<storage, read_write> material: array<vec4f>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = params.pinhole.size;
    let x = id.x;
    let y = params.rows.x + id.y;
    if x >= size.x || y >= params.rows.y {
        return;
    }
    let here = y * size.x + x - params.first_pixel;
    if material[here].w <= 0.0 {
        return;
    }
    let depth = surface[here].w;

    // Few pixels have nearer ones all around: only they are worth the vote.
    var nearer = 0u;
    for (var k = 0u; k < 9u; k++) {
        let u = i32(x) + i32(k % 3u) - 1;
        let v = i32(y) + i32(k / 3u) - 1;
        if k != 4u && u >= 0 && v >= 0 && u < i32(size.x) && v < i32(size.y) {
            // Empty pixels have depth 0.
            let its_depth = surface[u32(v) * size.x + u32(u) - params.first_pixel].w;
            nearer += select(0u, 1u, its_depth > 0.0 && its_depth < depth);
        }
    }
    if nearer < LEAK_NEIGHBOURS {
        return;
    }
    var seen = neighbours(params.pinhole, params.first_pixel, x, y, LEAK, f32(params.ring));
    let best = vote(&seen);
    let chosen = seen.all[best.chosen];
    if best.votes >= LEAK_NEIGHBOURS && chosen.depth + AGREE_SPACINGS * chosen.radius < depth {
        material[here].w = LEAK;
    }
}
