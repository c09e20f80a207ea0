// How the join in use keeps the vertices of a light path: all of them, linked (full, pool); a
// reservoir of K (k-step); or the one where the path ended (single-step).

/// Slot of a light path's own words: in a pool its number, else its place in the batch.
fn light_path_slot(path: Path) -> u32 {
    if (has_flag(FLAG_POOL)) {
        return path.index;
    }
    return batch_place(path);
}

fn begin_light_path(slot: u32) {
    light_paths[slot * 2u] = 0u;
    light_paths[slot * 2u + 1u] = select(NONE, 0u, params.join == JOIN_K_STEP && !has_flag(FLAG_POOL));
}

/// Appends a vertex; its slot, or NONE where it did not fit (the host sees the count and runs the
/// batch again with more room).
fn append_light_vertex(vertex: LightVertex) -> u32 {
    let place = atomicAdd(&counters[COUNT_VERTICES], 1u);
    if (place >= params.append_capacity) {
        return NONE;
    }
    store_light_vertex(params.append_at + place, vertex);
    return params.append_at + place;
}

/// Uniform reservoir without replacement (Vitter 1985, algorithm R), n the count before this one.
fn keep_uniform(slot: u32, path: Path, vertex: LightVertex, n: u32) {
    let bits = random(path.index, path.sample, dimension(DRAW_LIGHT + DRAW_RESERVOIR, path.depth)).x;
    let place = select(uniform_index(bits, n + 1u), n, n < params.k);
    if (place < params.k) {
        store_light_vertex(slot * params.k + place, vertex);
    }
}

/// K independent reservoirs of one, by importance.
fn keep_by_importance(slot: u32, path: Path, vertex: LightVertex) {
    let importance = vertex_importance(vertex);
    let total = bitcast<f32>(light_paths[slot * 2u + 1u]) + importance;
    light_paths[slot * 2u + 1u] = bitcast<u32>(total);
    for (var r = 0u; r < params.k; r += 1u) {
        let u = random(path.index, path.sample, dimension(DRAW_LIGHT + DRAW_RESERVOIR + 1u + r, path.depth)).x;
        if (u * total < importance) {
            store_light_vertex(slot * params.k + r, vertex);
        }
    }
}

/// Whether every vertex is kept, linked from the path's end.
fn keeps_all() -> bool {
    return params.join == JOIN_FULL || (params.join == JOIN_K_STEP && has_flag(FLAG_POOL));
}

/// Where the vertex goes is `place_linked_vertex`'s to say (bindings/linked_append.wgsl).
fn keep_linked(slot: u32, vertex: LightVertex) {
    var linked = vertex;
    linked.link = light_paths[slot * 2u + 1u];
    light_paths[slot * 2u + 1u] = place_linked_vertex(slot, linked);
    light_paths[slot * 2u] += 1u;
}

fn keep_in_reservoir(slot: u32, path: Path, vertex: LightVertex) {
    let n = light_paths[slot * 2u];
    if (has_flag(FLAG_IMPORTANCE)) {
        keep_by_importance(slot, path, vertex);
    } else {
        keep_uniform(slot, path, vertex, n);
    }
    light_paths[slot * 2u] = n + 1u;
}

/// A connectible vertex with s >= 2 of a light path under way.
fn keep_light_vertex(path: Path, vertex: LightVertex) {
    let slot = light_path_slot(path);
    if (keeps_all()) {
        keep_linked(slot, vertex);
        return;
    }
    if (params.join == JOIN_K_STEP) {
        keep_in_reservoir(slot, path, vertex);
    }
    if (has_flag(FLAG_SPLAT)) {
        _ = append_light_vertex(vertex);
    }
}

/// A light path ended by roulette at a connectible vertex.
fn end_light_path(slot: u32, vertex: LightVertex) {
    if (params.join == JOIN_SINGLE_STEP) {
        light_paths[slot * 2u] = 1u;
        store_light_vertex(slot, vertex);
    }
}
