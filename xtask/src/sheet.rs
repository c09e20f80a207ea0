//! Contact sheets: pictures in a grid, each with a caption.

use std::path::Path;

use anyhow::Result;
use midway_film::{Display, Image, Metadata, write_srgb8_png};

use crate::font;

/// Pixels between pictures, and around the sheet.
const GAP: usize = 6;
/// How much the title is enlarged.
const TITLE_SCALE: usize = 2;
const BACKGROUND: [u8; 3] = [24, 24, 26];
const INK: [u8; 3] = [224, 224, 220];

/// A picture with its caption.
pub struct Cell {
    /// Below the picture, cut to its width.
    pub caption: String,
    /// All of a sheet's pictures have the same size.
    pub image: Image,
}

/// A grid of cells; rows may differ in length.
pub struct Sheet {
    /// Above the grid.
    pub title: String,
    /// From the top.
    pub rows: Vec<Vec<Cell>>,
}

impl Sheet {
    /// Draws the sheet and writes it as a PNG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path, display: Display) -> Result<()> {
        let canvas = self.draw(display);
        let mut metadata = Metadata::new();
        metadata.set("title", self.title.as_str());
        write_srgb8_png(path, [canvas.width, canvas.height], &canvas.rgb, &metadata)?;
        Ok(())
    }

    fn draw(&self, display: Display) -> Canvas {
        let [width, height] = self.cell_size();
        let n_columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let title_height = font::HEIGHT * TITLE_SCALE + GAP;
        let row_height = height + font::HEIGHT + 2 * GAP;
        let mut canvas =
            Canvas::new(GAP + n_columns * (width + GAP), GAP + title_height + self.rows.len() * row_height);
        canvas.text([GAP, GAP], &self.title, TITLE_SCALE);
        for (row, cells) in self.rows.iter().enumerate() {
            for (column, cell) in cells.iter().enumerate() {
                let [x, y] = [GAP + column * (width + GAP), GAP + title_height + row * row_height];
                canvas.picture([x, y], &cell.image, display);
                let n_fitting = width / font::ADVANCE;
                let caption: String = cell.caption.chars().take(n_fitting).collect();
                canvas.text([x, y + height + GAP / 2], &caption, 1);
            }
        }
        canvas
    }

    fn cell_size(&self) -> [usize; 2] {
        self.rows.iter().flatten().map(|cell| cell.image.size()).next().unwrap_or([0, 0])
    }
}

/// 8-bit sRGB pixels to draw on; what falls outside is left out.
struct Canvas {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, rgb: BACKGROUND.repeat(width * height) }
    }

    fn set(&mut self, [x, y]: [usize; 2], colour: [u8; 3]) {
        if x < self.width && y < self.height {
            let at = (y * self.width + x) * 3;
            self.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }

    fn picture(&mut self, [left, top]: [usize; 2], image: &Image, display: Display) {
        for (index, pixel) in image.pixels.iter().enumerate() {
            let place = [left + index % image.width, top + index / image.width];
            self.set(place, display.encode_u8(*pixel));
        }
    }

    fn text(&mut self, [left, top]: [usize; 2], text: &str, scale: usize) {
        for (place, character) in text.chars().enumerate() {
            for (column, bits) in font::columns(character).into_iter().enumerate() {
                for row in (0..font::HEIGHT).filter(|row| bits >> row & 1 == 1) {
                    self.square(
                        [left + (place * font::ADVANCE + column) * scale, top + row * scale],
                        scale,
                        INK,
                    );
                }
            }
        }
    }

    fn square(&mut self, [left, top]: [usize; 2], size: usize, colour: [u8; 3]) {
        for offset in 0..size * size {
            self.set([left + offset % size, top + offset / size], colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_has_its_pictures_and_captions() {
        let cell = |caption: &str, level| Cell {
            caption: caption.to_owned(),
            image: Image::filled(32, 16, [level; 3]),
        };
        let sheet = Sheet {
            title: "title".to_owned(),
            rows: vec![vec![cell("a", 0.0), cell("b", 1.0)], vec![cell("c, é", 1.0)]],
        };
        let canvas = sheet.draw(Display::default());
        assert_eq!([canvas.width, canvas.height], [6 + 2 * 38, 6 + 22 + 2 * 36]);
        assert_eq!(canvas.rgb.len(), canvas.width * canvas.height * 3);
        let whites = canvas.rgb.chunks(3).filter(|pixel| *pixel == [255; 3]).count();
        assert_eq!(whites, 2 * 32 * 16);
        assert!(canvas.rgb.chunks(3).any(|pixel| pixel == INK));
    }
}
