//! A random path in free space, and its MIS weights twice: by the kernels' recursive quantities,
//! and from their definition.

use glam::DVec3;
use midway_kernels::native::lib::{self, MisConfig, MisState};

use crate::support::Random;

/// What x_0 lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An emissive surface.
    Area,
    /// A light without extent: its position has a chance, and no camera path hits it.
    Point,
    /// A direction at infinity, with a chance: no camera path hits it.
    Directional,
    /// A direction at infinity out of many, with a density per solid angle.
    Environment,
}

impl Origin {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Area, Self::Point, Self::Directional, Self::Environment];

    fn is_infinite(self) -> bool {
        matches!(self, Self::Directional | Self::Environment)
    }

    fn is_hit(self) -> bool {
        matches!(self, Self::Area | Self::Environment)
    }
}

/// x_0 on a light, x_1 …, x_k on the lens. Densities are values at random: the recursion may assume
/// nothing about them.
#[derive(Clone, Debug)]
pub struct Chain {
    origin: Origin,
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    pub is_delta: Vec<bool>,
    /// Chance of going on from x_i.
    survival: Vec<f64>,
    /// At x_i towards x_{i+1}, per solid angle, with survival.
    pub forward: Vec<f64>,
    /// At x_i towards x_{i-1}, per solid angle, with survival; at x_k the camera's (`parallel`).
    pub reverse: Vec<f64>,
    /// Densities of x_0, per area or as its origin has it: as a light subpath's first vertex, and
    /// drawn for s = 1.
    position_area: f64,
    direct_area: f64,
    /// The camera's rays are parallel: its density is per area across them.
    pub parallel: bool,
}

impl Chain {
    /// A chain of `edges` >= 2. `config`: without next-event estimation s = 1 has no density of its
    /// own.
    pub fn new(edges: usize, origin: Origin, config: MisConfig, random: &mut Random) -> Self {
        let vertices = edges + 1;
        let is_delta: Vec<bool> = (0..vertices).map(|i| i != 0 && i != edges && random.chance(0.3)).collect();
        let survival: Vec<f64> = (0..vertices).map(|_| random.between(0.2, 0.95)).collect();
        let mut density = |i: usize| if is_delta[i] { survival[i] } else { random.between(0.05, 3.0) };
        let forward: Vec<f64> = (0..vertices).map(&mut density).collect();
        let reverse: Vec<f64> = (0..vertices).map(&mut density).collect();
        let position_area = random.between(0.1, 3.0);
        Self {
            origin,
            positions: (0..vertices).map(|_| random.direction() * random.between(0.5, 2.0)).collect(),
            normals: (0..vertices).map(|_| random.direction()).collect(),
            is_delta,
            survival,
            forward,
            reverse,
            position_area,
            direct_area: if config.nee != 0 { random.between(0.1, 3.0) } else { position_area },
            parallel: random.chance(0.5),
        }
    }

    pub fn edges(&self) -> usize {
        self.positions.len() - 1
    }

    /// Whether the chance of a vertex seen edge on makes cosines too small for f32 to be judged.
    pub fn is_degenerate(&self) -> bool {
        (1..=self.edges()).any(|i| {
            self.distance2(i - 1, i) < 0.04 || self.cosine(i, i - 1) < 0.05 || self.cosine(i - 1, i) < 0.05
        })
    }

    fn distance2(&self, i: usize, j: usize) -> f64 {
        self.positions[i].distance_squared(self.positions[j])
    }

    /// The geometric cosine at x_i towards x_j.
    fn cosine(&self, i: usize, j: usize) -> f64 {
        self.normals[i].dot((self.positions[j] - self.positions[i]).normalize()).abs()
    }

    /// From a density at x_i, per solid angle or of parallel rays per area across them, to one at x_j per
    /// area. At infinity directions stay per solid angle, and light starts per area at a right angle to
    /// them.
    fn to_area(&self, i: usize, j: usize) -> f64 {
        match (self.origin.is_infinite(), i, j) {
            (true, _, 0) => 1.0,
            (true, 0, _) => self.cosine(j, i),
            _ => self.cosine(j, i) / self.spread(i, j),
        }
    }

    /// What a subpath's density is divided by on the way from x_i to x_j.
    fn spread(&self, i: usize, j: usize) -> f64 {
        let from_light = i == 0 && self.origin.is_infinite();
        let from_camera = i == self.edges() && self.parallel;
        if from_light || from_camera { 1.0 } else { self.distance2(i, j) }
    }

