//! Bad pbrt files give one clear line; none panics, hangs or takes more than it holds.

use std::{io::Write, time::Instant};

use midway_import::{ImportError, load};

use crate::{
    TRIANGLE,
    common::{Folder, load_bytes},
};

/// A small scene with some of everything.
fn everything() -> String {
    format!(
        "LookAt 0 0 5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [45]\nFilm \"rgb\" \"integer xresolution\" 8\n\
         WorldBegin\nAttributeBegin\nLightSource \"point\" \"rgb I\" [1 2 3] \"point3 from\" [0 1 0]\nAttributeEnd\n\
         Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 8 \"rgb tex1\" [.1 .2 .3]\n\
         MakeNamedMaterial \"m\" \"string type\" \"coateddiffuse\" \"texture reflectance\" \"t\"\nNamedMaterial \"m\"\n\
         ObjectBegin \"o\"\n{TRIANGLE} \"float alpha\" .5\nObjectEnd\nTranslate 0 0 -1\nObjectInstance \"o\"\n\
         AreaLightSource \"diffuse\" \"blackbody L\" 5000 \"bool twosided\" true\nShape \"disk\" \"float radius\" .5\n"
    )
}

fn line(text: &str) -> String {
    let error = load_bytes("scene.pbrt", text).unwrap_err();
    let line = error.to_string();
    assert!(!line.contains('\n'), "{line}");
    line
}

#[test]
fn each_fault_is_named_with_its_line() {
    for (text, words) in [
        ("\n\"perspective\"", "scene.pbrt:2"),
        ("Bogus 1 2 3", "Bogus is not a directive"),
        ("Translate 1 2", "ends where a number is expected"),
        ("Translate 1 2 x", "x is not a number"),
        ("Translate 1 2 nan", "not a finite number"),
        ("Scale 1 1 1e999", "not a finite number"),
        ("Transform [1 2 3]", "a number is expected instead of ]"),
        ("Rotate 1 0 0 0", "has no direction"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "LookAt has no direction"),
        ("CoordSysTransform \"none\"", "is not defined"),
        ("ColorSpace \"none\"", "is not known"),
        ("AttributeEnd", "AttributeEnd has no AttributeBegin"),
        ("TransformBegin AttributeEnd", "AttributeEnd has no AttributeBegin"),
        ("ObjectEnd", "ObjectEnd has no ObjectBegin"),
        ("ObjectInstance \"o\"", "is not defined"),
        ("ObjectBegin \"o\" ObjectBegin \"p\"", "not allowed within ObjectBegin"),
        ("ObjectBegin \"o\" ObjectInstance \"o\" ObjectEnd", "not allowed within ObjectBegin"),
        ("ObjectBegin \"o\"", "ObjectBegin has no ObjectEnd"),
        ("WorldBegin WorldBegin", "twice"),
        ("Camera \"perspective\" \"float fov\" 0", "between 0 and 180"),
        ("Camera \"perspective\" \"float\" 3", "is not a type and a name"),
        ("Camera \"perspective\" \"float fov\" \"wide\"", "has to hold numbers"),
        ("Camera \"perspective\" \"float fov\" [1 2]", "has to be one number"),
        ("Camera \"perspective\" \"float fov\" [1 \"a\"]", "not expected among the values"),
        ("Camera \"perspective\" \"float fov\" [1", "ends where a closing bracket"),
        ("Camera \"perspective\" \"float fov", "no closing quote"),
        ("Scale 0 1 1 Camera \"perspective\"", "has no inverse"),
        ("Film \"rgb\" \"integer xresolution\" 0", "xresolution"),
        ("Film \"rgb\" \"integer xresolution\" 1e9", "xresolution"),
        ("Film \"rgb\" \"float iso\" -1", "above 0"),
        ("Material \"diffuse\" \"rgb reflectance\" [1 2]", "wrong number of values"),
        ("Material \"dielectric\" \"float eta\" 0", "above 0"),
        ("Material \"diffuse\" \"spectrum reflectance\" [400]", "wrong number of values"),
        ("Material \"mix\" \"string materials\" [\"a\"]", "of two materials"),
        ("Texture \"t\" \"colour\" \"constant\"", "a texture is"),
        ("Texture \"t\" \"float\" \"imagemap\"", "needs a \"filename\""),
        ("LightSource \"spot\" \"float coneangle\" 200", "coneangle"),
        ("LightSource \"point\" \"blackbody I\" 0", "bad ones"),
        ("LightSource \"point\" \"rgb I\" [1e30 1e39 0]", "too large"),
        ("Shape \"trianglemesh\"", "a mesh needs points"),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0]", "3 numbers for each point"),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0 1e39]", "too large"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 1]",
            "vertex 1 does not exist",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 -1]",
            "vertex -1 does not exist",
        ),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 .5]", "does not exist"),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0]", "three \"indices\""),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 0] \"normal N\" [0 0 1 0 0 1]",
            "2 values for 1",
        ),
        ("Shape \"bilinearmesh\" \"point3 P\" [0 0 0]", "four \"indices\""),
        ("Shape \"sphere\" \"float radius\" -1", "above 0"),
        ("Shape \"plymesh\"", "needs a \"filename\""),
        ("", "no triangles"),
    ] {
        let found = line(text);
        assert!(found.contains(words), "{text:?}: {found:?} does not say {words:?}");
    }
}

