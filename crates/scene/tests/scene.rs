//! What the rest of the program relies on.

use std::f32::consts::PI;

use glam::{Mat4, Quat, Vec3, vec3};
use midway_scene::{
    Bounds, Camera, Channel, ColorInput, Image, Instance, Material, Mesh, Opacity, Projection, Roughness,
    ScalarInput, Scene, SceneError, Surface, Texels, Texture,
};

fn triangle() -> Mesh {
    Mesh {
        name: "triangle".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    }
}

fn scene() -> Scene {
    Scene {
        cameras: vec![Camera::look_at(Vec3::ONE, Vec3::ZERO, Vec3::Y, 1.0).unwrap()],
        meshes: vec![triangle()],
        instances: vec![Instance { mesh: 0, world_from_mesh: Mat4::IDENTITY, light_group: None }],
        materials: vec![Material::new(Surface::diffuse(Vec3::splat(0.5)))],
        ..Scene::default()
    }
}

type Damage = (&'static str, fn(&mut Scene));

#[test]
fn validate_finds_each_kind_of_damage() {
    scene().validate().unwrap();
    let damages: Vec<Damage> = vec![
        ("no triangles", |s| s.instances.clear()),
        ("vertex", |s| s.meshes[0].triangles[0][1] = 3),
        ("material", |s| s.meshes[0].material = 1),
        ("mesh", |s| s.instances[0].mesh = 1),
        ("nan", |s| s.meshes[0].positions[1].y = f32::NAN),
        ("infinite", |s| s.meshes[0].positions[1].y = f32::INFINITY),
        ("normals", |s| drop(s.meshes[0].normals.drain(1..))),
        ("zero normal", |s| s.meshes[0].normals[0] = Vec3::ZERO),
        ("nan normal", |s| s.meshes[0].normals[0].x = f32::NAN),
        ("flattened", |s| s.instances[0].world_from_mesh = Mat4::from_scale(vec3(1.0, 0.0, 1.0))),
        ("projective", |s| s.instances[0].world_from_mesh.x_axis.w = 1.0),
        ("overflow", |s| {
            s.instances[0].world_from_mesh = Mat4::from_scale(Vec3::splat(3e38));
            s.meshes[0].positions[1].x = 2.0;
        }),
        ("emission", |s| s.materials[0].emission.value.x = -1.0),
        ("infinite emission", |s| s.materials[0].emission.value.x = f32::INFINITY),
        ("reflectance", |s| s.materials[0].surface = Surface::diffuse(Vec3::splat(1.1))),
        ("mirror", |s| s.materials[0].surface = Surface::mirror(Vec3::NAN)),
        ("ior", |s| s.materials[0].surface = glass(0.0, 1.0, 0.0)),
        ("dispersion", |s| {
            s.materials[0].surface = glass(1.5, 1.0, 0.0);
            let Surface::Dielectric { dispersion, .. } = &mut s.materials[0].surface else { unreachable!() };
            *dispersion = 41.0;
        }),
        ("tint", |s| s.materials[0].surface = glass(1.5, -0.1, 0.0)),
        ("sigma_a", |s| s.materials[0].surface = glass(1.5, 1.0, f32::INFINITY)),
        ("yfov", |s| s.cameras[0].projection = Projection::Perspective { yfov: PI }),
        ("nan yfov", |s| s.cameras[0].projection = Projection::Perspective { yfov: f32::NAN }),
        ("aspect", |s| s.cameras[0].aspect = Some(0.0)),
        ("scaled camera", |s| s.cameras[0].world_from_camera *= Mat4::from_scale(Vec3::splat(2.0))),
        ("nan camera", |s| s.cameras[0].world_from_camera.w_axis.x = f32::NAN),
    ];
    for (name, damage) in damages {
        let mut damaged = scene();
        damage(&mut damaged);
        let error = damaged.validate().expect_err(name);
        assert!(!error.to_string().contains('\n'), "{name}: {error}");
    }
}

fn glass(ior: f32, tint: f32, sigma_a: f32) -> Surface {
    Surface::Dielectric {
        ior,
        dispersion: 0.0,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::splat(tint).into(),
        sigma_a: Vec3::splat(sigma_a),
        thin: false,
        roughness: Roughness::smooth(),
    }
}

#[test]
fn factors_of_textures_may_exceed_1() {
    let mut scene = scene();
    let texels = Texels::Linear8([[60; 4]].into());
    scene.images.push(Image { name: String::new(), width: 1, height: 1, texels });
    let reflectance = ColorInput { value: Vec3::splat(4.0), texture: Some(Texture::new(0)) };
    scene.materials[0].surface = Surface::Diffuse { reflectance };
    scene.materials[0].opacity =
        Opacity::Blend(ScalarInput { value: 4.0, texture: Some((Texture::new(0), Channel::R)) });
    scene.validate().unwrap();
    scene.materials[0].opacity = Opacity::Blend(4.0.into());
    scene.validate().unwrap_err();
}

/// Whether alone or with another at the other end.
#[test]
fn a_scene_that_is_too_large_is_said_to_be() {
    for far in [1e19, 1e38, 3e38, -1e38] {
        for near in [0.0, -far] {
            let mut scene = scene();
            scene.meshes[0].positions[1] = vec3(far, 0.0, 0.0);
            scene.meshes[0].positions[2] = vec3(near, 1.0, 0.0);
            let line = scene.validate().unwrap_err().to_string();
            assert!(line.contains("the scene") && line.contains("from its origin"), "{far}: {line}");
        }
    }
    let mut scene = scene();
    scene.meshes[0].positions[1].x = 1e17;
    scene.validate().unwrap();
}

#[test]
fn errors_name_what_is_wrong() {
    let mut damaged = scene();
    damaged.meshes[0].triangles[0][1] = 7;
    let error = damaged.validate().unwrap_err();
    assert!(matches!(&error, SceneError::IndexOutOfRange { index: 7, len: 3, .. }));
    assert_eq!(error.to_string(), "mesh 0 (\"triangle\") refers to vertex 7, of which there are 3");
}

#[test]
fn mirroring_keeps_the_front_and_the_normals_agree_with_it() {
    let mut s = scene();
    let turned = Mat4::from_scale_rotation_translation(
        vec3(2.0, 0.5, 1e-3),
        Quat::from_rotation_x(0.7),
        vec3(5.0, 6.0, 7.0),
    );
    for matrix in [turned, turned * Mat4::from_scale(vec3(-1.0, 1.0, 1.0))] {
        s.instances[0].world_from_mesh = matrix;
        let t = s.world_triangles().next().unwrap();
        let ng = t.geometric_normal().unwrap();
        for n in t.normals.unwrap() {
            assert!(n.distance(ng) <= 1e-5, "{n} against {ng}");
        }
        // The front of the mesh faces +z, which both matrices keep.
        assert!(ng.dot(matrix.transform_vector3(Vec3::Z)) > 0.0);
        assert!((t.area() - 0.5).abs() <= 1e-5);
    }
}

#[test]
fn bounds_and_counts_are_of_the_world() {
    let mut s = scene();
    s.materials[0].emission = Vec3::X.into();
    let moved = Mat4::from_translation(vec3(10.0, 0.0, 0.0));
    s.instances.push(Instance { mesh: 0, world_from_mesh: moved, light_group: None });
    assert_eq!(s.bounds(), Bounds { min: Vec3::ZERO, max: vec3(11.0, 1.0, 0.0) });
    let counts = s.counts();
    assert_eq!((counts.triangles, counts.emissive_triangles, counts.meshes), (2, 2, 1));
    assert!(Scene::default().bounds().is_empty());
}

/// A million triangles, a million times: what only sums them up must not visit them.
#[test]
fn instances_of_large_meshes_are_not_visited() {
    let mut s = scene();
    s.meshes[0].triangles = vec![[0, 1, 2]; 1 << 20];
    let turned = Mat4::from_scale_rotation_translation(
        vec3(2.0, 1.0, -1.0),
        Quat::from_rotation_y(0.7),
        vec3(5.0, 6.0, 7.0),
    );
    s.instances = vec![Instance { mesh: 0, world_from_mesh: turned, light_group: None }; 1 << 20];
    s.validate().unwrap();
    assert_eq!(s.counts().triangles, 1 << 40);
    let bounds = s.bounds();
    for p in [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| turned.transform_point3(p)) {
        assert!(bounds.contains_point(p));
    }
    assert!(bounds.diagonal().length() <= 6.0, "{bounds:?}");
    s.instances[77].world_from_mesh = Mat4::from_scale(Vec3::splat(3.1e38));
    s.meshes[0].positions[1].x = 2.0;
    assert!(s.validate().is_err());
}

#[test]
fn hash_follows_content_and_not_names() {
    let original = scene().hash();
    assert_eq!(original.len(), 64);
    let mut renamed = scene();
    renamed.meshes[0].name = "other".to_owned();
    assert_eq!(renamed.hash(), original);
    let changes: Vec<Damage> = vec![
        ("position", |s| s.meshes[0].positions[2].x = 1e-7),
        ("order", |s| s.meshes[0].triangles[0] = [1, 2, 0]),
        ("emission", |s| s.materials[0].emission.value.z = 1.0),
        ("surface", |s| s.materials[0].surface = Surface::mirror(Vec3::splat(0.5))),
        ("camera", |s| s.cameras[0].projection = Projection::Perspective { yfov: 1.1 }),
        ("instance", |s| s.instances.push(s.instances[0].clone())),
    ];
    for (name, change) in changes {
        let mut changed = scene();
        change(&mut changed);
        assert_ne!(changed.hash(), original, "{name}");
    }
}

#[test]
fn framing_shows_all_of_the_bounds() {
    let boxes = [
        (vec3(-1.0, -2.0, -3.0), vec3(4.0, 5.0, 6.0)),
        (Vec3::ZERO, vec3(10.0, 0.1, 0.1)),
        (Vec3::ZERO, vec3(0.0, 0.0, 5.0)),
        (Vec3::splat(1e6), Vec3::splat(1e6)),
        (Vec3::splat(-1e30), Vec3::splat(1e30)),
    ];
    for (min, max) in boxes {
        for aspect in [0.5, 1.0, 2.0] {
            let camera = Camera::framing(&Bounds { min, max }, aspect);
            let camera_from_world = camera.world_from_camera.inverse();
            for corner in 0..8 {
                let pick = |axis: usize| if corner >> axis & 1 == 0 { min } else { max }[axis];
                let p = camera_from_world.transform_point3(vec3(pick(0), pick(1), pick(2)));
                let half = -p.z * (camera.yfov().unwrap() * 0.5).tan();
                assert!(p.z < 0.0 && p.y.abs() <= half && p.x.abs() <= half * aspect, "{min} {max}");
            }
            let framed = Scene { cameras: vec![camera], ..scene() };
            framed.validate().unwrap();
        }
    }
    Camera::framing(&Bounds::EMPTY, f32::NAN);
}

#[test]
fn look_at_is_rigid_or_refused() {
    for up in [Vec3::Y, Vec3::Z, Vec3::ZERO, vec3(0.0, 0.0, 1.0)] {
        let camera = Camera::look_at(vec3(0.0, 0.0, 5.0), Vec3::ZERO, up, 1.0).unwrap();
        let forward = camera.world_from_camera.transform_vector3(Vec3::NEG_Z);
        assert!(forward.distance(Vec3::NEG_Z) <= 1e-6);
        Scene { cameras: vec![camera], ..scene() }.validate().unwrap();
    }
    assert!(Camera::look_at(Vec3::ONE, Vec3::ONE, Vec3::Y, 1.0).is_err());
    assert!(Camera::look_at(Vec3::NAN, Vec3::ONE, Vec3::Y, 1.0).is_err());
    assert!(Camera::look_at(Vec3::ZERO, Vec3::ONE, Vec3::Y, 0.0).is_err());
}
