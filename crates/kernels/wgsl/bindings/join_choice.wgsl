// Which light vertices a camera vertex is joined to, and what one join contributes.

/// Candidates for each join chosen by importance from a pool.
const CANDIDATES: u32 = 8u;

struct Choice {
    slot: u32,
    /// What the estimate is multiplied by for the choice.
    weight: f32,
}

struct Join {
    /// Unweighted contribution, visibility left out.
    contribution: vec3<f32>,
    mis_weight: f32,
    /// From the camera vertex to the light vertex.
    wi: vec3<f32>,
}

/// The contribution of joining a camera vertex to a light vertex with s >= 2, and its MIS weight.
fn evaluate_join(path: Path, vertex: Vertex, stored: LightVertex, y: JoinVertex) -> Join {
    let between = stored.position - vertex.surface.position;
    let distance_squared = dot(between, between);
    if (distance_squared == 0.0) {
        return Join(vec3<f32>(0.0), 0.0, vec3<f32>(0.0, 0.0, 1.0));
    }
    let distance = sqrt(distance_squared);
    let wi = between / distance;
    let f_z = bsdf_eval(vertex.material, frame_of(vertex.surface), vertex.wo, wi, TRANSPORT_RADIANCE);
    let from_light = light_end_scatter(stored, y, -wi);
    let cosines = abs(dot(vertex.surface.ng, wi) * dot(y.surface.ng, wi));
    let leaving = medium_towards(path.medium, vertex.surface, vertex.material, vertex.wo, wi);
    let medium = medium_before(leaving, y.surface, y.material, -wi);
    let contribution = vertex.throughput * f_z * from_light * medium_transmittance(medium, distance)
        * (cosines / distance_squared);
    if (!contributes(contribution)) {
        return Join(contribution, 0.0, wi);
    }
    return Join(contribution, join_mis_weight(path, vertex, stored, y, wi, distance_squared), wi);
}

fn join_mis_weight(path: Path, vertex: Vertex, stored: LightVertex, y: JoinVertex, wi: vec3<f32>, distance_squared: f32) -> f32 {
    let config = mis_config();
    let t = path.depth + 2u;
    let cos_y = abs(dot(y.surface.ng, wi));
    let cos_z = abs(dot(vertex.surface.ng, wi));
    let pdf_y = scatter_pdf(vertex, vertex.wo, wi, TRANSPORT_RADIANCE) * cos_y / distance_squared;
    let camera_earlier = mis_earlier(config, vertex.mis, camera_previous_factor(config, t, vertex.mis, vertex.ending),
        scatter_pdf(vertex, wi, vertex.wo, TRANSPORT_IMPORTANCE));
    let pdf_z = light_end_pdf(y, stored.wo, -wi, TRANSPORT_IMPORTANCE) * cos_z / distance_squared;
    return mis_weight_join(config, join_factor(config, y.ending, vertex.ending), pdf_y, light_earlier(stored, y, -wi),
        pdf_z, camera_earlier);
}

/// The light path joined to a camera path: its own, or one of the pool drawn for this vertex.
fn draw_light_path(path: Path) -> u32 {
    if (!has_flag(FLAG_POOL)) {
        return batch_place(path);
    }
    if (params.join == JOIN_K_STEP) {
        return 0u; // choose_from_pool draws a vertex of any of them
    }
    let bits = random_bits(path.index, path.sample, dimension(DRAW_JOIN, path.depth));
    return uniform_index_bits(bits.x, params.n_light_paths);
}

/// How many joins the vertex is to make.
fn join_count(light_path: u32) -> u32 {
    if (params.join == JOIN_K_STEP) {
        if (has_flag(FLAG_POOL)) {
            return select(0u, params.k, light_paths[pool_size_at()] != 0u);
        }
        let n = path_vertex_count(light_path);
        return select(min(params.k, n), select(0u, params.k, n != 0u), has_flag(FLAG_IMPORTANCE));
    }
    return path_vertex_count(light_path); // full: all; single-step: 1 where the path has an end
}

