// Weight of a fragment at `t` = squared distance over squared half width. Twin: `weight` in src/gbuffer/disc.rs.
fn weight(t: f32) -> f32 {
    let u = 1.0 - 0.25 * t;
    let u2 = u * u;
    let u4 = u2 * u2;
    return u4 * u4;
}
