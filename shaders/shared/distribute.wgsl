// One region for each point. Twin: `distribute` in src/reflect/sscr/distribute.rs.
// Reads `params` and `regions` of the kernel that imports it.

struct Region {
    first: vec2u,               // of the smallest rectangle around it, pixels
    size: vec2u,                // of that, pixels
    accumulated_weight: f32,    // of this and all larger regions
    pad: u32,
}

struct DistributeParams {
    region_count: u32,
    weighted: u32,      // 1: by weight; 0: by turns
    turn: u32,          // pass of `sscr.passes`, counted from 0
    base: u32,          // of the Halton sequence
    digits: u32,
    scale: f32,
    pad0: u32,
    pad1: u32,
}

// The Halton number of an index, 0 to 1.
fn halton(index: u32) -> f32 {
    var rest = index;
    var mirrored = 0u;
    for (var k = 0u; k < params.distribute.digits; k++) {
        mirrored = mirrored * params.distribute.base + rest % params.distribute.base;
        rest /= params.distribute.base;
    }
    return f32(mirrored) * params.distribute.scale;
}

// The region of a point, counted from 0.
fn distribute(index: u32) -> u32 {
    if params.distribute.weighted == 0u {
        return (index + params.distribute.turn) % params.distribute.region_count;
    }
    let number = halton(index);
    var first = 0u;
    var count = params.distribute.region_count;
    while count > 0u {
        let half = count / 2u;
        if regions[first + half].accumulated_weight <= number {
            first += half + 1u;
            count -= half + 1u;
        } else {
            count = half;
        }
    }
    return min(first, params.distribute.region_count - 1u);
}