/// The light vertex of the j-th join.
fn choose_light_vertex(path: Path, vertex: Vertex, light_path: u32, j: u32) -> Choice {
    switch params.join {
        case JOIN_FULL: { return Choice(nth_from_end(light_path, j), 1.0); }
        case JOIN_SINGLE_STEP: { return choose_end(vertex, light_path); }
        default: {
            if (has_flag(FLAG_POOL)) {
                return choose_from_pool(path, vertex, j);
            }
            return choose_from_reservoir(light_path, j);
        }
    }
}

/// Full: the light path is linked from its end.
fn nth_from_end(light_path: u32, j: u32) -> u32 {
    var slot = path_second_word(light_path);
    for (var i = 0u; i < j && slot != NONE; i += 1u) {
        slot = load_light_vertex(slot).link;
    }
    return slot;
}

/// Single-step: divided by the chance that both paths ended here.
fn choose_end(vertex: Vertex, light_path: u32) -> Choice {
    let y_ending = light_ending(load_light_vertex(light_path));
    return Choice(light_path, 1.0 / (y_ending * vertex.ending)); // > 0: both did end
}

/// K-step: min(K, n) of the path's n vertices, or K drawn by importance with replacement.
fn choose_from_reservoir(light_path: u32, j: u32) -> Choice {
    let slot = light_path * params.k + j;
    let n = path_vertex_count(light_path);
    if (!has_flag(FLAG_IMPORTANCE)) {
        return Choice(slot, f32(n) / f32(min(params.k, n))); // n > 0: join_count
    }
    let total = bitcast<f32>(path_second_word(light_path));
    let importance = vertex_importance(load_light_vertex(slot)); // > 0: it was chosen by it
    return Choice(slot, total / (f32(params.k) * importance));
}

/// The slot of a vertex of the pool; all 32 bits, since 24 would favour some of a million.
fn draw_from_pool(bits: vec4<u32>, n_vertices: u32) -> u32 {
    return light_paths[pool_table_at() + uniform_index_bits(bits.x, n_vertices)];
}

/// Pool: uniform with replacement from all V vertices of P paths.
fn choose_from_pool(path: Path, vertex: Vertex, j: u32) -> Choice {
    let n_vertices = light_paths[pool_size_at()];
    let estimator = f32(n_vertices) / (f32(params.k) * f32(params.n_light_paths));
    if (has_flag(FLAG_IMPORTANCE)) {
        return resample_from_pool(path, vertex, j, n_vertices, estimator);
    }
    let bits = random_bits(path.index, path.sample, dimension(DRAW_JOIN + 1u + j, path.depth));
    return Choice(draw_from_pool(bits, n_vertices), estimator);
}

/// Resampled importance sampling (Talbot 2005): one of CANDIDATES by its weighted, unshadowed
/// contribution.
fn resample_from_pool(path: Path, vertex: Vertex, j: u32, n_vertices: u32, estimator: f32) -> Choice {
    var chosen = NONE;
    var chosen_target = 0.0;
    var total = 0.0;
    for (var i = 0u; i < CANDIDATES; i += 1u) {
        let bits = random_bits(path.index, path.sample, dimension(DRAW_JOIN + 1u + j * CANDIDATES + i, path.depth));
        let slot = draw_from_pool(bits, n_vertices);
        let stored = load_light_vertex(slot);
        let candidate = evaluate_join(path, vertex, stored, load_join_vertex(stored));
        let target_value = max3(candidate.contribution) * candidate.mis_weight;
        total += target_value;
        if (unit_float(bits).y * total < target_value) {
            chosen = slot;
            chosen_target = target_value;
        }
    }
    if (chosen == NONE) {
        return Choice(NONE, 0.0);
    }
    return Choice(chosen, estimator * total / (f32(CANDIDATES) * chosen_target)); // > 0: it was chosen by it
}
