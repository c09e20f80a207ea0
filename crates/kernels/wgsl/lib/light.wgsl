// Emission: directions and densities. A light is chosen with chance pmf in proportion to its power.
// A point on an emissive triangle is uniform in area, its direction is cosine-distributed on the
// side, or sides, that emit. A point light, a spot too, emits uniformly into the cone in which it
// shines. A light at infinity has a direction, and emits from a disk that covers the scene.

/// Density per solid angle of the emitted direction at |cos| to the light's normal; 0 where the
/// light does not emit.
fn emission_pdf_sa(cos_front: f32, emits_back: bool) -> f32 {
    if (emits_back) {
        return 0.5 * abs(cos_front) * INV_PI;
    }
    return max(cos_front, 0.0) * INV_PI;
}

/// A direction from the light, in world space; u.z chooses the side.
fn sample_emission(ng: vec3<f32>, emits_back: bool, u: vec3<f32>) -> vec3<f32> {
    let side = select(1.0, -1.0, emits_back && u.z < 0.5);
    return frame_from_normal(side * ng) * sample_cosine_hemisphere(u.xy);
}

/// Vose's alias method: the entry drawn for u, given u's cell, the cell's threshold and its alias.
fn alias_pick(cell: u32, within: f32, threshold: f32, alias_entry: u32) -> u32 {
    return select(alias_entry, cell, within < threshold);
}

/// Whether an emissive triangle shines towards a direction at this cosine to its normal.
fn emits_towards(cos_front: f32, emits_back: bool) -> bool {
    return cos_front > 0.0 || (emits_back && cos_front != 0.0);
}

// Cone.falloff: how a spot's intensity falls from 1 to 0.
/// Not at all: a point light.
const FALLOFF_NONE: u32 = 0u;
/// The square of the cosine's place between the cones' (glTF).
const FALLOFF_COSINE_SQUARED: u32 = 1u;
/// The smoothstep of the cosine's place (pbrt).
const FALLOFF_SMOOTHSTEP: u32 = 2u;
/// The angle's place (Mitsuba).
const FALLOFF_ANGLE: u32 = 3u;

/// Into which directions a point light shines.
struct Cone {
    axis: vec3<f32>,
    falloff: u32,
    /// 1 - cosine, or for FALLOFF_ANGLE the angle, up to which intensity is full and from which it is
    /// 0; full < zero.
    full: f32,
    zero: f32,
}

/// Intensity in a direction as a share of the full one.
fn cone_falloff(cone: Cone, direction: vec3<f32>) -> f32 {
    if (cone.falloff == FALLOFF_NONE) {
        return 1.0;
    }
    let chord = direction - cone.axis; // 1 - cosine by it: exact in narrow cones too
    let angle = angle_of(length(cross(cone.axis, direction)), dot(cone.axis, direction));
    let at = select(0.5 * dot(chord, chord), angle, cone.falloff == FALLOFF_ANGLE);
    let place = clamp((cone.zero - at) / (cone.zero - cone.full), 0.0, 1.0);
    switch cone.falloff {
        case FALLOFF_COSINE_SQUARED: { return place * place; }
        case FALLOFF_SMOOTHSTEP: { return place * place * (3.0 - 2.0 * place); }
        default: { return place; }
    }
}
