//! Round trips, foreign files, hostile files.

use std::{fs, io::Cursor, path::Path};

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, WritableImage, f16};

use super::*;
use crate::{FilmError, Image, Metadata, Value};

fn gradient(width: usize, height: usize) -> Image {
    Image::from_fn(width, height, |x, y| [x as f32 * 0.01, y as f32 * 1e4, -1e-30])
}

fn written(image: &Image, framing: Option<Framing>, metadata: &Metadata) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, image, framing, metadata).unwrap();
    fs::read(&path).unwrap()
}

fn read_bytes(bytes: &[u8]) -> Result<ExrFile, FilmError> {
    ExrFile::from_bytes(Path::new("a.exr"), bytes)
}

#[test]
fn pixels_come_back_bit_for_bit() {
    let mut image = gradient(37, 21);
    image.pixels[3] = [f32::INFINITY, f32::MIN_POSITIVE / 2.0, -0.0];
    let file = read_bytes(&written(&image, None, &Metadata::new())).unwrap();
    assert_eq!((file.width, file.height, file.framing), (37, 21, None));
    assert_eq!(file.image().unwrap(), image);
    assert_eq!(file.layer_names(), [""]);
}

#[test]
fn nan_survives() {
    let mut image = gradient(8, 8);
    image.pixels[5][2] = f32::NAN;
    let back = read_bytes(&written(&image, None, &Metadata::new())).unwrap().image().unwrap();
    assert!(back.pixels[5][2].is_nan());
}

#[test]
fn metadata_comes_back() {
    let matrix = std::array::from_fn(|row| std::array::from_fn(|column| (row * 4 + column) as f32));
    let mut metadata = Metadata::new();
    metadata.set("bias", "maximum path length 5 — ausdrücklich");
    metadata.set("camera", matrix);
    metadata.set("huge", i64::MAX);
    metadata.set("samples", 64_i64);
    metadata.set("seconds", 1.25);
    metadata.set("seed", u32::MAX);
    let back = read_bytes(&written(&gradient(4, 4), None, &metadata)).unwrap().metadata;
    assert_eq!(back.text("bias"), metadata.text("bias"));
    assert_eq!(back.get("camera"), Some(&Value::Matrix(matrix)));
    assert_eq!(back.int("huge"), Some(i64::MAX));
    assert_eq!(back.get("samples"), Some(&Value::Int(64)));
    assert_eq!(back.float("seconds"), Some(1.25));
    assert_eq!(back.int("seed"), Some(u32::MAX.into()));
    assert_eq!(back.entries.len(), 6);
}

#[test]
fn a_crop_keeps_its_place() {
    let framing = Framing { frame: [640, 480], offset: [100, 50] };
    let file = read_bytes(&written(&gradient(20, 10), Some(framing), &Metadata::new())).unwrap();
    assert_eq!(file.framing, Some(framing));
    assert_eq!((file.width, file.height), (20, 10));
}

fn channel(name: &str, samples: Vec<f32>) -> Channel {
    Channel { name: name.to_owned(), samples }
}

#[test]
fn layers_are_written_beside_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let image = gradient(6, 4);
    let layers = ["depth.Z", "albedo.G", "albedo.R", "albedo.B", "samples.Y"];
    let layers: Vec<Channel> =
        (0..).zip(layers).map(|(i, name)| channel(name, vec![i as f32 + 0.5; 24])).collect();
    let framing = Framing { frame: [12, 9], offset: [1, 2] };
    write_exr_with(&path, &image, &layers, Some(framing), &Metadata::new()).unwrap();
    let file = ExrFile::read(&path).unwrap();
    assert_eq!((file.image().unwrap(), file.framing), (image, Some(framing)));
    assert_eq!(file.layer("albedo"), Some(Image::filled(6, 4, [2.5, 1.5, 3.5])));
    for layer in &layers {
        assert_eq!(file.channel(&layer.name), Some(&layer.samples[..]), "{}", layer.name);
    }
    assert_eq!(file.channels.len(), 8);
}

#[test]
fn a_layer_of_another_size_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let layers = [channel("depth.Z", vec![0.0; 23])];
    let error = write_exr_with(&path, &gradient(6, 4), &layers, None, &Metadata::new());
    assert!(matches!(error, Err(FilmError::BadShape { pixels: 23, .. })) && !path.exists());
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = written(&gradient(40, 40), None, &Metadata::new());
    for length in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
        match read_bytes(&bytes[..length]) {
            Err(FilmError::Malformed { .. }) => {}
            other => panic!("{length} of {} bytes: {other:?}", bytes.len()),
        }
    }
}

#[test]
fn damage_never_panics() {
    let bytes = written(&gradient(24, 24), None, &Metadata::new());
    for position in 0..bytes.len() {
        for value in [0, 0x7f, 0xff] {
            let mut damaged = bytes.clone();
            damaged[position] = value;
            // Either outcome is right: a flipped bit in a comment harms nothing.
            let _ = read_bytes(&damaged);
        }
    }
}

