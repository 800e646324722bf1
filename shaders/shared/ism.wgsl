// Virtual point lights and the keys of their maps. Twins: src/gi/vpl.rs and src/gi/ism.rs.
#import dot3

override SURFEL_BITS: u32;
override DISTANCE_SHIFT: u32;
override DISTANCE_BASE: u32;
override DISTANCE_MAX: u32;

const PI: f32 = 3.14159265;
const UNSEEN: u32 = 0xffffffffu;

struct Vpl {
    position: vec3f,    // relative to the scene's origin
    softening: f32,     // the area that it stands for, over pi
    normal: vec3f,
    shininess: f32,     // of its specular lobe
    flux: vec3f,        // reflected diffusely, W
    specular: f32,      // reflectance, 0 to 1
    incident: vec3f,    // received, W
    spacing: f32,       // local, of its surface
    mirrored: vec3f,    // where a mirror would send the light
    slice: u32,         // first surfel of the slice that its map shows
    right: vec3f,       // columns of its map
    pad0: u32,
    up: vec3f,          // rows of its map
    pad1: u32,
}

fn ism_key(distance: f32, surfel: u32) -> u32 {
    let steps = (max(bitcast<u32>(distance), DISTANCE_BASE) - DISTANCE_BASE) >> DISTANCE_SHIFT;
    return (min(steps, DISTANCE_MAX) << SURFEL_BITS) | surfel;
}

fn ism_distance(key: u32) -> f32 {
    return bitcast<f32>(((key >> SURFEL_BITS) << DISTANCE_SHIFT) + DISTANCE_BASE);
}

// x to the power y; 0 to the power 0 is 1, which the shader language leaves open.
fn power(x: f32, y: f32) -> f32 {
    return select(pow(x, y), select(0.0, 1.0, y == 0.0), x == 0.0);
}

fn luminance(colour: vec3f) -> f32 {
    return 0.2126 * colour.x + 0.7152 * colour.y + 0.0722 * colour.z;
}
