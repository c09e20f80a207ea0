//! PNG out: 8-bit sRGB, metadata in text chunks.

use std::{
    io::{self, Cursor},
    path::Path,
};

use crate::{Display, FilmError, Image, Metadata, atomic::write_atomically};

/// Writes `image` as `display` shows it, with `metadata` in text chunks.
///
/// # Errors
/// [`FilmError::BadShape`], or [`FilmError::Write`] with the old file untouched.
pub fn write_png(path: &Path, image: &Image, display: Display, metadata: &Metadata) -> Result<(), FilmError> {
    image.check_shape()?;
    let rgb: Vec<u8> = image.pixels.iter().flat_map(|pixel| display.encode_u8(*pixel)).collect();
    write_srgb8_png(path, image.size(), &rgb, metadata)
}

/// Writes `rgb`, three bytes a pixel, already encoded as sRGB.
///
/// # Errors
/// [`FilmError::BadShape`], or [`FilmError::Write`] with the old file untouched.
pub fn write_srgb8_png(
    path: &Path,
    [width, height]: [usize; 2],
    rgb: &[u8],
    metadata: &Metadata,
) -> Result<(), FilmError> {
    let fail = |source| FilmError::Write { path: path.to_owned(), source };
    let (Ok(columns), Ok(rows)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(FilmError::BadShape { width, height, pixels: rgb.len() / 3 });
    };
    if width.checked_mul(height).and_then(|n| n.checked_mul(3)) != Some(rgb.len()) {
        return Err(FilmError::BadShape { width, height, pixels: rgb.len() / 3 });
    }
    let bytes = encode([columns, rows], rgb, metadata).map_err(|error| fail(io::Error::other(error)))?;
    write_atomically(path, &bytes)
}

fn encode([width, height]: [u32; 2], rgb: &[u8], metadata: &Metadata) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(Cursor::new(&mut bytes), width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_itxt_chunk("Software".into(), concat!("Midway ", env!("CARGO_PKG_VERSION")).into())?;
    for (name, value) in &metadata.entries {
        encoder.add_itxt_chunk(format!("midway:{name}"), value.to_text())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn pixels_and_text_are_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut metadata = Metadata::new();
        metadata.set("integrator", "bdpt — voll");
        let image = Image::from_fn(3, 2, |x, y| [x as f32, y as f32, 0.18]);
        write_png(&path, &image, Display::default(), &metadata).unwrap();

        let bytes = fs::read(&path).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        assert_eq!(&rgb[..6], [0, 0, 118, 255, 0, 118]);
        let texts = &reader.info().utf8_text;
        let found = texts.iter().find(|text| text.keyword == "midway:integrator").unwrap();
        assert_eq!(found.get_text().unwrap(), "bdpt — voll");
    }

    #[test]
    fn a_wrong_length_is_an_error() {
        let path = Path::new("unused.png");
        let error = write_srgb8_png(path, [2, 2], &[0; 11], &Metadata::new()).unwrap_err();
        assert!(matches!(error, FilmError::BadShape { .. }));
    }
}
