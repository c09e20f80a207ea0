//! Proofs of the kernels' functions, one by one: samplers against their densities, scattering
//! against its laws, MIS weights against their definition, and every function on a GPU against the
//! same function on the CPU.

mod bsdf_laws;
mod bsdf_sampling;
mod chi_square;
mod film;
mod maths;
mod mis;
mod random_numbers;
mod sampling;
mod support;
mod textures;
mod twins;
