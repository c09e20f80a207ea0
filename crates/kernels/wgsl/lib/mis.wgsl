// Multiple importance sampling over all strategies in use, by recursive quantities: no subpath is
// walked again (Georgiev, "Implementing Vertex Connection and Merging", 2012, sections 3 and 4,
// without merging). Vertices: y_0, y_1 … on the light side, z_0 (lens), z_1 … on the camera side;
// strategy (s, t) joins y_{s-1} and z_{t-1}.
//
// Each strategy's density P_{s,t} is multiplied by a factor c_{s,t} that depends only on the path
// and on constants of the pass:
//   s = 0                 1
//   s = 1                 1 with next-event estimation; without it, in single-step, as a join
//   s >= 2, t >= 2        join, times the chances of ending at both vertices in single-step
//   t = 1                 splat: light paths per sample of every pixel
// A factor of 0 says that the strategy is not in use.
//
// In the state of a subpath that has arrived at vertex x:
//   dvcm     1 / p_fwd(x) in area measure: the strategy whose end is the vertex before x,
//            still without its factor c; 0 where that vertex is delta.
//   dvc      the sum over all strategies that end still earlier, with their factors,
//            to be multiplied by the reverse density at x (per solid angle).
//   ending   the chance of having ended at the vertex before x (1 where not single-step).
// With the power heuristic each quantity is squared (Georgiev, section 4.2: Mis(x) = x^β).

struct MisConfig {
    /// 1: power heuristic with exponent 2; 0: balance.
    power: u32,
    /// 1 where s = 1 is drawn afresh at every vertex.
    nee: u32,
    /// 1 where only ends are joined.
    single_step: u32,
    /// Factor of strategies with s >= 2 and t >= 2; 0 where none is used.
    join: f32,
    /// Factor of strategies with t = 1; 0 where none is used.
    splat: f32,
}

struct MisState {
    dvcm: f32,
    dvc: f32,
    ending: f32,
}

/// Mis(x) of the heuristic in use.
fn mis_power(config: MisConfig, x: f32) -> f32 {
    return select(x, x * x, config.power != 0u);
}

/// The chance of a subpath's ending at a vertex that survives with chance q, as it enters factors.
fn ending_chance(config: MisConfig, q: f32) -> f32 {
    return select(1.0, 1.0 - q, config.single_step != 0u);
}

/// c of the strategy (s, t), s >= 2 and t >= 2, that joins vertices with these chances of ending.
fn join_factor(config: MisConfig, ending_a: f32, ending_b: f32) -> f32 {
    return config.join * ending_a * ending_b;
}

/// c of the strategy (1, t): joined to y_0.
fn emitter_factor(config: MisConfig, ending_y: f32, ending_z: f32) -> f32 {
    if (config.nee != 0u) {
        return 1.0;
    }
    return select(0.0, ending_y * ending_z, config.single_step != 0u);
}

/// c of the strategy that joins the vertex before a light subpath's vertex y_{s-1} to that vertex.
fn light_previous_factor(config: MisConfig, s: u32, state: MisState, ending: f32) -> f32 {
    if (s == 2u) {
        return emitter_factor(config, state.ending, ending);
    }
    return join_factor(config, state.ending, ending);
}

/// c of the strategy that joins the vertex before a camera subpath's vertex z_{t-1} to that vertex,
/// for a light subpath of at least 2 vertices.
fn camera_previous_factor(config: MisConfig, t: u32, state: MisState, ending: f32) -> f32 {
    if (t == 2u) {
        return config.splat;
    }
    return join_factor(config, state.ending, ending);
}

/// A camera subpath that leaves the lens with this density per solid angle, or per area across
/// parallel rays (arrival is then over a distance of 1).
fn mis_begin_camera(config: MisConfig, pdf: f32) -> MisState {
    return MisState(mis_power(config, 1.0 / pdf), 0.0, 1.0);
}

/// A light subpath that leaves y_0: the density of choosing y_0 for next-event estimation and for
/// emission (per area), and of the emitted direction (per solid angle, with survival at y_0).
/// For a point light the first is a chance; cos_light is 0 where no camera subpath can hit the light.
/// At infinity y_0 is a direction (its density per solid angle, or a chance) and the second density
/// is that of a point on a disk that covers the scene; cos_light is 1, and on arrival the distance
/// counts as 1 (Georgiev 2012, section 5.1).
fn mis_begin_light(config: MisConfig, pdf_direct_area: f32, pdf_position_area: f32, pdf_direction_sa: f32, cos_light: f32, ending: f32) -> MisState {
    let pdf_emission = pdf_position_area * pdf_direction_sa;
    return MisState(mis_power(config, pdf_direct_area / pdf_emission), mis_power(config, cos_light / pdf_emission), ending);
}

