// Which light vertices a camera vertex is joined to by full and k-step, and by what the choice is weighted.

/// Candidates for each join chosen by importance from a pool.
const CANDIDATES: u32 = 8u;

/// The light path joined to a camera path: its own, or one of the pool drawn for this vertex.
fn draw_light_path(path: Path) -> u32 {
    if (!has_flag(FLAG_POOL)) {
        return batch_place(path);
    }
    if (params.join == JOIN_K_STEP) {
        return 0u; // a vertex of any of them is drawn
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
    return path_vertex_count(light_path); // full: all
}

/// How many candidates a join is resampled from.
fn candidate_count() -> u32 {
    return select(1u, CANDIDATES, has_flag(FLAG_POOL) && has_flag(FLAG_IMPORTANCE) && params.join == JOIN_K_STEP);
}

/// Full: the j-th slot of a light path from its end, from where it is linked; NONE where a vertex found no
/// room, and the batch is to run again.
fn nth_from_end(light_path: u32, j: u32) -> u32 {
    var slot = path_second_word(light_path);
    for (var i = 0u; i < j && slot != NONE; i += 1u) {
        slot = load_light_vertex(slot).link;
    }
    return slot;
}

/// The slot of a candidate of the j-th join, for full the linked one.
fn choose_slot(path: Path, light_path: u32, j: u32, bits: vec4<u32>, linked: u32) -> u32 {
    if (params.join == JOIN_FULL) {
        return linked;
    }
    if (has_flag(FLAG_POOL)) {
        return draw_from_pool(bits, light_paths[pool_size_at()]);
    }
    return light_path * params.k + j;
}

/// Numbers of a candidate, where the join draws from a pool.
fn candidate_bits(path: Path, j: u32, candidate: u32) -> vec4<u32> {
    if (params.join == JOIN_FULL || !has_flag(FLAG_POOL)) {
        return vec4<u32>(0u);
    }
    return random_bits(path.index, path.sample, dimension(DRAW_JOIN + 1u + j * candidate_count() + candidate, path.depth));
}

/// The slot of a vertex of the pool; all 32 bits, since 24 would favour some of a million.
fn draw_from_pool(bits: vec4<u32>, n_vertices: u32) -> u32 {
    return light_paths[pool_table_at() + uniform_index_bits(bits.x, n_vertices)];
}

/// What the estimate of a join is multiplied by for the choice.
fn choice_weight(light_path: u32, stored: LightVertex) -> f32 {
    if (params.join == JOIN_FULL) {
        return 1.0;
    }
    if (has_flag(FLAG_POOL)) {
        // with replacement from all V vertices of P paths
        let n_vertices = light_paths[pool_size_at()];
        return f32(n_vertices) / (f32(params.k) * f32(params.n_light_paths));
    }
    return reservoir_weight(light_path, stored);
}

/// K-step: min(K, n) of the path's n vertices, or K drawn by importance with replacement.
fn reservoir_weight(light_path: u32, stored: LightVertex) -> f32 {
    let n = path_vertex_count(light_path);
    if (!has_flag(FLAG_IMPORTANCE)) {
        return f32(n) / f32(min(params.k, n)); // n > 0: join_count
    }
    let total = bitcast<f32>(path_second_word(light_path));
    let importance = vertex_importance(stored); // > 0: it was chosen by it
    return total / (f32(params.k) * importance);
}
