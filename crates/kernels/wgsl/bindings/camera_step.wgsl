// A camera subpath arrives at a vertex, or leaves the scene: light found by hitting it (s = 0), light
// sampled afresh (s = 1), and the path goes on.

/// What a path finds that hit nothing.
fn escape(path: Path) {
    if (may_have(FEATURE_ENVIRONMENT) && params.environment_at != NONE && has_flag(FLAG_HIT)) {
        add_environment(path);
    }
}

/// The path from the vertex on; its throughput is 0 where it ends.
fn step_camera(path: Path, vertex: Vertex) -> Path {
    let t = path.depth + 2u; // with the lens and this vertex
    if (vertex.surface.light != NONE) {
        add_emission(path, vertex, t);
    }
    if (has_flag(FLAG_NEE) && params.n_lights != 0u && is_connectible(vertex.material) && length_allowed(1u, t)) {
        sample_light(path, vertex);
    }
    let u = scatter_numbers(path, 0u);
    let survival = camera_survival(path, vertex);
    if (u.w >= survival || !length_allowed(0u, t + 1u)) {
        return ended(path);
    }
    let factor = camera_previous_factor(mis_config(), t, vertex.mis, vertex.ending);
    return scatter(path, vertex, survival, factor, u.xyz, TRANSPORT_RADIANCE);
}

/// Chance that roulette spares a camera path: by its throughput, but in single-step, whose join needs the
/// chance of an end to be that which MIS counts.
fn camera_survival(path: Path, vertex: Vertex) -> f32 {
    if (params.join == JOIN_SINGLE_STEP) {
        return vertex.survival;
    }
    return survival_by_throughput(vertex.material, max3(vertex.throughput), params.least_throughput, path.depth);
}

/// Strategy (0, t): the path hit a light.
fn add_emission(path: Path, vertex: Vertex, t: u32) {
    let cos_front = dot(vertex.surface.ng, vertex.wo);
    let radiance = emitted_radiance(vertex.material, cos_front);
    if (!has_flag(FLAG_HIT) || !contributes(radiance)) {
        return;
    }
    var weight = 1.0; // seen directly: by no other strategy
    if (t > 2u) {
        let config = mis_config();
        let light = load_light(vertex.surface.light);
        let pdf_position = light.pmf / light.measure; // measure > 0
        let emits_back = (vertex.material.flags & MATERIAL_EMITS_BACK) != 0u;
        let pdf_emission = pdf_position * emission_pdf_sa(cos_front, emits_back) * params.emitter_survival;
        let ending_y = ending_chance(config, params.emitter_survival);
        let factor = emitter_factor(config, ending_y, vertex.mis.ending);
        let ratio = light_chance_ratio(vertex.surface.light, light, light_place_left(path));
        weight = mis_weight_hit(config, vertex.mis, factor, pdf_position * ratio, pdf_emission);
    }
    film_add(path.index, group_of_light(vertex.surface.light), vertex.throughput * radiance * strategy_weight(0u, t, weight));
}

/// Strategy (0, t) at infinity, before any arrival: densities are per solid angle.
fn add_environment(path: Path) {
    let t = path.depth + 2u;
    let environment = load_environment();
    let seen = environment_towards(environment, path.direction);
    var weight = 1.0; // seen directly: by no other strategy
    if (t > 2u && environment.light != NONE) {
        let config = mis_config();
        let light = load_light(environment.light);
        let pdf_position = light.pmf * seen.pdf;
        let pdf_emission = pdf_position * params.emitter_survival / light.measure; // measure > 0
        let factor = emitter_factor(config, ending_chance(config, params.emitter_survival), path.mis.ending);
        let ratio = light_chance_ratio(environment.light, light, light_place_left(path));
        weight = mis_weight_hit(config, path.mis, factor, pdf_position * ratio, pdf_emission);
    }
    film_add(path.index, group_of_light(environment.light),
        path.throughput * medium_transmittance(path.medium, F32_MAX) * seen.radiance * strategy_weight(0u, t, weight));
}

/// Strategy (1, t): a point on a light drawn for this vertex.
fn sample_light(path: Path, vertex: Vertex) {
    let u = random(path.index, path.sample, dimension(DRAW_NEE, path.depth));
    let drawn = draw_light(light_place(vertex), u.xw);
    if (drawn.index == NONE) {
        return;
    }
    let light = load_light(drawn.index);
    let point = draw_light_point(light, u.yz, path.index, path.sample, dimension(DRAW_ENVIRONMENT, path.depth));
    join_light(path, vertex, light.group, see_light(light, point, vertex.surface.position, drawn.ratio), 1.0, 1.0);
}
