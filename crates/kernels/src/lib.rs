//! Midway's WGSL kernels, their native translation and their layouts.
