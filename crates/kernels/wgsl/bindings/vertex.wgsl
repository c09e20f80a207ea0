// A subpath's vertex under its hands: what shading, joining and scattering need of it.

struct Vertex {
    surface: Surface,
    material: Material,
    /// Towards the vertex before.
    wo: vec3<f32>,
    /// Throughput on arrival, in one channel where the material disperses.
    throughput: vec3<f32>,
    mis: MisState,
    /// Survival as MIS counts it; that of roulette but on a camera path, see `camera_survival`.
    survival: f32,
    /// Its chance of being an end, as it enters MIS factors.
    ending: f32,
}

/// The vertex at which a path's ray arrived; hit.triangle is not NONE. stream: 0, or DRAW_LIGHT.
fn arrive(path: Path, hit: Hit, stream: u32) -> Vertex {
    let config = mis_config();
    let point = load_raw_point(load_surface(hit.triangle, hit.u, hit.v));
    let surface = point.surface;
    let medium = medium_before(path.medium, surface, point.raw.flags, -path.direction);
    var throughput = path.throughput * medium_transmittance(medium, hit.t);
    if (disperses(point.raw.flags)) {
        let u = random(path.index, path.sample, dimension(stream + DRAW_CHANNEL, path.depth));
        throughput = keep_one_channel(throughput, u.x);
    }
    let material = shade_point(point, throughput).material;
    let cos_in = max(abs(dot(surface.ng, path.direction)), 1e-12);
    let state = mis_arrive(config, path.mis, select(hit.t * hit.t, 1.0, path.parallel), cos_in);
    let q = survival(material);
    return Vertex(surface, material, -path.direction, throughput, state, q, ending_chance(config, q));
}

/// What a vertex scatters from one direction into another, densities with survival.
fn scatter_terms(vertex: Vertex, wi: vec3<f32>, mode: u32) -> BsdfTerms {
    let terms = bsdf_terms(vertex.material, frame_of(vertex.surface), vertex.wo, wi, mode);
    return BsdfTerms(terms.f, vertex.survival * terms.pdf_fwd, vertex.survival * terms.pdf_rev);
}

/// The side of a vertex that lights are drawn for: that which it was reached from, and NO_FACING where it
/// transmits.
fn facing_of(vertex: Vertex) -> u32 {
    if (!keeps_facing() || (may_have(FEATURE_TRANSMISSION) && transmits_density(vertex.surface.material))) {
        return NO_FACING;
    }
    return oct_encode(normal_towards(vertex.surface, vertex.wo));
}

fn facing_normal(facing: u32) -> vec3<f32> {
    if (facing == NO_FACING) {
        return vec3<f32>(0.0);
    }
    return oct_decode(facing);
}

/// What a vertex's lights are drawn for: the place where a path begins that leaves on the side that it came
/// from, so that one which goes on from there and hits a light finds the same chances.
fn light_place(vertex: Vertex) -> LightPlace {
    return LightPlace(offset_origin(vertex.surface.position, normal_towards(vertex.surface, vertex.wo)),
        facing_normal(facing_of(vertex)));
}

/// The same of the vertex that a path left.
fn light_place_left(path: Path) -> LightPlace {
    return LightPlace(path.origin, facing_normal(path.facing));
}

/// Numbers for scattering (x, y, z) and roulette (w).
fn scatter_numbers(path: Path, stream: u32) -> vec4<f32> {
    return random(path.index, path.sample, dimension(stream + DRAW_SCATTER, path.depth));
}

/// Sends a path on from a vertex that roulette spared with a chance of `survival`; its throughput is 0 where
/// nothing was sampled. `factor`: c of the strategy that ends at the vertex before (lib/mis.wgsl).
fn scatter(path: Path, vertex: Vertex, survival: f32, factor: f32, u: vec3<f32>, mode: u32) -> Path {
    let surface = vertex.surface;
    let scattered = bsdf_sample(vertex.material, frame_of(surface), vertex.wo, u, mode);
    var next = path;
    next.throughput = vec3<f32>(0.0);
    if (scattered.pdf <= 0.0) {
        return next;
    }
    let config = mis_config();
    let cos_out = abs(dot(surface.ng, scattered.wi));
    let weight = scattered.weight / survival; // > 0: roulette spared the path
    if (scattered.is_delta) {
        next.mis = mis_scatter_delta(config, vertex.mis, cos_out, vertex.ending);
    } else {
        let pdf_fwd = scattered.pdf * vertex.survival;
        let pdf_rev = scattered.pdf_rev * vertex.survival;
        next.mis = mis_scatter(config, vertex.mis, factor, cos_out, pdf_fwd, pdf_rev, vertex.ending);
    }
    next.throughput = vertex.throughput * weight;
    next.origin = offset_origin(surface.position, normal_towards(surface, scattered.wi));
    next.direction = scattered.wi;
    next.depth = path.depth + 1u;
    next.parallel = false;
    next.facing = facing_of(vertex);
    next.medium = medium_towards(path.medium, surface, vertex.material, vertex.wo, scattered.wi);
    return next;
}
