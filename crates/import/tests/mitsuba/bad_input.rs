//! Files of meshes, and bad files, which give one clear line.

use std::{io::Write, time::Instant};

use flate2::{Compression, write::ZlibEncoder};
use glam::Vec3;
use midway_import::{Import, ImportError, WarningKind, load};

use crate::{LAMP, common::Folder, document, refused, scene};

/// A `.serialized` file of version 4 of one mesh with these numbers of vertices and triangles announced.
fn serialized(n_vertices: u64, n_triangles: u64, last: f32, indices: [u32; 3]) -> Vec<u8> {
    serialized_as(0x1000, n_vertices, n_triangles, last, indices)
}

/// The same with these flags.
fn serialized_as(flags: u32, n_vertices: u64, n_triangles: u64, last: f32, indices: [u32; 3]) -> Vec<u8> {
    let mut body = flags.to_le_bytes().to_vec();
    body.extend(b"name\0");
    body.extend(n_vertices.to_le_bytes());
    body.extend(n_triangles.to_le_bytes());
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, last] {
        body.extend(x.to_le_bytes());
    }
    indices.iter().for_each(|i| body.extend(i.to_le_bytes()));
    let mut bytes = [0x041cu16, 4].iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&body).unwrap();
    bytes.extend(encoder.finish().unwrap());
    bytes.extend(0u64.to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes
}

const SERIALIZED: &str = "<shape type='serialized'><string name='filename' value='m.serialized'/></shape>";

fn load_serialized(bytes: &[u8]) -> Result<Import, ImportError> {
    load_serialized_by("3.0.0", bytes)
}

fn load_serialized_by(release: &str, bytes: &[u8]) -> Result<Import, ImportError> {
    let folder = Folder::new();
    folder.write("m.serialized", bytes);
    load(&folder.write("scene.xml", format!("<scene version='{release}'>{LAMP}{SERIALIZED}</scene>")))
}

#[test]
fn serialized_meshes_are_read_and_bounded() {
    let good = serialized(3, 1, 0.0, [0, 1, 2]);
    let import = load_serialized(&good).unwrap();
    assert_eq!(import.scene.meshes[1].positions[1..], [Vec3::X, Vec3::Y]);
    assert_eq!(import.scene.meshes[1].normals.len(), 3);
    // Face normals are asked for by the file in release 0.6, and by the scene alone since.
    let flat = serialized_as(0x1010, 3, 1, 0.0, [0, 1, 2]);
    for (release, n_normals) in [("0.6.0", 0), ("3.0.0", 3)] {
        let import = load_serialized_by(release, &flat).unwrap();
        assert_eq!(import.scene.meshes[1].normals.len(), n_normals, "{release}");
    }
    let start = Instant::now();
    for (n_vertices, n_triangles) in
        [(u64::MAX, 1), (u64::from(u32::MAX), 1), (3, u64::MAX), (3, 1 << 26), (4, 1)]
    {
        let result = load_serialized(&serialized(n_vertices, n_triangles, 0.0, [0, 1, 2]));
        assert!(
            matches!(result, Err(ImportError::TooBig { .. } | ImportError::Truncated { .. })),
            "{n_vertices} {n_triangles}: {result:?}"
        );
    }
    assert!(start.elapsed().as_secs() < 5);
    let nan = load_serialized(&serialized(3, 1, f32::NAN, [0, 1, 2]));
    assert!(matches!(nan, Err(ImportError::NotFinite { index: 2, .. })), "{nan:?}");
    let far = load_serialized(&serialized(3, 1, 0.0, [0, 1, 3]));
    assert!(matches!(far, Err(ImportError::OutOfRange { .. })), "{far:?}");
    for length in 0..good.len() {
        assert!(load_serialized(&good[..length]).is_err(), "cut at {length}");
    }
    for at in 0..good.len() {
        for value in [0, 0xff, good[at] ^ 1] {
            let mut damaged = good.clone();
            damaged[at] = value;
            let _ = load_serialized(&damaged);
        }
    }
}

