//! Proofs at the level of images: what the estimators converge to, and that the same seed gives
//! the same bits. `cargo test --release -p midway-tests --test proofs -- --nocapture` prints each
//! error; `MIDWAY_NIGHTLY=1` takes more samples and holds means to 0.3 %.

mod agreement;
mod basis;
mod cameras;
mod closed_forms;
mod crops;
mod degenerate;
mod devices;
mod dispersion;
mod filters;
mod importers;
mod instances;
mod joins;
mod layers;
mod light_groups;
mod light_tree;
mod megakernel;
mod normal_maps;
mod references;
mod repeatability;
mod same_scene;
mod strategies;
mod support;
mod teams;
