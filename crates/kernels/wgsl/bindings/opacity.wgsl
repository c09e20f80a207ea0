// Surfaces that are not everywhere there (alpha): whether a ray passes where it meets one. The same for
// rays of every kind, so that all strategies see the same surface: what is let through is a factor
// of visibility, and no density or weight knows of it.

#include "bindings/slots.wgsl"

/// How much of a surface is there at a point, in [0, 1].
fn coverage(surface: Surface) -> f32 {
    if (!may_have(FEATURE_CUTOUTS)) {
        return 1.0;
    }
    let numbers = load_slot_numbers(surface.material);
    let mode = bitcast<u32>(numbers.w) & ((1u << OPACITY_BITS) - 1u);
    if (mode == OPACITY_NONE) {
        return 1.0;
    }
    let alpha = numbers.y * surface.color.w * slot_value(surface.material, SLOT_OPACITY, surface.uv0, surface.uv1);
    if (mode == OPACITY_MASK) {
        return select(0.0, 1.0, alpha >= numbers.z);
    }
    return saturate(alpha);
}

/// Whether a ray passes through the triangle it meets at barycentric coordinates u and v. Chance is drawn
/// from the ray itself: another ray, another draw.
fn passes(id: u32, u: f32, v: f32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if (!may_have(FEATURE_CUTOUTS)) {
        return false;
    }
    let surface = load_surface(id, u, v);
    let o = bitcast<vec3<u32>>(origin);
    let d = bitcast<vec3<u32>>(direction);
    // Mixed one by one: what pcg4d makes of keys that differ in few high bits is correlated.
    let key = vec4<u32>(mix32(o.x ^ mix32(d.x)), mix32(o.y ^ mix32(d.y)), mix32(o.z ^ mix32(d.z)), mix32(id ^ params.seed));
    return unit_float(pcg4d(key)).x >= coverage(surface);
}
