//! What the proofs share: scenes with known answers, batches of independent estimates, statistics.

pub mod estimate;
pub mod scenes;
pub mod shared;
pub mod statistics;
