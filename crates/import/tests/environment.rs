//! Environments from files: what they hold, and bad input.

use std::fs;

use midway_import::{ImportError, load_environment};
use midway_scene::Texels;

/// A Radiance file of `width` x `height` flat RGBE texels, mantissas 128 and exponent 129: all 1.
fn hdr(width: u32, height: u32) -> Vec<u8> {
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let texels = [128u8, 128, 128, 129].repeat((width * height) as usize);
    [header.into_bytes(), texels].concat()
}

#[test]
fn a_radiance_file_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    fs::write(&path, hdr(4, 2)).unwrap();
    let (image, warnings) = load_environment(&path).unwrap();
    assert_eq!((image.width, image.height, image.name.as_str()), (4, 2, "sky.hdr"));
    assert!(warnings.is_empty());
    let Texels::Float(texels) = image.texels else { panic!("not floats") };
    for texel in texels.iter() {
        assert!(texel[..3].iter().all(|x| (x - 1.0).abs() <= 0.01), "{texel:?}");
    }
}

#[test]
fn an_odd_shape_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.hdr");
    fs::write(&path, hdr(3, 3)).unwrap();
    let (_, warnings) = load_environment(&path).unwrap();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].to_string().contains("3 x 3"), "{}", warnings[0]);
}

#[test]
fn what_is_no_image_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.hdr");
    assert!(matches!(load_environment(&path), Err(ImportError::NotFound { .. })));
    assert!(load_environment(folder.path()).is_err());
    let whole = hdr(4, 2);
    let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65536 +X 65536\n".to_vec();
    let wide = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\n".to_vec();
    let cut = whole[..whole.len() - 5].to_vec();
    for bytes in [vec![], b"not an image".to_vec(), whole[..20].to_vec(), cut, huge, wide] {
        fs::write(&path, bytes).unwrap();
        let error = load_environment(&path).unwrap_err().to_string();
        assert!(error.contains("bad.hdr") && error.lines().count() == 1, "{error}");
    }
}
