// A stored light vertex with its surface: what a join needs of it. y_0 is here only where it is on
// a triangle, to be projected onto the film; it is joined by bindings/light_join.wgsl.

struct JoinVertex {
    surface: Surface,
    material: Material,
    survival: f32,
    ending: f32,
}

fn load_join_vertex(stored: LightVertex) -> JoinVertex {
    let shaded = load_shaded(stored.triangle, stored.u, stored.v);
    let surface = shaded.surface;
    let material = shaded.material;
    let q = survival(material);
    return JoinVertex(surface, material, q, ending_chance(mis_config(), q));
}

/// What a light subpath's end sends towards wi: importance-mode scattering, no cosine; at y_0, the
/// emission (throughput holds radiance over density).
fn light_end_scatter(stored: LightVertex, vertex: JoinVertex, wi: vec3<f32>) -> vec3<f32> {
    if (stored.s == 1u) {
        let emits = any(emitted_radiance(vertex.material, dot(vertex.surface.ng, wi)) > vec3<f32>(0.0));
        return select(vec3<f32>(0.0), stored.throughput, emits);
    }
    return stored.throughput * bsdf_eval(vertex.material, frame_of(vertex.surface), stored.wo, wi, TRANSPORT_IMPORTANCE);
}

/// Density of scattering at a light subpath's end from one direction into another, per solid angle,
/// with survival, by the mode of the path that comes from the first.
fn light_end_pdf(vertex: JoinVertex, from_direction: vec3<f32>, to_direction: vec3<f32>, mode: u32) -> f32 {
    return vertex.survival * bsdf_pdf(vertex.material, frame_of(vertex.surface), from_direction, to_direction, mode);
}

/// The chance of a light subpath's having ended at its end.
fn light_ending(stored: LightVertex) -> f32 {
    if (stored.s == 1u) {
        return ending_chance(mis_config(), params.emitter_survival);
    }
    return load_join_vertex(stored).ending;
}

/// What the strategies with fewer light vertices weigh at a stored vertex with s >= 2.
fn light_earlier(stored: LightVertex, vertex: JoinVertex, wi: vec3<f32>) -> f32 {
    let config = mis_config();
    let state = light_vertex_mis(stored);
    let factor = light_previous_factor(config, stored.s, state, vertex.ending);
    return mis_earlier(config, state, factor, light_end_pdf(vertex, wi, stored.wo, TRANSPORT_RADIANCE));
}
