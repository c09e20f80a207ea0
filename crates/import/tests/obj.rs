//! What OBJ and MTL files come to.

mod common;

use common::{Folder, image_bytes, load_bytes};
use glam::{Vec3, vec2, vec3, vec4};
use midway_import::{Import, Options, WarningKind, load, load_with};
use midway_scene::{
    Channel, ConductorFresnel, Material, MetallicRoughness, Opacity, Roughness, Sides, Surface, Texels, Wrap,
};

/// Two triangles that share an edge, folded by a right angle.
const FOLDED: &str = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\n";

fn kinds(import: &Import) -> Vec<WarningKind> {
    let of_any = [WarningKind::NoCamera, WarningKind::NoLight];
    import.warnings.iter().map(|w| w.kind).filter(|k| !of_any.contains(k)).collect()
}

fn material(lines: &str) -> (Material, Vec<WarningKind>) {
    let folder = Folder::new();
    folder.write("m.mtl", format!("# comment\nnewmtl a b\n{lines}\n"));
    let scene = folder.write("scene.obj", format!("mtllib m.mtl\n{FOLDED}usemtl a b\nf 1 2 3\n"));
    let import = load(&scene).unwrap_or_else(|e| panic!("{e}"));
    (import.scene.materials[0].clone(), kinds(&import))
}

#[test]
fn a_line_may_name_several_libraries_by_any_slash() {
    let folder = Folder::new();
    folder.write("sub/a.mtl", "newmtl a\nKd 1 0 0\n");
    folder.write("b.mtl", "newmtl b\nKd 0 1 0\n");
    folder.write("c d.mtl", "newmtl c\nKd 0 0 1\n");
    let faces = "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n";
    let scene =
        folder.write("scene.obj", format!("mtllib sub\\a.mtl b.mtl\nmtllib c d.mtl\n{FOLDED}{faces}"));
    let import = load(&scene).unwrap();
    assert_eq!(kinds(&import), []);
    for colour in [Vec3::X, Vec3::Y, Vec3::Z] {
        let surface = Surface::Diffuse { reflectance: colour.into() };
        assert!(import.scene.materials.iter().any(|material| material.surface == surface), "{colour}");
    }
    let scene = folder.write("scene.obj", format!("mtllib b.mtl e.mtl\n{FOLDED}{faces}"));
    let warnings: Vec<String> = load(&scene).unwrap().warnings.iter().map(|w| w.message.clone()).collect();
    assert!(warnings.iter().any(|warning| warning.contains("\"e.mtl\" does not exist")), "{warnings:?}");
}

/// Exporters write their author's folders: an absolute path is that of a file which may be read, or else
/// only the name counts.
#[test]
fn absolute_paths_lead_to_files_in_the_root_and_others_to_the_file_of_that_name() {
    let folder = Folder::new();
    let picture = image_bytes(&[[255, 0, 0, 255]], 1, image::ImageFormat::Png);
    folder.write("textures/a.png", &picture);
    folder.write("scenes/b.png", &picture);
    let absolute = |name: &str| folder.path(name).display().to_string();
    let maps = |a: &str, b: &str| format!("newmtl m\nmap_Kd {a}\nmap_Ks {b}\nKd 1\nKs 0.1\nNs 9\n");
    let (a, b) = (absolute("textures/a.png"), "/home/author/b.png");
    folder.write("materials/m.mtl", maps(&a, "../textures/a.png"));
    folder.write("scenes/m.mtl", maps("C:\\author\\b.png", b));
    let faces = format!("{FOLDED}usemtl m\nf 1 2 3\n");
    let options = Options { root: Some(folder.0.path().to_owned()), ..Options::default() };
    for library in [absolute("materials/m.mtl"), "/home/author/m.mtl".into(), "C:\\author\\m.mtl".into()] {
        let scene = folder.write("scenes/scene.obj", format!("mtllib {library}\n{faces}"));
        let (result, warnings) = load_with(&scene, &options);
        let images = result.unwrap_or_else(|e| panic!("{e}")).0.images;
        assert!(images.iter().all(|image| image.texels.len() == 1), "{images:?}");
        assert!(!warnings.iter().any(|w| w.kind == WarningKind::MissingFile), "{library}: {warnings:?}");
    }
    // Without the root it is the one beside the scene.
    let scene = folder.write("scenes/scene.obj", format!("mtllib {}\n{faces}", absolute("materials/m.mtl")));
    let names: Vec<String> = load(&scene).unwrap().scene.images.iter().map(|i| i.name.clone()).collect();
    assert!(names.iter().all(|name| name == "b.png"), "{names:?}");
}

