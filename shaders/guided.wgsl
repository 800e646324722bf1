// Searches the mirrors' charts for all pixels that show each point, and appends them.
// One thread per point. CPU twin: `Guide` in src/reflect/sscr/guided.rs.
#import newton
#import hits
#import surfel

override POINT_GROUP: u32 = 64u; // threads per workgroup
override SAME_ROOT: f32;         // pixels
override STAY: f32;              // pixels
override END_REACH: f32;         // pixels
override MAP_SIDE: u32;
override LARGEST_REACH: f32;     // pixels

// Roots of a point that a new one is compared with.
const KNOWN: u32 = 32u;
// Three children of every level of a tree over the largest picture wait at most.
const WAITING: u32 = 64u;

const CHILDREN: u32 = 0u;
const LEAF: u32 = 1u;
const MAP: u32 = 2u;

struct GuidedParams {
    field: FieldParams,
    first: u32,         // of the order, of this dispatch
    end: u32,           // one past its last
    band_start: u32,    // number of the band's first point in the cloud
    band_count: u32,    // points in the band
    chart_count: u32,
    chunk: u32,         // number of the dispatch: its counts have a place of their own
    self_hit: f32,      // over the local spacing
    splat_size: f32,    // half width of a surfel's disc over its radius
}

// A chart, or a part of its tree.
struct BeamNode {
    centre: vec3f,
    radius: f32,
    axis: vec3f,        // unit
    cosine: f32,        // of the cone's half angle
    sine: f32,
    near_squared: f32,
    kind: u32,          // CHILDREN, LEAF or MAP
    first: u32,         // child, or place of the map in `seeds`
    count: u32,         // of children
    pad: u32,
    start: vec2f,       // where searches start in a leaf
}

@group(0) @binding(0) var<uniform> params: GuidedParams;
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> places: array<vec4f>;
@group(0) @binding(3) var<storage, read> finishes: array<vec4u>;
@group(0) @binding(4) var<storage, read> texels: array<vec4f>;
// The charts, then the nodes of their trees.
@group(0) @binding(5) var<storage, read> nodes: array<BeamNode>;
// Direction maps: right and scale, up, axis; then the places, two to a value.
@group(0) @binding(6) var<storage, read> seeds: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> hits: array<Hit>;
// Hits in the list; then, for each dispatch: points with hits, hits, steps, and sixteenths of the pixels of their splats.
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;

var<workgroup> group_counts: array<atomic<u32>, 4>;

var<private> known: array<vec2f, KNOWN>;
var<private> known_count: u32;
var<private> kept: u32;
var<private> area: u32;

fn may_show(node: BeamNode, point: vec3f) -> bool {
    let to_point = point - node.centre;
    let squared = dot3(to_point, to_point);
    let along = dot3(to_point, node.axis);
    let tangent = max(squared - node.radius * node.radius, 0.0);
    let least = node.cosine * sqrt(tangent) - node.sine * node.radius;
    return squared <= node.near_squared || along >= least;
}

// The place that reflects about in a direction.
fn map_place(map: u32, direction: vec3f) -> vec2f {
    let right = seeds[map];
    let along = dot3(seeds[map + 2u].xyz, direction) + sqrt(dot3(direction, direction));
    let over = right.w / max(along, 1e-6);
    let middle = f32(MAP_SIDE) * 0.5;
    let last = f32(MAP_SIDE - 1u);
    let column = u32(clamp(dot3(right.xyz, direction) * over + middle, 0.0, last));
    let row = u32(clamp(dot3(seeds[map + 1u].xyz, direction) * over + middle, 0.0, last));
    let cell = row * MAP_SIDE + column;
    let pair = seeds[map + 3u + cell / 2u];
    return select(pair.xy, pair.zw, (cell & 1u) == 1u);
}

// Appends a root that is not yet known.
fn keep(root: Root, point: u32, place: vec4f, mirror: bool) {
    for (var k = 0u; k < min(known_count, KNOWN); k++) {
        let apart = known[k] - root.at;
        if apart.x * apart.x + apart.y * apart.y < SAME_ROOT * SAME_ROOT {
            return;
        }
    }
    known[known_count % KNOWN] = root.at;
    known_count++;
    // A mirror does not show its own points.
    if mirror && root.distance < params.self_hit * root.spacing {
        return;
    }
    kept++;
    var reach = root.magnification * (place.w * params.splat_size);
    if root.at_end {
        reach += END_REACH;
    }
    let side = min(reach, vec2f(LARGEST_REACH)) * 2.0 + 1.0;
    area += 1u + u32(side.x * side.y * 0.0625);
    append(Hit(root.at + params.field.origin, reach, point, root.distance));
}

fn search(index: u32, place: vec4f, mirror: bool) -> u32 {
    let point = place.xyz;
    var steps = 0u;
    var waiting: array<u32, WAITING>;
    for (var chart = 0u; chart < params.chart_count; chart++) {
        if nodes[chart].kind == MAP {
            if !may_show(nodes[chart], point) {
                continue;
            }
            // The chart is not one point: a second look, from where the first says that the ray leaves.
            let map = nodes[chart].first;
            let first = map_place(map, point - nodes[chart].centre);
            var near = nodes[chart].centre;
            if sides(first) > 0u {
                near = texels[2u * texel_of(first)].xyz;
            }
            let start = map_place(map, point - near);
            if sides(start) > 0u {
                let root = newton(start, point, vec2f(0.0), 3.4e38);
                steps += root.steps;
                if root.found {
                    keep(root, index, place, mirror);
                }
            }
            continue;
        }
        waiting[0] = chart;
        var count = 1u;
        while count > 0u {
            count--;
            let node = nodes[waiting[count]];
            if !may_show(node, point) {
                continue;
            }
            if node.kind == CHILDREN {
                for (var k = 0u; k < node.count && count < WAITING; k++) {
                    waiting[count] = node.first + k;
                    count++;
                }
                continue;
            }
            steps++;
            let first = newton_step(field_sample(node.start), point, false);
            if !(max(abs(first.step.x), abs(first.step.y)) <= STAY) {
                continue;
            }
            let next = take_step(node.start, first.step);
            if next.inside {
                let root = newton(next.at, point, node.start, STAY);
                steps += root.steps;
                if root.found {
                    keep(root, index, place, mirror);
                }
            }
        }
    }
    return steps;
}

@compute @workgroup_size(POINT_GROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    let number = params.first + id.x;
    if number < params.end {
        let index = order[number];
        let held = index - params.band_start;
        if index >= params.band_start && held < params.band_count {
            let steps = search(index, places[held], finish_mirror(finishes[held]) > 0.0);
            atomicAdd(&group_counts[0], min(kept, 1u));
            atomicAdd(&group_counts[1], kept);
            atomicAdd(&group_counts[2], steps);
            atomicAdd(&group_counts[3], area);
        }
    }
    workgroupBarrier();
    if thread < 4u {
        atomicAdd(&counts[1u + 4u * params.chunk + thread], atomicLoad(&group_counts[thread]));
    }
}