#[test]
fn bad_documents_are_refused() {
    let mut deep = String::new();
    (0..100_000).for_each(|_| deep.push_str("<bsdf type='twosided'>"));
    (0..100_000).for_each(|_| deep.push_str("</bsdf>"));
    let cases = [
        ("", "not XML"),
        ("<scene", "not XML"),
        // What the parser says of it quotes the line break.
        ("<scene version='3.0.0'/\n>", "not XML"),
        ("<mesh/>", "begins with <mesh>"),
        ("<scene version='3.0.0'></scene>", "no triangles"),
        ("<scene version='3.0.0'><nonsense name='a' value='1'/></scene>", "<nonsense>"),
        ("<scene version='3.0.0'><shape type='cube'><ref id='x'/></shape></scene>", "nothing has this id"),
        (
            "<scene version='3.0.0'><shape type='cube'><transform name='to_world'><scale value='$s'/></transform></shape></scene>",
            "\"$s\"",
        ),
        (
            "<scene version='3.0.0'><shape type='cube' id='a'/><shape type='cube' id='a'/></scene>",
            "given twice",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='nan'/></shape></scene>",
            "<float>",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='-1'/></shape></scene>",
            "radius",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><string name='radius' value='1'/></shape></scene>",
            "has to be a number",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='twosided' id='a'><ref id='a'/></bsdf></shape></scene>",
            "without end",
        ),
        ("<scene version='3.0.0'><shape type='obj'/></scene>", "names no file"),
        (
            "<scene version='3.0.0'><shape type='shapegroup' id='g'><shape type='instance'><ref id='g'/></shape></shape></scene>",
            "instance",
        ),
        (
            "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='180'/></sensor></scene>",
            "field of view",
        ),
        (
            "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'><integer name='width' value='0'/></film></sensor></scene>",
            "pixels",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf></shape></scene>",
            "above 0",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='-1'/></bsdf></shape></scene>",
            "below 0",
        ),
    ];
    for (text, words) in cases {
        refused(document(text), words);
    }
    refused(document(&format!("<scene version='3.0.0'>{deep}</scene>")), "nested too deep");
}

#[test]
fn entities_do_not_multiply() {
    let mut laughs = String::from("<!DOCTYPE scene [<!ENTITY a 'ha'>");
    for (name, before) in
        ["b", "c", "d", "e", "f", "g", "h", "i"].iter().zip(["a", "b", "c", "d", "e", "f", "g", "h"])
    {
        laughs.push_str(&format!("<!ENTITY {name} '{}'>", format!("&{before};").repeat(10)));
    }
    laughs.push_str("]><scene version='3.0.0'><shape type='&i;'/></scene>");
    let start = Instant::now();
    refused(document(&laughs), "DTD");
    assert!(start.elapsed().as_secs() < 2);
}

#[test]
fn files_stay_in_the_scenes_folder() {
    let file = |kind: &str, name: &str| {
        format!("<shape type='{kind}'><string name='filename' value='{name}'/></shape>")
    };
    for name in ["../a.obj", "/etc/passwd", "a/../../b.ply"] {
        let result = scene(&file("obj", name));
        assert!(matches!(result, Err(ImportError::UnsafePath { .. })), "{name}: {result:?}");
    }
    assert!(matches!(scene(&file("ply", "http://example.org/a.ply")), Err(ImportError::NetworkUri { .. })));
    refused(scene(&file("serialized", "none.serialized")), "does not exist");
    refused(scene("<include filename='none.xml'/>"), "does not exist");
    let image = "<shape type='cube'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>\
        <string name='filename' value='none.png'/></texture></bsdf></shape>";
    assert!(scene(image).unwrap().warnings.iter().any(|w| w.kind == WarningKind::MissingFile));
}

#[test]
fn includes_end() {
    let folder = Folder::new();
    let twice =
        "<scene version='3.0.0'><include filename='scene.xml'/><include filename='scene.xml'/></scene>";
    let start = Instant::now();
    refused(load(&folder.write("scene.xml", twice)), "include each other");
    assert!(start.elapsed().as_secs() < 5);
}

/// Every byte of a scene changed: whatever comes of it, it is no panic.
#[test]
fn damage_anywhere_is_survived() {
    let text = format!(
        "<scene version='3.0.0'>{LAMP}<shape type='cube'><bsdf type='roughconductor'><float name='alpha' value='0.1'/>\
        <spectrum name='eta' value='400:1,700:2'/></bsdf><transform name='to_world'><rotate x='1' angle='3'/></transform>\
        </shape><sensor type='thinlens'><float name='aperture_radius' value='1'/></sensor></scene>"
    );
    let folder = Folder::new();
    for at in 0..text.len() {
        for value in [b'0', b'-', b'<', b'\'', 0xff] {
            let mut damaged = text.clone().into_bytes();
            damaged[at] = value;
            let _ = load(&folder.write("scene.xml", &damaged));
        }
    }
}
