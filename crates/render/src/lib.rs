//! Renders a scene on a device: packs it into the kernels' layouts, runs integrators as lists of
//! passes, schedules samples.
//!
//! ```no_run
//! # use std::{error::Error, sync::Arc};
//! # fn render(scene: midway_scene::Scene, device: Arc<dyn midway_device::Device>) -> Result<(), Box<dyn Error>> {
//! use midway_render::{RenderSettings, Renderer};
//! let settings = RenderSettings { width: 256, height: 256, ..RenderSettings::default() };
//! let mut renderer = Renderer::new(device, &scene, &scene.cameras[0], settings)?;
//! renderer.step(16)?; // at most 16 samples a pixel more
//! let image = renderer.image()?;
//! # Ok(()) }
//! ```

mod aov;
mod auto;
mod batch;
mod buffers;
mod environment;
mod error;
mod features;
mod hold;
mod light_tree;
mod lights;
mod medium;
mod pack;
mod params;
mod pool;
pub mod rays;
mod record;
mod renderer;
mod settings;
mod sizes;
mod team;
mod world;

pub use aov::Aov;
pub use auto::{Candidate, Choice, choose, settings_ahead};
pub use batch::{KernelTime, KernelTimes, LaneTotals};
pub use error::RenderError;
pub use hold::{Hold, HoldLimits, Load};
pub use pack::PackedScene;
pub use record::BounceRays;
pub use renderer::{Basis, Megakernel, RenderStats, Renderer};
pub use settings::{
    Crop, FilterKind, Integrator, IntegratorSettings, Join, JoinChoice, LightPaths, LightSampling, Mis,
    OneStrategy, PixelFilter, RenderSettings, Rng,
};
pub use team::Team;
