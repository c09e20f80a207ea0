// Strategy (s, t), s and t >= 2: a camera vertex joined to a stored light vertex.

struct Join {
    /// Unweighted, visibility left out.
    contribution: vec3<f32>,
    mis_weight: f32,
    /// The light vertex's chance of being an end, as it enters MIS factors.
    ending: f32,
    /// Of the light path's light.
    group: u32,
    /// Of the shadow ray, off both surfaces.
    start: vec3<f32>,
    end: vec3<f32>,
}

fn no_join() -> Join {
    return Join(vec3<f32>(0.0), 0.0, 1.0, 0u, vec3<f32>(0.0), vec3<f32>(0.0));
}

/// Joins a camera vertex to a light vertex. What has no chance is found out before the light vertex's
/// material is loaded.
fn evaluate_join(path: Path, vertex: Vertex, stored: LightVertex) -> Join {
    let between = stored.position - vertex.surface.position;
    let distance_squared = dot(between, between);
    let wi = between / sqrt(max(distance_squared, 1e-38));
    if (distance_squared == 0.0 || !may_scatter(vertex.surface, vertex.wo, wi)) {
        return no_join();
    }
    if (may_have(FEATURE_DISPERSION) && !contributes(vertex.throughput * stored.throughput)) {
        return no_join(); // of different channels
    }
    let y_surface = load_stored_surface(stored);
    if (!may_scatter(y_surface, stored.wo, -wi)) {
        return no_join();
    }
    let ends = evaluate_ends(vertex, stored, y_surface, wi);
    let leaving = medium_towards(path.medium, vertex.surface, vertex.material, vertex.wo, wi);
    let medium = medium_before(leaving, y_surface, ends.y_material.flags, -wi);
    let cosines = abs(vec2<f32>(dot(vertex.surface.ng, wi), dot(y_surface.ng, wi)));
    let contribution = vertex.throughput * ends.z.f * stored.throughput * ends.y.f
        * medium_transmittance(medium, sqrt(distance_squared)) * (cosines.x * cosines.y / distance_squared);
    if (!contributes(contribution)) {
        return no_join();
    }
    return Join(contribution, join_mis_weight(path, vertex, stored, ends, cosines / distance_squared),
        ending_chance(mis_config(), survival(ends.y_material)), stored.group,
        offset_origin(vertex.surface.position, normal_towards(vertex.surface, wi)),
        offset_origin(stored.position, normal_towards(y_surface, -wi)));
}

/// What both ends of a join scatter, zero where either does not.
struct Ends {
    z: BsdfTerms,
    y: BsdfTerms,
    y_material: Material,
}

/// By one loop, of a length that no compiler knows (s >= 2), so that a kernel holds that code once.
fn evaluate_ends(vertex: Vertex, stored: LightVertex, y_surface: Surface, wi: vec3<f32>) -> Ends {
    var end = Shaded(vertex.surface, vertex.material);
    var z = no_terms();
    var y = no_terms();
    for (var i = 0u; i < min(stored.s, 2u); i += 1u) {
        let at_light = i != 0u;
        let terms = bsdf_terms(end.material, frame_of(end.surface), select(vertex.wo, stored.wo, at_light),
            select(wi, -wi, at_light), select(TRANSPORT_RADIANCE, TRANSPORT_IMPORTANCE, at_light));
        if (at_light) {
            y = terms;
        } else if (contributes(terms.f)) {
            z = terms;
            end = shade_surface(y_surface, stored.throughput);
        } else {
            break;
        }
    }
    return Ends(z, y, end.material);
}

/// `to_area`: the cosines at the camera's and at the light's vertex over the distance squared, which turn
/// densities per solid angle at the other end into ones per area.
fn join_mis_weight(path: Path, vertex: Vertex, stored: LightVertex, ends: Ends, to_area: vec2<f32>) -> f32 {
    let config = mis_config();
    let q = survival(ends.y_material);
    let ending = ending_chance(config, q);
    let previous = camera_previous_factor(config, path.depth + 2u, vertex.mis, vertex.ending);
    let camera_earlier = mis_earlier(config, vertex.mis, previous, vertex.survival * ends.z.pdf_rev);
    return mis_weight_join(config, join_factor(config, ending, vertex.ending),
        vertex.survival * ends.z.pdf_fwd * to_area.y, light_earlier(stored, ending, q * ends.y.pdf_rev),
        q * ends.y.pdf_fwd * to_area.x, camera_earlier);
}

/// One shadow ray, where there is anything to be seen.
fn push_join(path: Path, s: u32, joined: Join, estimator: f32) {
    let weight = strategy_weight(s, path.depth + 2u, joined.mis_weight);
    let contribution = joined.contribution * (weight * estimator);
    if (contributes(contribution)) {
        push_shadow_ray(path.index, joined.group, joined.start, joined.end, contribution);
    }
}
