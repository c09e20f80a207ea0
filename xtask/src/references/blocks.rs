//! How two pictures compare where one of them is noisy: by blocks.
//!
//! Each picture is averaged over blocks of 16 x 16 pixels. A block's ratio is ours by theirs, of one
//! channel; the median over blocks is hardly moved by noise, by edges that another pixel filter
//! softens, or by a highlight that another model of roughness shapes otherwise, and moves with any
//! light that is missing or too much.

use anyhow::{Result, ensure};
use midway_film::Image;

/// Pixels along the side of a block.
const BLOCK: usize = 16;
/// Blocks darker than this part of the picture's mean say nothing of their ratio.
const DARK: f64 = 1e-3;

/// The ratios of ours by theirs, over the blocks of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratios {
    /// A tenth of the blocks is below.
    pub p10: f64,
    /// Half of them is below.
    pub median: f64,
    /// A tenth is above.
    pub p90: f64,
}

/// The ratios of the channel whose median is farthest from 1.
///
/// # Errors
/// If the sizes differ, a value is not finite, or the reference is black.
pub fn ratios(ours: &Image, theirs: &Image) -> Result<Ratios> {
    ensure!(ours.size() == theirs.size(), "sizes differ: {:?} and {:?}", ours.size(), theirs.size());
    let finite = |image: &Image| image.pixels.iter().flatten().all(|value| value.is_finite());
    ensure!(finite(ours) && finite(theirs), "a pixel is NaN or infinite");
    let channels = [0, 1, 2].map(|channel| of_channel(ours, theirs, channel));
    let worst = channels.into_iter().flatten().max_by(|a, b| {
        let distance = |ratios: &Ratios| (ratios.median - 1.0).abs();
        distance(a).total_cmp(&distance(b))
    });
    worst.ok_or_else(|| anyhow::anyhow!("the reference is black"))
}

fn of_channel(ours: &Image, theirs: &Image, channel: usize) -> Option<Ratios> {
    let least = theirs.mean()[channel] * DARK;
    let (ours, theirs) = (ours.block_means(BLOCK), theirs.block_means(BLOCK));
    let values = |image: &Image| image.pixels.iter().map(|p| f64::from(p[channel])).collect::<Vec<_>>();
    let pairs = values(&ours).into_iter().zip(values(&theirs));
    let mut ratios: Vec<f64> = pairs.filter(|(_, b)| *b > least).map(|(a, b)| a / b).collect();
    ratios.sort_by(f64::total_cmp);
    let quantile = |part: f64| ratios.get(((ratios.len() - 1) as f64 * part).round() as usize).copied();
    if ratios.is_empty() {
        return None;
    }
    Some(Ratios { p10: quantile(0.1)?, median: quantile(0.5)?, p90: quantile(0.9)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of many levels.
    fn picture() -> Image {
        Image::from_fn(160, 96, |x, y| [1.0 + x as f32 / 16.0, 2.0 + y as f32, 3.0])
    }

    #[test]
    fn the_worst_channel_counts() {
        let theirs = picture();
        assert_eq!(ratios(&theirs, &theirs).unwrap(), Ratios { p10: 1.0, median: 1.0, p90: 1.0 });
        let mut ours = theirs.clone();
        ours.pixels.iter_mut().for_each(|pixel| pixel[2] *= 0.97);
        let found = ratios(&ours, &theirs).unwrap();
        assert!((found.median - 0.97).abs() <= 1e-6, "{found:?}");
    }

    #[test]
    fn a_highlight_moves_the_spread_alone() {
        let theirs = picture();
        let mut ours = theirs.clone();
        for y in 0..96 {
            ours.pixels[y * 160..][..20].fill([9.0; 3]);
        }
        let found = ratios(&ours, &theirs).unwrap();
        // A quarter of the second column of blocks is 9 in place of 3.
        assert!((found.median - 1.0).abs() <= 1e-6 && (found.p90 - 1.5).abs() <= 1e-6, "{found:?}");
    }

    #[test]
    fn must_fail_what_cannot_be_compared() {
        let theirs = picture();
        let mut bad = theirs.clone();
        bad.pixels[7][0] = f32::NAN;
        assert!(ratios(&bad, &theirs).is_err());
        assert!(ratios(&Image::filled(8, 8, [1.0; 3]), &theirs).is_err());
        let black = Image::filled(160, 96, [0.0; 3]);
        assert!(ratios(&theirs, &black).is_err());
        assert_eq!(ratios(&black, &theirs).unwrap().median, 0.0);
    }
}