#[test]
fn a_header_that_claims_terabytes_is_refused() {
    let mut bytes = written(&gradient(4, 4), None, &Metadata::new());
    let window = position(&bytes, b"dataWindow\0box2i\0") + 17 + 4;
    let chunks = position(&bytes, b"chunkCount\0int\0") + 15 + 4;
    // 60,000 x 60,000 pixels in blocks of 16 lines.
    bytes[window + 8..window + 16].copy_from_slice(&[59_999_i32.to_le_bytes(); 2].concat());
    bytes[chunks..chunks + 4].copy_from_slice(&3750_i32.to_le_bytes());
    let reason = read_bytes(&bytes).unwrap_err().to_string();
    assert!(reason.contains("cannot hold"), "{reason}");
    bytes[window + 8..window + 12].copy_from_slice(&99_999_i32.to_le_bytes());
    let reason = read_bytes(&bytes).unwrap_err().to_string();
    assert!(reason.contains("along a side"), "{reason}");
}

fn position(bytes: &[u8], needle: &[u8]) -> usize {
    bytes.windows(needle.len()).position(|window| window == needle).unwrap()
}

#[test]
fn what_is_no_exr_is_named() {
    let error = read_bytes(b"\x89PNG\r\n").unwrap_err().to_string();
    assert!(error.contains("a.exr: not a usable EXR file"), "{error}");
    assert!(matches!(ExrFile::read(Path::new("/nonexistent.exr")), Err(FilmError::Read { .. })));
}

#[test]
fn a_wrong_shape_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let image = Image { width: 3, height: 3, pixels: vec![[0.0; 3]; 8] };
    assert!(matches!(write_exr(&path, &image, None, &Metadata::new()), Err(FilmError::BadShape { .. })));
    assert!(!path.exists());
}

/// A file as another program might write it: `(channel, samples)`, 4 x 2 pixels.
fn foreign(channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let image = exr::image::Image::from_channels((4, 2), AnyChannels::sort(list));
    let mut bytes = Vec::new();
    image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

fn float(value: f32) -> FlatSamples {
    FlatSamples::F32(vec![value; 8])
}

#[test]
fn layers_halves_and_luminance_are_read() {
    let half = FlatSamples::F16(vec![f16::from_f32(0.5); 8]);
    let beauty = [("beauty.R", half), ("beauty.G", float(2.0)), ("beauty.B", float(3.0))];
    let others =
        [("mask.Y", FlatSamples::U32(vec![1; 8])), ("beauty.A", float(1.0)), ("depth.Z", float(9.0))];
    let file = read_bytes(&foreign(beauty.into_iter().chain(others).collect())).unwrap();
    assert_eq!(file.layer_names(), ["beauty", "mask"]);
    assert_eq!(file.image().unwrap(), Image::filled(4, 2, [0.5, 2.0, 3.0]));
    assert_eq!(file.layer("mask"), Some(Image::filled(4, 2, [1.0; 3])));
    assert_eq!(file.channel("depth.Z"), Some(&[9.0; 8][..]));
    assert_eq!(file.layer("depth"), None);
}

#[test]
fn the_picture_is_found_or_its_absence_named() {
    let rgb = |layer: &str| -> Vec<(String, FlatSamples)> {
        ["R", "G", "B"].iter().map(|c| (format!("{layer}.{c}"), float(0.25))).collect()
    };
    let file = |names: &[(String, FlatSamples)]| {
        read_bytes(&foreign(names.iter().map(|(name, s)| (name.as_str(), s.clone())).collect())).unwrap()
    };
    let blender = [rgb("ViewLayer.Combined"), rgb("ViewLayer.Normal")].concat();
    assert_eq!(file(&blender).image().unwrap(), Image::filled(4, 2, [0.25; 3]));
    assert!(file(&rgb("anything")).image().is_ok());
    let error = file(&[rgb("one"), rgb("two")].concat()).image().unwrap_err().to_string();
    assert!(error.contains("one.R") && error.contains("two.B"), "{error}");
    assert!(read_bytes(&foreign(vec![("Z", float(1.0))])).unwrap().image().is_err());
}

#[test]
fn references_of_another_renderer_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/references");
    let files: Vec<_> = fs::read_dir(&folder).into_iter().flatten().flatten().collect();
    if files.is_empty() {
        eprintln!("not run: no reference images at {}", folder.display());
        return;
    }
    for entry in files {
        let file = ExrFile::read(&entry.path()).unwrap();
        println!("{} {}x{} {:?}", file.path.display(), file.width, file.height, file.layer_names());
        let image = file.image().unwrap();
        assert!(image.mean().iter().all(|mean| *mean > 0.0 && mean.is_finite()));
        // The larger ones hold the picture alone.
        assert!(file.width > 256 || file.layer("se").is_some());
    }
}
