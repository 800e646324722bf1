// A fragment of the nearest surface as one integer that sorts by depth. Twin: `depth_key` in src/gbuffer/mod.rs.

const EMPTY: u32 = 0xffffffffu;

fn depth_key(depth: f32, mirror: bool, rim: bool) -> u32 {
    return (bitcast<u32>(depth) & ~1u) | select(0u, 1u, mirror) | select(0u, 0x80000000u, rim);
}

fn key_depth(key: u32) -> f32 {
    return bitcast<f32>(key & 0x7ffffffeu);
}

fn key_mirror(key: u32) -> bool {
    return (key & 1u) == 1u;
}