/// Arrival over a distance at a surface seen under the geometric cosine cos_in > 0.
fn mis_arrive(config: MisConfig, state: MisState, distance_squared: f32, cos_in: f32) -> MisState {
    return MisState(
        state.dvcm * mis_power(config, distance_squared / cos_in),
        state.dvc / mis_power(config, cos_in),
        state.ending,
    );
}

/// What earlier ends weigh at x, for a join that makes x's reverse density (towards the vertex
/// before it, per solid angle, with survival) pdf_rev. factor: c of the strategy before x.
fn mis_earlier(config: MisConfig, state: MisState, factor: f32, pdf_rev: f32) -> f32 {
    return state.dvcm * mis_power(config, factor) + state.dvc * mis_power(config, pdf_rev);
}

/// Departure from x by a non-delta lobe: densities per solid angle with survival, cos_out the
/// geometric cosine of the new direction.
fn mis_scatter(config: MisConfig, state: MisState, factor: f32, cos_out: f32, pdf_fwd: f32, pdf_rev: f32, ending: f32) -> MisState {
    return MisState(
        mis_power(config, 1.0 / pdf_fwd),
        mis_power(config, cos_out / pdf_fwd) * mis_earlier(config, state, factor, pdf_rev),
        ending,
    );
}

/// Departure by a delta lobe: its density and its reverse cancel, and no strategy ends here.
fn mis_scatter_delta(config: MisConfig, state: MisState, cos_out: f32, ending: f32) -> MisState {
    return MisState(0.0, mis_power(config, cos_out) * state.dvc, ending);
}

/// A state's sum is bounded in floats only for scenes of sane scale: an infinite sum means weight 0.
fn mis_weight(config: MisConfig, factor: f32, others: f32) -> f32 {
    let own = mis_power(config, factor);
    return own / (own + others); // own > 0: the strategy is in use
}

/// (0, t), t >= 3: the camera subpath hit a light. pdf_direct_area: density of choosing that point
/// for s = 1; pdf_emission: of emitting from it towards the vertex before.
fn mis_weight_hit(config: MisConfig, state: MisState, factor_s1: f32, pdf_direct_area: f32, pdf_emission: f32) -> f32 {
    let others = state.dvcm * mis_power(config, factor_s1 * pdf_direct_area) + state.dvc * mis_power(config, pdf_emission);
    return mis_weight(config, 1.0, others);
}

/// (1, t): z joined to a point on a light. Area densities: pdf_hit_area of z's lobe to have hit the
/// light there, pdf_direct_area of the choice, pdf_emit_z_area of emission from there to have
/// reached z (position density left out: it cancels with pdf_position_area).
fn mis_weight_emitter(config: MisConfig, factor: f32, pdf_hit_area: f32, pdf_direct_area: f32, pdf_position_area: f32, pdf_emit_z_area: f32, camera_earlier: f32) -> f32 {
    let w_light = mis_power(config, pdf_hit_area / pdf_direct_area);
    let w_camera = mis_power(config, pdf_position_area * pdf_emit_z_area / pdf_direct_area) * camera_earlier;
    return mis_weight(config, factor, w_light + w_camera);
}

/// (s, t), s >= 2 and t >= 2. pdf_y_area: z's lobe towards y; pdf_z_area: y's lobe towards z.
fn mis_weight_join(config: MisConfig, factor: f32, pdf_y_area: f32, light_earlier: f32, pdf_z_area: f32, camera_earlier: f32) -> f32 {
    let others = mis_power(config, pdf_y_area) * light_earlier + mis_power(config, pdf_z_area) * camera_earlier;
    return mis_weight(config, factor, others);
}

/// (s, 1), s >= 2: y projected onto the film; pdf_y_area of the camera to have hit it.
fn mis_weight_splat(config: MisConfig, pdf_y_area: f32, light_earlier: f32) -> f32 {
    return mis_weight(config, config.splat, mis_power(config, pdf_y_area) * light_earlier);
}
