//! The project's own scenes, which `examples/make_scenes.rs` writes.

use std::path::{Path, PathBuf};

use midway_import::{Import, load};
use midway_scene::Surface;

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
