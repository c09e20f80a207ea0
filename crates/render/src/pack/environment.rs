//! The environment as `bindings/environment.wgsl` reads it.

use midway_kernels::constants as k;
use rayon::prelude::*;

use super::{Words, word4};
use crate::environment::{EnvironmentMap, inverse_or_zero};

/// Frame, texels, and the table of cells, two entries a word. `light`: its place among the lights.
pub(super) fn pack_environment(map: &EnvironmentMap, light: Option<u32>, words: &mut Words) {
    let frame = map.world_from_environment;
    words.extend([
        word4(frame.x_axis, map.width),
        word4(frame.y_axis, map.height),
        word4(frame.z_axis, light.unwrap_or(k::NONE)),
        [inverse_or_zero(map.total).to_bits(), 0, 0, 0],
    ]);
    words.par_extend(map.texels.par_iter().map(|&texel| word4(texel, 0)));
    words.par_extend(map.cells.par_chunks(2).map(|pair| {
        let entry = |i: usize| pair.get(i).map_or([0; 2], |entry| [entry.threshold.to_bits(), entry.alias]);
        let ([a, b], [c, d]) = (entry(0), entry(1));
        [a, b, c, d]
    }));
}