    /// c of strategy (s, t) by design.md section 4; 0 where it is not in use, or can have made this
    /// path only with chance 0.
    fn factor(&self, config: MisConfig, s: usize) -> f64 {
        let t = self.edges() + 1 - s;
        if s == 0 {
            return if self.origin.is_hit() { 1.0 } else { 0.0 };
        }
        if self.is_delta[s - 1] || self.is_delta[s] {
            return 0.0;
        }
        let ends = (1.0 - self.survival[s - 1]) * (1.0 - self.survival[s]);
        let joined = if config.single_step != 0 { ends } else { 1.0 };
        match (s, t) {
            (_, 1) => f64::from(config.splat),
            (1, _) if config.nee != 0 => 1.0,
            (1, _) if config.single_step != 0 => ends,
            (1, _) => 0.0,
            _ => f64::from(config.join) * joined,
        }
    }

    /// The density, per area of x_0 … x_{k-1}, with which (s, k + 1 - s) makes this path. A delta
    /// vertex's Dirac factor is in every strategy that can make it, once, and left out.
    fn density(&self, s: usize) -> f64 {
        let k = self.edges();
        let start = match s {
            0 => 1.0,
            1 => self.direct_area,
            _ => self.position_area,
        };
        let light: f64 = (1..s).map(|i| self.forward[i - 1] * self.to_area(i - 1, i)).product();
        let camera: f64 = (s..k).map(|i| self.reverse[i + 1] * self.to_area(i + 1, i)).product();
        start * light * camera
    }

    /// (c p)^β / Σ (c p)^β for every s from 0 to k, from the definition.
    pub fn weights_by_definition(&self, config: MisConfig) -> Vec<f64> {
        let beta = if config.power != 0 { 2 } else { 1 };
        let terms: Vec<f64> =
            (0..=self.edges()).map(|s| (self.factor(config, s) * self.density(s)).powi(beta)).collect();
        let total: f64 = terms.iter().sum();
        terms.iter().map(|term| term / total).collect()
    }

    /// Whether any strategy in use can make it: one to a light that cannot be hit, past mirrors, may
    /// have none.
    pub fn is_possible(&self, config: MisConfig) -> bool {
        (0..=self.edges()).any(|s| self.factor(config, s) > 0.0)
    }

    fn ending(&self, config: MisConfig, i: usize) -> f32 {
        lib::ending_chance(config, self.survival[i] as f32)
    }

    /// As `arrive` in bindings/vertex.wgsl.
    fn arrive(&self, config: MisConfig, state: MisState, from: usize, at: usize) -> MisState {
        lib::mis_arrive(config, state, self.spread(from, at) as f32, self.cosine(at, from) as f32)
    }

    /// As `emit` in bindings/lights.wgsl.
    fn cos_light(&self) -> f64 {
        match self.origin {
            Origin::Area => self.cosine(0, 1),
            Origin::Point | Origin::Directional => 0.0,
            Origin::Environment => 1.0,
        }
    }

    /// The light subpath's states on arrival at x_1 … x_{k-1} (`shade_light`); x_0 has none.
    fn light_states(&self, config: MisConfig) -> Vec<Option<MisState>> {
        let ending = |i| self.ending(config, i);
        let mut states = vec![None];
        let mut state = lib::mis_begin_light(
            config,
            self.direct_area as f32,
            self.position_area as f32,
            self.forward[0] as f32,
            self.cos_light() as f32,
            ending(0),
        );
        for i in 1..self.edges() {
            state = self.arrive(config, state, i - 1, i);
            states.push(Some(state));
            let factor = lib::light_previous_factor(config, i as u32 + 1, state, ending(i));
            state = self.scatter(config, state, factor, i, i + 1, self.forward[i], self.reverse[i]);
        }
        states
    }

    /// The camera subpath's states on arrival at x_0 … x_{k-1} (`shade_camera`).
    fn camera_states(&self, config: MisConfig) -> Vec<MisState> {
        let k = self.edges();
        let mut states = Vec::new();
        let mut state = lib::mis_begin_camera(config, self.reverse[k] as f32);
        for i in (0..k).rev() {
            // A ray that escapes arrives nowhere.
            if i > 0 || !self.origin.is_infinite() {
                state = self.arrive(config, state, i + 1, i);
            }
            states.push(state);
            if i > 0 {
                let t = (k + 1 - i) as u32;
                let factor = lib::camera_previous_factor(config, t, state, self.ending(config, i));
                state = self.scatter(config, state, factor, i, i - 1, self.reverse[i], self.forward[i]);
            }
        }
        states.reverse();
        states
    }

