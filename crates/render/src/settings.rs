//! What is asked of a render.

use std::fmt::Write as _;

use midway_kernels::constants as k;

use crate::{Aov, RenderError};

/// The window of the film that is rendered, in pixels from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Left edge.
    pub x: u32,
    /// Top edge.
    pub y: u32,
    /// Pixels along x, > 0.
    pub width: u32,
    /// Pixels along y, > 0.
    pub height: u32,
}

/// How light is found. All converge to the same image wherever their strategies reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Camera path; light only where it is hit.
    PathNaive,
    /// Camera path with a light sampled at each vertex.
    #[default]
    Path,
    /// Light path, each vertex projected onto the film. Sees no specular surface.
    Light,
    /// Subpaths from both ends, joined.
    Bdpt,
}

/// Which vertices of the two subpaths are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Join {
    /// Every connectible light vertex with every camera vertex.
    #[default]
    Full,
    /// Each camera vertex with K light vertices.
    KStep,
    /// The last camera vertex with the last light vertex.
    SingleStep,
}

/// How K light vertices are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JoinChoice {
    /// All alike.
    #[default]
    Uniform,
    /// In proportion to the vertex's throughput; from a pool, to the unshadowed contribution.
    Importance,
}

/// Where the light vertices of joins come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightPaths {
    /// One light path for each camera path.
    #[default]
    PerSample,
    /// Paths traced at the start of each pass, by default as many as pixels.
    Pool(Option<u32>),
}

/// The heuristic of multiple importance sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mis {
    /// Weights in proportion to densities.
    Balance,
    /// To their squares.
    #[default]
    Power,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rng {
    /// Owen-scrambled Sobol points: the samples of a pixel are spread evenly over each draw.
    #[default]
    Sobol,
    /// A hash: samples are independent.
    Hash,
    /// Bias: this many pre-generated numbers, > 0, used again and again.
    Table(u32),
}

impl Rng {
    /// As it is typed and written into an image's header.
    pub fn describe(self) -> String {
        match self {
            Self::Sobol => "sobol".to_owned(),
            Self::Hash => "hash".to_owned(),
            Self::Table(n) => format!("table:{n}"),
        }
    }

    /// Entries of its table, where it has one.
    pub fn table(self) -> Option<u32> {
        match self {
            Self::Table(n) => Some(n),
            Self::Sobol | Self::Hash => None,
        }
    }
}

/// How next-event estimation chooses a light; light paths choose by power always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSampling {
    /// By the tree where lights are many and lie apart, so that it pays.
    #[default]
    Auto,
    /// In proportion to power, wherever it is to shine.
    Power,
    /// In proportion to about what arrives at the place that it is drawn for, by a tree over all lights.
    Tree,
}

/// An integrator with its options; those of `bdpt` are ignored by the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Which.
    pub integrator: Integrator,
    /// The join of `bdpt`.
    pub join: Join,
    /// K of [`Join::KStep`], > 0.
    pub k: u32,
    /// How K vertices are chosen.
    pub join_choice: JoinChoice,
    /// Where light vertices come from.
    pub light_paths: LightPaths,
    /// s = 1 at every vertex; none: all joins but single-step.
    pub nee: Option<bool>,
    /// t = 1 at every light vertex; none: all joins but single-step.
    pub splat: Option<bool>,
    /// The heuristic.
    pub mis: Mis,
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            integrator: Integrator::default(),
            join: Join::default(),
            k: 3,
            join_choice: JoinChoice::default(),
            light_paths: LightPaths::default(),
            nee: None,
            splat: None,
            mis: Mis::default(),
        }
    }
}

impl IntegratorSettings {
    /// Whether a light is sampled at every camera vertex.
    pub fn uses_nee(&self) -> bool {
        match self.integrator {
            Integrator::Path => true,
            Integrator::PathNaive | Integrator::Light => false,
            Integrator::Bdpt => self.nee.unwrap_or(self.join != Join::SingleStep),
        }
    }

