// Emission from area lights: directions and densities. A light is one emissive triangle, chosen
// with chance pmf in proportion to its power; a point on it is uniform in area, a direction is
// cosine-distributed on the side, or sides, that emit.

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
