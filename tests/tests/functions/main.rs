//! Proofs of the kernels' functions, one by one: samplers against their densities, scattering
//! against its laws, MIS weights against their definition, and every function on a GPU against the
//! same function on the CPU.

mod albedo_tables;
mod bsdf_laws;
mod bsdf_leaning;
mod bsdf_models;
mod bsdf_sampling;
mod bsdf_stretched;
mod cameras;
mod chi_square;
mod dispersion;
mod film;
mod light_tree;
mod lights;
mod maths;
mod mis;
mod models;
mod pixel_filter;
mod random_numbers;
mod sampling;
mod sobol;
mod support;
mod textures;
mod twins;