#[test]
fn materials() {
    use WarningKind::{Alpha, Approximation, MissingFile, Repaired, Texture, Unused};
    let rough = |exponent: f32| Roughness::alpha((2.0 / (exponent + 2.0)).sqrt());
    let metal = |f0, exponent| Surface::Conductor {
        fresnel: ConductorFresnel::Schlick { f0: Vec3::splat(f0).into() },
        roughness: rough(exponent),
    };
    let plastic = |kd, ks, ior, exponent| Surface::Plastic {
        reflectance: Vec3::splat(kd).into(),
        specular: Vec3::splat(ks).into(),
        ior,
        nonlinear: false,
        roughness: rough(exponent),
    };
    let diffuse = |r| Surface::diffuse(Vec3::splat(r));
    let mirror = |r| Surface::mirror(Vec3::splat(r));
    let glass = |ior, tint| Surface::Dielectric {
        ior,
        dispersion: 0.0,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::splat(tint).into(),
        sigma_a: Vec3::ZERO,
        thin: false,
        roughness: Roughness::smooth(),
    };
    for (lines, surface, warnings) in [
        ("Kd 0.5 0.5 0.5", diffuse(0.5), vec![]),
        ("Kd 0.5\nKs 0 0 0\nillum 2", diffuse(0.5), vec![]),
        ("Kd 0.5\nKs 0.9\nNs 500\nillum 1", diffuse(0.5), vec![]),
        ("Kd 0.5\nKs 0.1\nNs 500\nillum 2", plastic(0.5, 0.1, 1.5, 500.0), vec![Approximation]),
        ("Kd 0.1\nKs 0.9\nNs 5\nNi 1.3\nillum 2", plastic(0.1, 0.9, 1.3, 5.0), vec![Approximation]),
        ("Kd 0.1\nKs 0.9\nNs 500\nillum 2", metal(0.9, 500.0), vec![Approximation]),
        ("Kd 0\nKs 0.9\nNs 5", metal(0.9, 5.0), vec![]),
        ("Kd 0\nKs 0.9\nillum 3", mirror(0.9), vec![]),
        ("Kd 0\nKs 0.9\nillum 5", mirror(0.9), vec![]),
        ("Ni 1.4\nTf 0.5 0.5 0.5\nillum 7", glass(1.4, 0.5), vec![]),
        // Models that exporters write for what they are not.
        ("Kd 0.8\nKs 0.1\nNs 10\nillum 3", plastic(0.8, 0.1, 1.5, 10.0), vec![Approximation; 2]),
        ("Kd 0.8\nd 1.0\nillum 4", diffuse(0.8), vec![Approximation]),
        ("Kd 0.8\nNi 1.4\nd 0.9\nillum 9", glass(1.4, 1.0), vec![Approximation]),
        ("Kd 0.5\nKs 0.1\nNs 500\nillum 2.0", plastic(0.5, 0.1, 1.5, 500.0), vec![Approximation]),
        ("Ni 1.4\nTf 0 0 0\nillum 6", glass(1.4, 1.0), vec![Repaired]),
        ("illum 4", glass(1.5, 1.0), vec![Repaired]),
        ("Kd 0.5\nd 0.1\nNi 1.4", glass(1.4, 1.0), vec![Alpha]),
        ("Kd 0.5\nTr 0.9\nNi 1.4", glass(1.4, 1.0), vec![Alpha]),
        ("Kd 0.5\nd 0.9\nNi 1.4", diffuse(0.5), vec![]),
        ("Kd 1.5", diffuse(1.0), vec![Repaired]),
        ("Kd 0.5\nmap_Kd a.png\nbump b.png", diffuse(0.5), vec![Texture, MissingFile]),
        ("Kd 0.5\nhalo 0.3", diffuse(0.5), vec![Unused]),
    ] {
        let (found, kinds) = material(lines);
        assert_eq!((found.surface, kinds), (surface, warnings), "{lines:?}");
    }
    let (clear, _) = material("Kd 0.5\nd 0.25");
    assert_eq!(clear.opacity, Opacity::Blend(0.25.into()));
    let (light, _) = material("Kd 0\nKe 10 5 1");
    assert_eq!((light.emission, light.emits), (vec3(10.0, 5.0, 1.0).into(), Sides::Front));
}