#[test]
fn files_outside_the_folder_and_files_that_are_not_there() {
    for directive in [
        "Include \"NAME\"",
        "Import \"NAME\"",
        "Shape \"plymesh\" \"string filename\" \"NAME\"",
        "Material \"conductor\" \"spectrum eta\" \"NAME\"",
        "LightSource \"infinite\" \"string filename\" \"NAME\"",
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"NAME\"",
        "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"NAME\"",
        "AreaLightSource \"diffuse\" \"string filename\" \"NAME\" Shape \"disk\"",
        "Material \"diffuse\" \"string normalmap\" \"NAME\"",
    ] {
        for name in ["../a.txt", "/etc/passwd", "a/../../b", "C:\\\\a"] {
            let result = load_bytes("scene.pbrt", directive.replace("NAME", name));
            assert!(matches!(result, Err(ImportError::UnsafePath { .. })), "{directive} {name}: {result:?}");
        }
        let network = load_bytes("scene.pbrt", directive.replace("NAME", "http://a.org/b"));
        assert!(matches!(network, Err(ImportError::NetworkUri { .. })), "{directive}: {network:?}");
    }
    for directive in ["Include \"none\"", "Import \"none\"", "Shape \"plymesh\" \"string filename\" \"none\""]
    {
        let missing = load_bytes("scene.pbrt", directive);
        assert!(matches!(missing, Err(ImportError::MissingBuffer { .. })), "{directive}: {missing:?}");
    }
}

#[test]
fn files_that_include_themselves() {
    let folder = Folder::new();
    folder.write("a.pbrt", "Include \"b.pbrt\"");
    folder.write("b.pbrt", "Import \"./a.pbrt\"");
    let found = load(&folder.path("a.pbrt")).unwrap_err().to_string();
    assert!(found.contains("b.pbrt:1") && found.contains("includes itself"), "{found}");
}

/// Each of these files includes the next twice: 2³⁰ inclusions, were they not counted.
#[test]
fn files_that_include_each_other_too_often() {
    let folder = Folder::new();
    for i in 0..30 {
        let next = format!("Include \"{}.pbrt\"\n", i + 1);
        folder.write(&format!("{i}.pbrt"), next.repeat(2));
    }
    folder.write("30.pbrt", "");
    let start = Instant::now();
    let found = load(&folder.path("0.pbrt")).unwrap_err();
    assert!(matches!(found, ImportError::TooBig { .. }), "{found}");
    assert!(start.elapsed().as_secs() <= 60);
    let deep = Folder::new();
    for i in 0..100 {
        deep.write(&format!("{i}.pbrt"), format!("Include \"{}.pbrt\"", i + 1));
    }
    let found = load(&deep.path("0.pbrt")).unwrap_err().to_string();
    assert!(found.contains("too deeply"), "{found}");
}

#[test]
fn blocks_without_end() {
    let text = "AttributeBegin\n".repeat(1 << 17);
    assert!(line(&text).contains("nested too deeply"));
}

/// An object of 2¹² meshes, placed 2¹² times: four times more than the world holds.
#[test]
fn instances_beyond_count() {
    let shape = format!("{TRIANGLE}\n");
    let text = format!(
        "WorldBegin ObjectBegin \"o\"\n{}ObjectEnd\n{}",
        shape.repeat(1 << 12),
        "ObjectInstance \"o\"\n".repeat(1 << 12)
    );
    let found = load_bytes("scene.pbrt", text).unwrap_err();
    assert!(matches!(found, ImportError::TooBig { .. }), "{found}");
}

#[test]
fn gzip_that_unpacks_to_too_much() {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![b' '; 1 << 20];
    (0..64).for_each(|_| packer.write_all(&zeros).unwrap());
    let bomb = packer.finish().unwrap();
    let folder = Folder::new();
    folder.write("bomb.ply.gz", &bomb);
    let text = "Shape \"plymesh\" \"string filename\" \"bomb.ply.gz\"";
    let found = load(&folder.write("scene.pbrt", text)).unwrap_err();
    assert!(matches!(found, ImportError::TooBig { .. }), "{found}");
    folder.write("cut.ply.gz", &bomb[..bomb.len() / 2]);
    let cut = load(&folder.write("scene.pbrt", text.replace("bomb", "cut"))).unwrap_err();
    assert!(matches!(cut, ImportError::TooBig { .. } | ImportError::Malformed { .. }), "{cut}");
    let found = load(&folder.write("whole.pbrt", &bomb)).unwrap_err();
    assert!(matches!(found, ImportError::TooBig { .. }), "{found}");
}

#[test]
fn truncation_and_damage_anywhere_are_survived() {
    let text = everything();
    let folder = Folder::new();
    load(&folder.write("scene.pbrt", &text)).unwrap();
    for length in (0..text.len()).filter(|&i| text.is_char_boundary(i)) {
        let _ = load(&folder.write("scene.pbrt", &text[..length]));
    }
    for at in 0..text.len() {
        for value in [0u8, 0xff, b'9', b'-', b'"', b'[', b'#', text.as_bytes()[at] ^ 1] {
            let mut damaged = text.clone().into_bytes();
            damaged[at] = value;
            let _ = load(&folder.write("scene.pbrt", &damaged));
        }
    }
}

/// Words taken out, doubled and swapped for each other.
#[test]
fn words_in_any_order_are_survived() {
    let text = everything();
    let words: Vec<&str> = text.split_whitespace().collect();
    let folder = Folder::new();
    for i in 0..words.len() {
        for j in [i + 1, i + 7, i + 23] {
            let mut shuffled = words.clone();
            shuffled.swap(i, j % words.len());
            let _ = load(&folder.write("scene.pbrt", shuffled.join(" ")));
            shuffled.remove(i);
            let _ = load(&folder.write("scene.pbrt", shuffled.join(" ")));
        }
    }
}