    /// Whether light vertices are projected onto the film.
    pub fn uses_splat(&self) -> bool {
        match self.integrator {
            Integrator::Light => true,
            Integrator::PathNaive | Integrator::Path => false,
            Integrator::Bdpt => self.splat.unwrap_or(self.join != Join::SingleStep),
        }
    }

    /// Whether camera paths are traced.
    pub fn uses_camera_paths(&self) -> bool {
        self.integrator != Integrator::Light
    }

    /// Whether light paths are traced.
    pub fn uses_light_paths(&self) -> bool {
        matches!(self.integrator, Integrator::Light | Integrator::Bdpt)
    }

    /// Whether subpaths are joined, and how.
    pub fn joins(&self) -> Option<Join> {
        (self.integrator == Integrator::Bdpt).then_some(self.join)
    }

    /// Whether joins draw from a pool.
    pub fn uses_pool(&self) -> bool {
        self.joins().is_some() && matches!(self.light_paths, LightPaths::Pool(_))
    }

    /// The integrator with its options, as it is written into an image's header.
    pub fn describe(&self) -> String {
        let name = match self.integrator {
            Integrator::PathNaive => "path-naive",
            Integrator::Path => "path",
            Integrator::Light => "light",
            Integrator::Bdpt => "bdpt",
        };
        let mut text = name.to_owned();
        let mis = if self.mis == Mis::Power { "power" } else { "balance" };
        if let Some(join) = self.joins() {
            match join {
                Join::Full => text.push_str(" join=full"),
                Join::KStep => {
                    let choice =
                        if self.join_choice == JoinChoice::Uniform { "uniform" } else { "importance" };
                    let _ = write!(text, " join=k-step k={} join-choice={choice}", self.k);
                }
                Join::SingleStep => {
                    let _ =
                        write!(text, " join=single-step nee={} splat={}", self.uses_nee(), self.uses_splat());
                }
            }
            match self.light_paths {
                LightPaths::PerSample => text.push_str(" light-paths=per-sample"),
                LightPaths::Pool(None) => text.push_str(" light-paths=pool"),
                LightPaths::Pool(Some(n)) => {
                    let _ = write!(text, " light-paths=pool:{n}");
                }
            }
        }
        if matches!(self.integrator, Integrator::Path | Integrator::Bdpt) {
            let _ = write!(text, " mis={mis}");
        }
        text
    }
}

/// The shape of a pixel filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilterKind {
    /// Constant.
    #[default]
    Box,
    /// The window of Blackman and Harris, of four terms.
    BlackmanHarris,
}

/// What a pixel is the mean over: separable, by camera paths and splats alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFilter {
    /// Its shape.
    pub kind: FilterKind,
    /// Its full width in pixels, in (0, 16].
    pub width: f32,
}

impl Default for PixelFilter {
    /// A box one pixel wide.
    fn default() -> Self {
        Self::new(FilterKind::Box)
    }
}

impl PixelFilter {
    /// Of the usual width: 1 for the box, 3 for Blackman-Harris (Cycles' default, which it gives as
    /// the half, 1.5).
    pub fn new(kind: FilterKind) -> Self {
        let width = match kind {
            FilterKind::Box => 1.0,
            FilterKind::BlackmanHarris => 3.0,
        };
        Self { kind, width }
    }

    /// As it is written into an image's header.
    pub fn describe(&self) -> String {
        let name = match self.kind {
            FilterKind::Box => "box",
            FilterKind::BlackmanHarris => "blackman-harris",
        };
        format!("{name} width={}", self.width)
    }
}

/// One strategy looked at alone: for developers and for proofs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OneStrategy {
    /// Light vertices.
    pub s: u32,
    /// Camera vertices.
    pub t: u32,
    /// With weight 1 instead of its MIS weight.
    pub raw: bool,
}

