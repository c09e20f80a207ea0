// A light subpath arrives at a vertex: it is kept for joins, and the path goes on.

/// The path from the vertex on; its throughput is 0 where it ends.
fn step_light(path: Path, hit: Hit) -> Path {
    if (hit.triangle == NONE || !contributes(path.throughput)) {
        return ended(path);
    }
    var vertex = arrive(path, hit, DRAW_LIGHT);
    let s = path.depth + 2u; // with y_0 and this vertex
    if (!length_allowed(s, 1u)) {
        return ended(path);
    }
    if (s == 2u && uses_light_tree()) {
        // (2) has the chance by power at y_0, which the path began by; s = 1 here draws by the tree.
        let light = light_of_path(path);
        let ratio = light_chance_ratio(light, load_light(light), light_place(vertex));
        vertex.mis.dvcm *= mis_power(mis_config(), ratio);
    }
    let connectible = is_connectible(vertex.material);
    let stored = LightVertex(vertex.surface.position, hit.triangle, vertex.throughput, vertex.mis.dvcm,
        vertex.wo, vertex.mis.dvc, hit.u, hit.v, bitcast<u32>(vertex.mis.ending), s, light_path_group(path));
    if (connectible) {
        keep_light_vertex(path, stored);
    }
    let u = scatter_numbers(path, DRAW_LIGHT);
    if (u.w >= vertex.survival) {
        if (connectible) {
            end_light_path(light_path_slot(path), stored);
        }
        return ended(path);
    }
    let factor = light_previous_factor(mis_config(), s, vertex.mis, vertex.ending);
    return scatter(path, vertex, vertex.survival, factor, u.xyz, TRANSPORT_IMPORTANCE);
}
