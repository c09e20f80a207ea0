//! The image itself.

use crate::FilmError;

/// A linear RGB image, row-major from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels along x.
    pub width: usize,
    /// Pixels along y.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// An image of one colour.
    #[must_use]
    pub fn filled(width: usize, height: usize, colour: [f32; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// An image whose pixel at column `x`, row `y` is `colour(x, y)`.
    #[must_use]
    pub fn from_fn(width: usize, height: usize, mut colour: impl FnMut(usize, usize) -> [f32; 3]) -> Self {
        let pixels = (0..width * height).map(|i| colour(i % width, i / width)).collect();
        Self { width, height, pixels }
    }

    /// `[width, height]`.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The mean of each channel, summed in f64; zero for an image without pixels.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            for (total, value) in sum.iter_mut().zip(pixel) {
                *total += f64::from(*value);
            }
        }
        sum.map(|total| total / self.pixels.len().max(1) as f64)
    }

    /// Whether no pixel holds anything but zero.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.pixels.iter().all(|pixel| *pixel == [0.0; 3])
    }

    /// The mean of each `block` x `block` square, in an image of one pixel a square. Squares cut by
    /// the right or lower edge are means over the pixels they have. `block` 0 is taken as 1.
    #[must_use]
    pub fn block_means(&self, block: usize) -> Self {
        let block = block.max(1);
        let (columns, rows) = (self.width.div_ceil(block), self.height.div_ceil(block));
        Self::from_fn(columns, rows, |column, row| {
            let xs = column * block..((column + 1) * block).min(self.width);
            let ys = row * block..((row + 1) * block).min(self.height);
            let count = (xs.len() * ys.len()) as f64;
            let mut sum = [0.0_f64; 3];
            for y in ys {
                for pixel in &self.pixels[y * self.width..][xs.clone()] {
                    for (total, value) in sum.iter_mut().zip(pixel) {
                        *total += f64::from(*value);
                    }
                }
            }
            sum.map(|total| (total / count) as f32)
        })
    }

    /// Fails unless the image has `width * height` pixels and at least one.
    pub(crate) fn check_shape(&self) -> Result<(), FilmError> {
        let (width, height, pixels) = (self.width, self.height, self.pixels.len());
        if pixels == 0 || width.checked_mul(height) != Some(pixels) {
            return Err(FilmError::BadShape { width, height, pixels });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_means_average_each_square_and_its_cut_neighbours() {
        let image = Image::from_fn(10, 9, |x, y| [x as f32, y as f32, 1.0]);
        let means = image.block_means(8);
        assert_eq!(means.size(), [2, 2]);
        assert_eq!(means.pixels[0], [3.5, 3.5, 1.0]);
        assert_eq!(means.pixels[3], [8.5, 8.0, 1.0]);
    }

    #[test]
    fn block_means_keep_nan() {
        let mut image = Image::filled(8, 8, [1.0; 3]);
        image.pixels[5][1] = f32::NAN;
        assert!(image.block_means(8).pixels[0][1].is_nan());
    }

    #[test]
    fn a_wrong_pixel_count_is_an_error() {
        let image = Image { width: 2, height: 2, pixels: vec![[0.0; 3]; 3] };
        assert!(matches!(image.check_shape(), Err(FilmError::BadShape { .. })));
        assert!(Image::filled(0, 4, [0.0; 3]).check_shape().is_err());
    }
}