/// What is asked of a render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels along x of the whole film.
    pub width: u32,
    /// Pixels along y of the whole film.
    pub height: u32,
    /// The part of it that is rendered; none: all.
    pub crop: Option<Crop>,
    /// The same seed on the same device gives the same bits.
    pub seed: u32,
    /// The pixel filter.
    pub filter: PixelFilter,
    /// Layers besides the beauty, in the order of the file.
    pub aovs: Vec<Aov>,
    /// What each group of the scene's lights ([`midway_scene::LightGroups`]) adds to the image is kept
    /// apart: a film for each.
    pub light_groups: bool,
    /// The integrator.
    pub integrator: IntegratorSettings,
    /// How s = 1 chooses a light.
    pub light_sampling: LightSampling,
    /// Bias: edges of a path at most.
    pub max_path_length: Option<u32>,
    /// Where random numbers come from.
    pub rng: Rng,
    /// Bias: the largest component of one contribution.
    pub clamp: Option<f32>,
    /// Only this strategy.
    pub one_strategy: Option<OneStrategy>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            crop: None,
            seed: 0,
            filter: PixelFilter::default(),
            aovs: Vec::new(),
            light_groups: false,
            integrator: IntegratorSettings::default(),
            light_sampling: LightSampling::default(),
            max_path_length: None,
            rng: Rng::default(),
            clamp: None,
            one_strategy: None,
        }
    }
}

/// The largest film, in pixels along one side.
const MAX_SIDE: u32 = 65_536;

impl RenderSettings {
    /// The rendered window.
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop { x: 0, y: 0, width: self.width, height: self.height })
    }

    /// Every opt-in bias in use, as it is printed and written into the header.
    pub fn bias(&self) -> Vec<String> {
        let mut bias = Vec::new();
        if let Some(n) = self.max_path_length {
            bias.push(format!("max-path-length={n}"));
        }
        if let Some(n) = self.rng.table() {
            bias.push(format!("rng=table:{n}"));
        }
        if let Some(x) = self.clamp {
            bias.push(format!("clamp={x}"));
        }
        bias
    }

    /// Checks that the settings make sense together.
    ///
    /// # Errors
    /// [`RenderError::Settings`] says which does not.
    pub fn validate(&self) -> Result<(), RenderError> {
        let fail = |text: String| Err(RenderError::Settings(text));
        if self.width == 0 || self.height == 0 || self.width > MAX_SIDE || self.height > MAX_SIDE {
            return fail(format!(
                "a film of {} x {} pixels: each side is 1 to {MAX_SIDE}",
                self.width, self.height
            ));
        }
        let window = self.window();
        let fits = |start: u32, size: u32, whole: u32| {
            size > 0 && start.checked_add(size).is_some_and(|end| end <= whole)
        };
        if !fits(window.x, window.width, self.width) || !fits(window.y, window.height, self.height) {
            return fail(format!(
                "the crop {},{},{},{} is not inside the film of {} x {}",
                window.x, window.y, window.width, window.height, self.width, self.height
            ));
        }
        let width = self.filter.width;
        if !(width > 0.0 && width <= k::MAX_FILTER_WIDTH) {
            return fail(format!(
                "a filter of {width} pixels; it is above 0 and at most {} wide",
                k::MAX_FILTER_WIDTH
            ));
        }
        if self.integrator.k == 0 || self.integrator.k > 1024 {
            return fail(format!("K is {}; it is 1 to 1024", self.integrator.k));
        }
        if self.integrator.light_paths == LightPaths::Pool(Some(0)) {
            return fail("a pool of 0 light paths; it needs at least 1".into());
        }
        if self.rng == Rng::Table(0) {
            return fail("a table of 0 random numbers; it needs at least 1".into());
        }
        if self.max_path_length == Some(0) {
            return fail("a maximum path length of 0; light seen directly has length 1".into());
        }
        if self.clamp.is_some_and(|x| x.is_nan() || x <= 0.0) {
            return fail("the clamp must be greater than 0".into());
        }
        Ok(())
    }
}
