//! What the proofs share: scenes with known answers, batches of independent estimates, statistics.

pub mod albedo;
pub mod camera_scenes;
pub mod dispersion;
pub mod estimate;
pub mod everything;
pub mod held_back;
pub mod integrators;
pub mod lit;
pub mod mitsuba;
pub mod own;
pub mod reference;
pub mod scenes;
pub mod shapes;
pub mod shared;
pub mod statistics;
pub mod stretched;
pub mod stretched_solid;
