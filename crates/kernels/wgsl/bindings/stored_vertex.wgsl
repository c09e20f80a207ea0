// A stored light vertex with its surface: what a join needs of it. y_0 is here only where it is on
// a triangle, to be projected onto the film; it is joined by bindings/light_join.wgsl.

/// A stored vertex on its surface, before anything is known of the material there.
fn load_stored_surface(stored: LightVertex) -> Surface {
    return load_surface(stored.triangle, stored.u, stored.v);
}

/// Whether a surface may scatter from one direction into another, into a density: by its sides.
fn may_scatter(surface: Surface, from_direction: vec3<f32>, to_direction: vec3<f32>) -> bool {
    let reflects = dot(surface.ng, from_direction) * dot(surface.ng, to_direction) > 0.0;
    return reflects || (may_have(FEATURE_TRANSMISSION) && transmits_density(surface.material));
}

/// What a light subpath's end sends towards wi, importance-mode scattering times its throughput, no
/// cosine, with densities as `scatter_terms` has them; at y_0 the emission (throughput holds radiance over
/// density).
fn light_end_terms(stored: LightVertex, end: Shaded, wi: vec3<f32>) -> BsdfTerms {
    if (stored.s == 1u) {
        let emits = any(emitted_radiance(end.material, dot(end.surface.ng, wi)) > vec3<f32>(0.0));
        return BsdfTerms(select(vec3<f32>(0.0), stored.throughput, emits), 0.0, 0.0);
    }
    let terms = bsdf_terms(end.material, frame_of(end.surface), stored.wo, wi, TRANSPORT_IMPORTANCE);
    let q = survival(end.material);
    return BsdfTerms(stored.throughput * terms.f, q * terms.pdf_fwd, q * terms.pdf_rev);
}

/// What the strategies with fewer light vertices weigh at a stored vertex with s >= 2: by its chance of
/// being an end, and the density of scattering from wi back to where it was reached from.
fn light_earlier(stored: LightVertex, ending: f32, pdf_rev: f32) -> f32 {
    let config = mis_config();
    let state = light_vertex_mis(stored);
    return mis_earlier(config, state, light_previous_factor(config, stored.s, state, ending), pdf_rev);
}
