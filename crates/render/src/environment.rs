//! The environment as kernels read it: texels, and the table that draws directions by luminance.

use std::f64::consts::{PI, TAU};

use glam::{Mat3, Vec3};
use midway_scene::Surround;
use rayon::prelude::*;

use crate::{
    RenderError,
    lights::{AliasEntry, alias_table, luminance},
};

/// Texels at most, so that places in the kernels' buffer fit a u32.
const MAX_TEXELS: usize = 1 << 28;
/// Radiance at most: squares of luminances stay finite in f32.
const MAX_RADIANCE: f32 = 1e18;

/// An environment ready to be packed.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Columns of texels.
    pub width: u32,
    /// Rows of texels.
    pub height: u32,
    /// Radiance, row by row.
    pub texels: Vec<Vec3>,
    /// Draws cells (`lib/environment.wgsl`), `height` + 1 rows of `width`; empty where all is black.
    pub cells: Vec<AliasEntry>,
    /// The integral of luminance over the sphere, as the kernels interpolate.
    pub total: f64,
    /// A rotation.
    pub world_from_environment: Mat3,
}

impl EnvironmentMap {
    /// Of what is valid; none where there is no environment. A constant one is an image of one texel.
    ///
    /// # Errors
    ///
    /// [`RenderError::Settings`] where the image has more texels than kernels can address.
    pub fn of(surround: &Surround) -> Result<Option<Self>, RenderError> {
        let Some(environment) = &surround.environment else { return Ok(None) };
        let (width, height, texels) = match &surround.image {
            None => (1, 1, vec![bounded(environment.radiance)]),
            Some(image) if image.texels.len() > MAX_TEXELS => {
                return Err(RenderError::Settings(format!(
                    "the environment has {} x {} texels, more than {MAX_TEXELS}: make it smaller",
                    image.width, image.height
                )));
            }
            Some(image) => {
                let texel = |i| Vec3::from_slice(&image.texels.linear(i)[..3]) * environment.radiance;
                (
                    image.width,
                    image.height,
                    (0..image.texels.len()).into_par_iter().map(|i| bounded(texel(i))).collect(),
                )
            }
        };
        let weights = cell_weights(width, height, &texels);
        let total = weights.iter().sum();
        let cells = if total > 0.0 { alias_table(weights) } else { Vec::new() };
        let world_from_environment = environment.world_from_environment;
        Ok(Some(Self { width, height, texels, cells, total, world_from_environment }))
    }
}

fn bounded(radiance: Vec3) -> Vec3 {
    radiance.clamp(Vec3::ZERO, Vec3::splat(MAX_RADIANCE))
}

/// Each cell's solid angle times the mean luminance of its corners.
fn cell_weights(width: u32, height: u32, texels: &[Vec3]) -> Vec<f64> {
    let (columns, rows) = (width as usize, height as usize);
    // Rows are cheaper to weigh twice than to keep: of a large sky that would be more than its image.
    let luminances = |row: usize| -> Vec<f64> {
        let texels = &texels[row * columns..][..columns];
        texels.iter().map(|texel| luminance(texel.as_dvec3())).collect()
    };
    let mut weights = vec![0.0; columns * (rows + 1)];
    weights.par_chunks_mut(columns).enumerate().for_each(|(row, weights)| {
        let solid_angle = TAU / f64::from(width) * row_height(row, rows);
        let (upper, lower) = (luminances(row.saturating_sub(1)), luminances(row.min(rows - 1)));
        for (left, weight) in weights.iter_mut().enumerate() {
            let right = if left + 1 == columns { 0 } else { left + 1 };
            let corners = [upper[left], upper[right], lower[left], lower[right]];
            *weight = 0.25 * solid_angle * corners.iter().sum::<f64>();
        }
    });
    weights
}

/// The difference of the cosines between which a row of cells lies.
fn row_height(row: usize, rows: usize) -> f64 {
    let step = PI / rows as f64;
    if row == 0 || row == rows {
        return 2.0 * (0.25 * step).sin().powi(2);
    }
    2.0 * (row as f64 * step).sin() * (0.5 * step).sin()
}

/// What a black environment has of the total is nothing to divide by.
pub fn inverse_or_zero(total: f64) -> f32 {
    if total > 0.0 { (1.0 / total) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use midway_scene::{Environment, Image, Texels};

    use super::*;

    #[test]
    fn cells_cover_the_sphere() {
        for (width, height) in [(1, 1), (1, 2), (5, 1), (8, 4), (64, 33)] {
            let texels = vec![Vec3::ONE; (width * height) as usize];
            let total: f64 = cell_weights(width, height, &texels).iter().sum();
            assert!((total - 2.0 * TAU).abs() <= 1e-9, "{width} x {height}: {total}");
        }
    }

    /// The kernels' bits do not depend on who has made the table.
    #[test]
    fn threads_change_nothing() {
        let texel = |i: u32| {
            let hash = i.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let value = (hash >> 8) as f32 / (1 << 24) as f32;
            [value.powi(9), value, 0.1, 1.0]
        };
        let (width, height) = (512, 256);
        let texels = Texels::Float((0..width * height).map(texel).collect());
        let environment = Environment {
            radiance: Vec3::splat(2.0),
            image: Some(0),
            world_from_environment: Mat3::IDENTITY,
        };
        let image = Some(Image { name: String::new(), width, height, texels });
        let surround = Surround { environment: Some(environment), image };
        let [one, several] = [1, 4].map(|n_threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| EnvironmentMap::of(&surround).unwrap().unwrap())
        });
        assert_eq!(one, several);
        assert_eq!(one.cells.len(), 512 * 257);
    }

    #[test]
    fn a_cell_between_black_texels_is_never_drawn() {
        let mut texels = vec![Vec3::ZERO; 64 * 32];
        texels[10 * 64 + 5] = Vec3::splat(100.0);
        let weights = cell_weights(64, 32, &texels);
        let table = alias_table(weights.clone());
        assert_eq!(weights.iter().filter(|weight| **weight > 0.0).count(), 4);
        for (entry, weight) in table.iter().zip(&weights) {
            assert!(*weight > 0.0 || entry.threshold == 0.0);
            assert!(weights[entry.alias as usize] > 0.0);
        }
    }
}
