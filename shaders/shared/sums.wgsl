// Weighted sums in fixed point, twelve to a pixel. Twin: `Sums` in src/gbuffer/visibility.rs.
// Adds to the buffer `sums` of the kernel that imports it.

// Scale of the sums of a pixel with `count` fragments: count times scale stays within 2^30.
fn sum_scale(count: u32) -> f32 {
    let bits = 32u - countLeadingZeros(count);
    return bitcast<f32>((157u - min(bits, 30u)) << 23u);
}

// Most materials are neither glossy nor mirrors: nothing is cheaper than adding nothing.
fn add(slot: u32, value: f32) {
    let fixed = i32(value);
    if fixed != 0 {
        atomicAdd(&sums[slot], fixed);
    }
}

// Adds a surfel, weighted and scaled by `s`, that lies so much behind the nearest and has that radius, both over the
// nearest's depth.
fn add_surfel(pixel: u32, its: Attributes, s: f32, behind: f32, radius: f32) {
    let slot = pixel * 12u;
    add(slot, s);
    add(slot + 1u, behind * s);
    add(slot + 2u, its.gloss.x * s);
    add(slot + 3u, its.gloss.y * s);
    add(slot + 4u, its.albedo.x * s);
    add(slot + 5u, its.albedo.y * s);
    add(slot + 6u, its.albedo.z * s);
    add(slot + 7u, its.albedo.w * s);
    add(slot + 8u, its.normal.x * s);
    add(slot + 9u, its.normal.y * s);
    add(slot + 10u, its.normal.z * s);
    add(slot + 11u, radius * s);
}
