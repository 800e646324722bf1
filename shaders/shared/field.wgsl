// The mirrors as a smooth field. Twin: src/reflect/sscr/field.rs.
// Reads `params.field` and the buffer `texels` of the kernel that imports it: two to a pixel, point and spacing, then ray and
// 0 where the cell to the lower right is no part of the field, else 1 and a bit for each side on which the field ends.

override OUTLINE: f32; // pixels

struct FieldParams {
    origin: vec2f,      // pixel (centres at + 0.5) of the place (0, 0)
    size: vec2u,        // pixels
}

struct Sample {
    valid: bool,
    point: vec3f,       // of the mirror, relative to the scene's origin
    spacing: f32,
    ray: vec3f,         // reflected direction, of about unit length
    point_x: vec3f,     // slopes per pixel to the right and down
    point_y: vec3f,
    ray_x: vec3f,
    ray_y: vec3f,
}

fn in_rectangle(at: vec2f) -> bool {
    return at.x >= 0.0 && at.y >= 0.0 && at.x < f32(params.field.size.x) && at.y < f32(params.field.size.y);
}

fn texel_of(at: vec2f) -> u32 {
    return u32(at.y) * params.field.size.x + u32(at.x);
}

// 0 outside of the field.
fn sides(at: vec2f) -> u32 {
    if !in_rectangle(at) {
        return 0u;
    }
    return u32(texels[2u * texel_of(at) + 1u].w);
}

fn field_sample(at: vec2f) -> Sample {
    var s: Sample;
    if sides(at) == 0u {
        return s;
    }
    let first = 2u * texel_of(at);
    let below = first + 2u * params.field.size.x;
    let u = at.x - floor(at.x);
    let v = at.y - floor(at.y);

    let p_top = texels[first + 2u] - texels[first];
    let p_bottom = texels[below + 2u] - texels[below];
    let p_left = texels[below] - texels[first];
    let p_other = texels[below + 2u] - texels[first + 2u];
    let p_down = p_left + u * (p_other - p_left);
    let p = texels[first] + u * p_top + v * p_down;

    let r_top = texels[first + 3u] - texels[first + 1u];
    let r_bottom = texels[below + 3u] - texels[below + 1u];
    let r_left = texels[below + 1u] - texels[first + 1u];
    let r_other = texels[below + 3u] - texels[first + 3u];
    let r_down = r_left + u * (r_other - r_left);
    let r = texels[first + 1u] + u * r_top + v * r_down;

    s.valid = true;
    s.point = p.xyz;
    s.spacing = p.w;
    s.ray = r.xyz;
    s.point_x = (p_top + v * (p_bottom - p_top)).xyz;
    s.point_y = p_down.xyz;
    s.ray_x = (r_top + v * (r_bottom - r_top)).xyz;
    s.ray_y = r_down.xyz;
    return s;
}

fn beside(offset: i32, part: f32) -> bool {
    return offset == 0 || (offset < 0 && part < OUTLINE) || (offset > 0 && part > 1.0 - OUTLINE);
}

// Whether a place lies in the field, and not on its outline.
fn is_inside(at: vec2f) -> bool {
    let ends = sides(at);
    if ends == 0u {
        return false;
    }
    let part = at - floor(at);
    for (var k = 0u; k < 9u; k++) {
        if k == 4u {
            continue;
        }
        let bit = select(k, k - 1u, k > 4u);
        let offset = vec2i(i32(k % 3u) - 1, i32(k / 3u) - 1);
        if (ends & (2u << bit)) != 0u && beside(offset.x, part.x) && beside(offset.y, part.y) {
            return false;
        }
    }
    return true;
}