#[test]
fn flat_smooth_and_given_normals() {
    let import = load_bytes("a.obj", format!("{FOLDED}f 1 2 3\nf 1 4 2\n")).unwrap();
    assert!(import.scene.meshes[0].normals.is_empty());
    assert_eq!(import.scene.meshes[0].positions.len(), 4);

    let import = load_bytes("a.obj", format!("{FOLDED}s 1\nf 1 2 3\nf 1 4 2\n")).unwrap();
    let mesh = &import.scene.meshes[0];
    let shared = mesh.positions.iter().position(|p| *p == Vec3::Y).unwrap();
    assert!(mesh.normals[shared].distance(vec3(-1.0, 0.0, -1.0).normalize()) <= 1e-6);

    let import = load_bytes("a.obj", format!("{FOLDED}s 1\nf 1 2 3\ns 2\nf 1 4 2\n")).unwrap();
    let normals = &import.scene.meshes[0].normals;
    assert!(normals.iter().all(|n| *n == Vec3::NEG_Z || *n == Vec3::NEG_X), "{normals:?}");

    let import =
        load_bytes("a.obj", format!("{FOLDED}vn 0 0 2\ns off\nf 1//1 2//1 3//1\nf 1 4 2\n")).unwrap();
    assert_eq!(import.scene.meshes.len(), 2);
    assert_eq!(import.scene.meshes[0].normals, [Vec3::Z; 3]);
    assert!(import.scene.meshes[1].normals.is_empty());
}

#[test]
fn polygons_negative_indices_and_continued_lines() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf -6 -5 -4 \\\n -3 -2 -1\nf 1/1\n";
    let error = load_bytes("a.obj", text).unwrap_err().to_string();
    assert!(error.contains("a.obj:9"), "{error}");
    let import = load_bytes("a.obj", text.replace("f 1/1\n", "f 1 2\n")).unwrap();
    let area: f32 = import.scene.world_triangles().map(|t| t.area()).sum();
    assert!((area - 3.0).abs() <= 1e-6);
    assert!(import.scene.world_triangles().all(|t| t.geometric_normal() == Some(Vec3::Z)));
    assert_eq!(kinds(&import), [WarningKind::Primitive, WarningKind::Approximation]);
}

#[test]
fn missing_libraries_and_materials_are_done_without() {
    let import = load_bytes("a.obj", format!("mtllib none.mtl\n{FOLDED}usemtl b\nf 1 2 3\n")).unwrap();
    assert_eq!(kinds(&import), [WarningKind::MissingFile, WarningKind::Approximation]);
    assert_eq!(import.warnings[0].place, "a.obj:1");
    assert_eq!(import.warnings[1].place, "a.obj:7");
    let surface = Surface::diffuse(Vec3::splat(0.8));
    assert_eq!(import.scene.materials[0].surface, surface);
}

#[test]
fn physical_materials() {
    let (found, warnings) = material("Kd 0.5\nPr 0.3\nPm 0.9\nPs 0.1\nPc 0.2\nPcr 0.4\naniso 0.6\nNi 1.4");
    let expected = MetallicRoughness {
        base_color: Vec3::splat(0.5).into(),
        metallic: 0.9.into(),
        roughness: 0.3.into(),
        ior: 1.4,
        clearcoat: 0.2.into(),
        clearcoat_roughness: 0.4.into(),
        sheen_color: Vec3::splat(0.1).into(),
        sheen_roughness: 0.3.into(),
        anisotropy: 0.6.into(),
        ..MetallicRoughness::default()
    };
    assert_eq!((found.surface, warnings), (Surface::MetallicRoughness(Box::new(expected)), vec![]));
}

