//! What PLY files come to, and bad ones.

mod common;

use common::load_bytes;
use glam::{Vec3, vec2, vec3, vec4};
use midway_import::{Import, ImportError};
use midway_scene::Surface;

fn ascii(vertices: &str, body: &str) -> String {
    format!("ply\nformat ascii 1.0\ncomment of ours\n{vertices}end_header\n{body}")
}

fn import(bytes: impl AsRef<[u8]>) -> Import {
    load_bytes("a.ply", bytes).unwrap_or_else(|e| panic!("{e}"))
}

const QUAD: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
    element face 1\nproperty list uchar int vertex_indices\n";

#[test]
fn polygons_become_triangles() {
    let found = import(ascii(QUAD, "0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n"));
    let area: f32 = found.scene.world_triangles().map(|t| t.area()).sum();
    assert_eq!(area, 2.0);
    assert!(found.scene.world_triangles().all(|t| t.geometric_normal() == Some(Vec3::Z)));
}

#[test]
fn every_attribute_and_byte_order() {
    let header = |format: &str| {
        format!(
            "ply\r\nformat {format} 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n\
            property float nx\r\nproperty float ny\r\nproperty float nz\r\nproperty float s\r\nproperty float t\r\n\
            property uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\nproperty list uchar short extra\r\n\
            element other 1\r\nproperty int a\r\nelement face 1\r\nproperty uchar flags\r\n\
            property list uint ushort vertex_index\r\nend_header\r\n"
        )
    };
    let vertices = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for big in [false, true] {
        let mut bytes = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let mut put = |little: &[u8]| {
            let mut number = little.to_vec();
            if big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y, z] in vertices {
            [x, y, z, 0.0, 0.0, 2.0, x, y].iter().for_each(|f| put(&f.to_le_bytes()));
            [255u8, 0, 128, 1].iter().for_each(|b| put(&[*b]));
            put(&7i16.to_le_bytes());
        }
        put(&5i32.to_le_bytes());
        put(&[9]);
        put(&3u32.to_le_bytes());
        [0u16, 1, 2].iter().for_each(|i| put(&i.to_le_bytes()));
        let found = import(&bytes);
        let mesh = &found.scene.meshes[0];
        assert_eq!(mesh.positions, vertices.map(Vec3::from_array));
        assert_eq!(mesh.normals, [Vec3::Z; 3]);
        assert_eq!(mesh.uvs[0], [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(0.0, 0.0)]);
        // 128 of 255 by the sRGB curve.
        assert!(mesh.colors[0].distance(vec4(1.0, 0.0, 0.215_861, 1.0)) <= 1e-5);
        assert_eq!(found.scene.materials[0].surface, Surface::diffuse(Vec3::ONE));
    }
}

/// Whole numbers of 32 bits, the indices of most files, are read by themselves in little endian.
#[test]
fn indices_of_32_bits_in_both_byte_orders() {
    for (kind, index, is_there) in
        [("int", -1i32, false), ("uint", -1, false), ("int", 3, true), ("uint", 3, true)]
    {
        for format in ["binary_little_endian", "binary_big_endian"] {
            let mut bytes = ascii(&QUAD.replace("uchar int", &format!("uchar {kind}")), "");
            bytes = bytes.replace("ascii", format);
            let order = |mut bytes: Vec<u8>| {
                if format == "binary_big_endian" {
                    bytes.reverse();
                }
                bytes
            };
            let mut bytes = bytes.into_bytes();
            for [x, y] in [[0.0f32, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]] {
                bytes.extend([x, y].map(|x| order(x.to_le_bytes().into())).concat());
                bytes.extend([0; 8]);
            }
            bytes.push(4);
            bytes.extend([0, 1, 2, index].map(|i| order(i.to_le_bytes().into())).concat());
            let found = load_bytes("a.ply", &bytes);
            if is_there {
                let area: f32 = found.expect("is read").scene.world_triangles().map(|t| t.area()).sum();
                assert_eq!(area, 2.0);
            } else {
                assert!(matches!(found, Err(ImportError::OutOfRange { index: -1, .. })), "{kind}, {format}");
            }
        }
    }
}

#[test]
fn strips_keep_their_front() {
    let header = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\n";
    let found = import(ascii(header, "0 0 0 1 0 0 0 1 0 1 1 0\n8 0 1 2 3 -1 0 1 2\n"));
    assert_eq!(found.scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 3], [0, 1, 2]]);
    assert!(found.scene.world_triangles().all(|t| t.geometric_normal() == Some(Vec3::Z)));
}

#[test]
fn bad_files_give_one_line() {
    let vertices = "0 0 0\n2 0 0\n2 1 0\n0 1 0\n";
    let huge = QUAD.replace("vertex 4", "vertex 4000000000000");
    for (text, kind) in [
        (String::new(), "malformed"),
        ("plx\n".to_owned(), "malformed"),
        ("ply\nformat ascii 1.0\n".to_owned(), "malformed"),
        ("ply\nformat trinary 1.0\nend_header\n".to_owned(), "malformed"),
        ("ply\nend_header\n".to_owned(), "malformed"),
        (ascii("property float x\n", ""), "malformed"),
        (ascii("element vertex x\n", ""), "malformed"),
        (ascii("element vertex 1\nproperty quad x\n", ""), "malformed"),
        (ascii("element vertex 1\nproperty float x\n", "1\n"), "malformed"),
        (ascii(QUAD, "0 0 0\n"), "malformed"),
        (ascii(QUAD, &format!("{vertices}4 0 1 2\n")), "malformed"),
        (ascii(QUAD, &format!("{vertices}-4 0 1 2\n")), "malformed"),
        (ascii(QUAD, &format!("{vertices}4294967295 0 1 2\n")), "malformed"),
        (ascii(&huge, vertices), "malformed"),
        (ascii(QUAD, &format!("{vertices}3 0 1 4\n")), "range"),
        (ascii(QUAD, &format!("{vertices}3 0 1 -1\n")), "range"),
        (ascii(QUAD, &format!("{vertices}3 0 1 1.5\n")), "range"),
        (ascii(QUAD, &format!("nan{vertices}3 0 1 2\n")), "malformed"),
        (ascii(QUAD, "inf 0 0\n2 0 0\n2 1 0\n0 1 0\n3 0 1 2\n"), "finite"),
        (ascii(QUAD, &format!("{vertices}2 0 1\n")), "empty"),
    ] {
        let error = load_bytes("a.ply", &text).expect_err(&text);
        let found = match &error {
            ImportError::Malformed { .. } => "malformed",
            ImportError::OutOfRange { .. } => "range",
            ImportError::NotFinite { .. } => "finite",
            ImportError::EmptyScene { .. } => "empty",
            other => panic!("{other:?}"),
        };
        assert_eq!(found, kind, "{text:?}: {error}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    // Elements without properties take no room: however many are claimed, they are none.
    let none = format!("element vertex 4{QUAD}")
        .replace("element vertex 4element", "element nothing 99999999999\nelement");
    let found = import(ascii(&none, &format!("{vertices}4 0 1 2 3\n")));
    assert_eq!(found.scene.meshes[0].positions[2], vec3(2.0, 1.0, 0.0));
}