    /// As `scatter` in bindings/vertex.wgsl.
    #[allow(clippy::too_many_arguments)]
    fn scatter(
        &self,
        config: MisConfig,
        state: MisState,
        factor: f32,
        at: usize,
        to: usize,
        pdf_fwd: f64,
        pdf_rev: f64,
    ) -> MisState {
        let (cos_out, ending) = (self.cosine(at, to) as f32, self.ending(config, at));
        if self.is_delta[at] {
            return lib::mis_scatter_delta(config, state, cos_out, ending);
        }
        lib::mis_scatter(config, state, factor, cos_out, pdf_fwd as f32, pdf_rev as f32, ending)
    }

    /// The weights that the kernels compute, for every s from 0 to k; 0 where they make none.
    /// `walk`: the path as its subpaths saw it, the same but where a mistake is tried.
    pub fn weights_by_recursion(&self, config: MisConfig, walk: &Self, walk_config: MisConfig) -> Vec<f64> {
        let (light, camera) = (walk.light_states(walk_config), walk.camera_states(walk_config));
        let weight = |s: usize| {
            if self.factor(config, s) == 0.0 {
                return 0.0;
            }
            let t = self.edges() + 1 - s;
            f64::from(match (s, t) {
                (0, _) => self.weigh_hit(config, camera[0]),
                (_, 1) => self.weigh_splat(config, light[s - 1].expect("s >= 2")),
                (1, _) => self.weigh_emitter(config, camera[1]),
                _ => self.weigh_join(config, s, light[s - 1].expect("s >= 2"), camera[s]),
            })
        };
        (0..=self.edges()).map(weight).collect()
    }

    /// As `add_emission` and `add_environment` in shade_camera.wgsl.
    fn weigh_hit(&self, config: MisConfig, state: MisState) -> f32 {
        let factor = lib::emitter_factor(config, self.ending(config, 0), state.ending);
        let emission = self.position_area * self.forward[0];
        lib::mis_weight_hit(config, state, factor, self.direct_area as f32, emission as f32)
    }

    /// As `light_join_weight` in bindings/light_join.wgsl, with `see_light` of bindings/lights.wgsl.
    fn weigh_emitter(&self, config: MisConfig, state: MisState) -> f32 {
        let to_measure = if self.origin.is_hit() { self.to_area(1, 0) } else { 0.0 };
        let pdf_hit = (self.reverse[1] * to_measure) as f32;
        let pdf_emit = (self.forward[0] * self.to_area(0, 1)) as f32;
        let factor = lib::emitter_factor(config, self.ending(config, 0), self.ending(config, 1));
        let (direct, position) = (self.direct_area as f32, self.position_area as f32);
        let earlier = self.camera_earlier(config, 1, state);
        lib::mis_weight_emitter(config, factor, pdf_hit, direct, position, pdf_emit, earlier)
    }

    /// As `join_mis_weight` in bindings/join_choice.wgsl: y is x_{s-1}, z is x_s.
    fn weigh_join(&self, config: MisConfig, s: usize, light: MisState, camera: MisState) -> f32 {
        let pdf_y = (self.reverse[s] * self.to_area(s, s - 1)) as f32;
        let pdf_z = (self.forward[s - 1] * self.to_area(s - 1, s)) as f32;
        let factor = lib::join_factor(config, self.ending(config, s - 1), self.ending(config, s));
        let (light, camera) =
            (self.light_earlier(config, s - 1, light), self.camera_earlier(config, s, camera));
        lib::mis_weight_join(config, factor, pdf_y, light, pdf_z, camera)
    }

    /// As connect_camera.wgsl.
    fn weigh_splat(&self, config: MisConfig, state: MisState) -> f32 {
        let k = self.edges();
        let pdf_y = (self.reverse[k] * self.to_area(k, k - 1)) as f32;
        lib::mis_weight_splat(config, pdf_y, self.light_earlier(config, k - 1, state))
    }

    /// As `light_earlier` in bindings/stored_vertex.wgsl.
    fn light_earlier(&self, config: MisConfig, i: usize, state: MisState) -> f32 {
        let factor = lib::light_previous_factor(config, i as u32 + 1, state, self.ending(config, i));
        lib::mis_earlier(config, state, factor, self.reverse[i] as f32)
    }

    fn camera_earlier(&self, config: MisConfig, i: usize, state: MisState) -> f32 {
        let t = (self.edges() + 1 - i) as u32;
        let factor = lib::camera_previous_factor(config, t, state, self.ending(config, i));
        lib::mis_earlier(config, state, factor, self.forward[i] as f32)
    }
}