/// Texture coordinates, options, shared files, and where files are looked for.
#[test]
fn maps() {
    let folder = Folder::new();
    folder.write("textures/a b.png", image_bytes(&[[10, 20, 30, 40]], 1, image::ImageFormat::Png));
    let library = "newmtl m\nmap_Kd -o 0.25 0.5 0 -s 2 3 1 -clamp on C:\\author\\a b.png\nmap_d a b.png\n";
    folder.write("textures/m.mtl", library);
    let text = "mtllib textures/m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nvt 1 1\nusemtl m\nf 1/1 2/2 3/3\nf 1 2 3\n";
    let import = load(&folder.write("scene.obj", text)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(kinds(&import), []);
    let scene = &import.scene;
    assert_eq!(scene.meshes.len(), 2, "with and without texture coordinates");
    assert_eq!(scene.meshes[0].uvs[0], [vec2(0.0, 1.0), vec2(1.0, 0.75), vec2(1.0, 0.0)]);
    let material = &scene.materials[0];
    let Surface::Diffuse { reflectance } = &material.surface else { panic!("not diffuse") };
    let texture = reflectance.texture.as_ref().unwrap();
    assert_eq!((reflectance.value, texture.wrap), (Vec3::ONE, [Wrap::Clamp; 2]));
    // The mesh's (0, 1) is the file's (0, 0), which lies at the file's (0.25, 0.5): half way down.
    assert!(texture.place(vec2(0.0, 1.0)).distance(vec2(0.25, 0.5)) <= 1e-6);
    assert!(texture.place(vec2(1.0, 0.0)).distance(vec2(2.25, -2.5)) <= 1e-6);
    let Opacity::Blend(alpha) = &material.opacity else { panic!("opaque") };
    assert_eq!(alpha.texture.as_ref().unwrap().1, Channel::A);
    assert_eq!(scene.images.len(), 2);
    assert!(matches!(&scene.images[0].texels, Texels::Srgb8(t) if t[..] == [[10, 20, 30, 40]]));
    let (Texels::Srgb8(a), Texels::Linear8(b)) = (&scene.images[0].texels, &scene.images[1].texels) else {
        panic!("wrong encodings");
    };
    assert!(std::sync::Arc::ptr_eq(a, b), "read twice");
}

#[test]
fn vertex_colours_are_srgb() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0 1 1 1\nv 0 1 0\nf 1 2 3\n";
    let colors = load_bytes("a.obj", text).unwrap().scene.meshes[0].colors.clone();
    assert!(colors[0].distance(vec4(1.0, 0.0, 0.214_041, 1.0)) <= 1e-5, "{colors:?}");
    assert_eq!(colors[1..], [vec4(1.0, 1.0, 1.0, 1.0); 2]);
}

#[test]
fn unused_things_are_listed_once() {
    let text = format!("{FOLDED}vp 1\nvp 2\ncurv 1\nl 1 2\np 1\nf 1 2 3\n");
    let import = load_bytes("a.obj", text).unwrap();
    use WarningKind::{Approximation, Primitive, Unused};
    assert_eq!(kinds(&import), [Unused, Unused, Primitive, Approximation]);
    assert_eq!(import.warnings[0].count, 2);
}

/// Found by fuzzing: an object's name went into a warning as it was.
#[test]
fn no_name_of_a_file_steers_the_terminal() {
    let folder = Folder::new();
    let faces = "vn 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1\n";
    let scene = folder.write("scene.obj", format!("o a\u{17}b\u{1b}[31m\n{faces}"));
    let lines: Vec<String> = load(&scene).unwrap().warnings.iter().map(ToString::to_string).collect();
    assert!(lines.iter().any(|line| line.contains("a?b?[31m: normals of length 0")), "{lines:?}");
    assert!(!lines.iter().any(|line| line.contains(char::is_control)), "{lines:?}");
}
