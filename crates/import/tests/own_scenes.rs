//! The project's own scenes, which `examples/make_scenes` writes.

use std::path::{Path, PathBuf};

use midway_import::{Import, load};
use midway_scene::{LightKind, Opacity, Surface};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn own(name: &str) -> Import {
    let import = load(&root().join("scenes").join(name)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(import.warnings, [], "{name}");
    import
}

#[test]
fn they_load_whole() {
    let counts = own("cornell-box.gltf").scene.counts();
    assert_eq!((counts.triangles, counts.emissive_triangles, counts.cameras), (32, 2, 1));
    let counts = own("lamp.gltf").scene.counts();
    assert_eq!((counts.triangles, counts.emissive_triangles), (40, 2));
    let counts = own("glass-caustic.gltf").scene.counts();
    assert_eq!((counts.triangles, counts.emissive_triangles), (20 * 4usize.pow(5) + 12, 2));
}

#[test]
fn the_sheets_have_every_kind() {
    let materials = own("material-sheet.gltf").scene;
    // Floor, wall, two lamps, 20 balls.
    assert_eq!((materials.materials.len(), materials.counts().cameras), (24, 1));
    let has = |is: fn(&Surface) -> bool| materials.materials.iter().any(|m| is(&m.surface));
    assert!(has(|s| matches!(s, Surface::Diffuse { .. })));
    assert!(has(|s| matches!(s, Surface::Dielectric { thin: false, .. })));
    assert!(has(|s| matches!(s, Surface::MetallicRoughness(m) if m.anisotropy.value > 0.0)));
    assert!(has(|s| matches!(s, Surface::MetallicRoughness(m) if m.clearcoat.value > 0.0)));
    assert!(has(|s| matches!(s, Surface::MetallicRoughness(m) if m.sheen_color.value.max_element() > 0.0)));
    assert!(materials.materials.iter().any(|m| m.normal_map.is_some()));
    assert!(materials.materials.iter().any(|m| matches!(m.opacity, Opacity::Mask(..))));
    assert!(materials.materials.iter().any(|m| matches!(m.opacity, Opacity::Blend(..))));
    let lights = own("light-sheet.gltf").scene;
    let kinds = lights.lights.iter().map(|light| match light.kind {
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional { .. } => "directional",
    });
    assert!(kinds.eq(["point", "spot", "directional"]));
    let emissive: Vec<_> = lights.materials.iter().filter(|m| m.is_emissive()).collect();
    assert_eq!(emissive.len(), 3);
    assert_eq!(emissive.iter().filter(|m| m.emission.texture.is_some()).count(), 1);
}

#[test]
fn the_sphere_faces_outwards_and_is_glass() {
    let scene = own("glass-caustic.gltf").scene;
    let is_glass = |m: u32| {
        matches!(scene.materials[m as usize].surface, Surface::Dielectric { ior: 1.5, thin: false, .. })
    };
    let sphere: Vec<_> = scene.world_triangles().filter(|t| is_glass(t.material)).collect();
    assert_eq!(sphere.len(), 20 * 4usize.pow(5));
    for t in sphere {
        let normals = t.normals.expect("the sphere is smooth");
        let ng = t.geometric_normal().expect("no triangle is without area");
        assert!(normals.iter().all(|n| n.dot(ng) > 0.99));
    }
}

#[test]
fn they_are_the_yardstick_s() {
    let yardstick = root().join("../shared/scenes/yardstick");
    if !yardstick.is_dir() {
        println!("did not run: there is no ../shared/scenes/yardstick");
        return;
    }
    for (name, measured) in [("cornell-box.gltf", "A-cornell.gltf"), ("lamp.gltf", "C-lamp.gltf")] {
        let measured = load(&yardstick.join(measured)).unwrap();
        assert_eq!(own(name).scene.hash(), measured.scene.hash(), "{name}");
    }
    let measured = load(&yardstick.join("B-caustic.gltf")).unwrap().scene;
    let caustic = own("glass-caustic.gltf").scene;
    assert_eq!(caustic.bounds(), measured.bounds());
    assert_eq!(caustic.cameras, measured.cameras);
    assert_eq!(caustic.materials, measured.materials);
}
