// Strategy (1, t): a camera vertex joined to a point on a light.

/// One shadow ray. group: the light's; factor: c of the strategy (lib/mis.wgsl); estimator: what the contribution is
/// multiplied by for the chance of the join.
fn join_light(path: Path, vertex: Vertex, group: u32, light: LightSample, factor: f32, estimator: f32) {
    let t = path.depth + 2u;
    if (light.pdf <= 0.0 || !contributes(light.arriving)) {
        return;
    }
    let terms = scatter_terms(vertex, light.wi, TRANSPORT_RADIANCE);
    if (!contributes(light.arriving * terms.f)) {
        return;
    }
    let weight = strategy_weight(1u, t, light_join_weight(path, vertex, light, terms, factor));
    let leaving = medium_towards(path.medium, vertex.surface, vertex.material, vertex.wo, light.wi);
    let medium = select(light.inside, leaving, light.inside == NONE);
    let contribution = vertex.throughput * terms.f * light.arriving * medium_transmittance(medium, light.distance)
        * (abs(dot(vertex.surface.ng, light.wi)) / light.pdf * weight * estimator);
    if (contributes(contribution)) {
        push_shadow_ray(path.index, group, offset_origin(vertex.surface.position, normal_towards(vertex.surface, light.wi)),
            light.end, contribution);
    }
}

fn light_join_weight(path: Path, vertex: Vertex, light: LightSample, terms: BsdfTerms, factor: f32) -> f32 {
    let config = mis_config();
    let pdf_hit = terms.pdf_fwd * light.to_measure;
    let pdf_emit = light.pdf_emit * params.emitter_survival * abs(dot(vertex.surface.ng, light.wi));
    let earlier = mis_earlier(config, vertex.mis, camera_previous_factor(config, path.depth + 2u, vertex.mis, vertex.ending),
        terms.pdf_rev);
    return mis_weight_emitter(config, factor, pdf_hit, light.pdf, light.pdf_position, pdf_emit, earlier);
}
