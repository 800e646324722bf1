// A fragment of the nearest surface as one integer that sorts by depth. Twin: `depth_key` in src/gbuffer/mod.rs.

const EMPTY: u32 = 0xffffffffu;

fn depth_key(depth: f32, class_bits: u32, rim: bool) -> u32 {
    return (bitcast<u32>(depth) & ~3u) | class_bits | select(0u, 0x80000000u, rim);
}

fn key_depth(key: u32) -> f32 {
    return bitcast<f32>(key & 0x7ffffffcu);
}

fn key_class(key: u32) -> u32 {
    return key & 3u;
}
