//! Points on surfaces as kernels load them, against the host's triangles.

use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{DVec3, EulerRot, Mat4, Quat, Vec2, Vec3, Vec4};
use midway_device::{Device, DeviceKind};
use midway_kernels::layout::Params;
use midway_render::{PackedScene, RenderSettings};
use midway_scene::{Instance, Mesh, Scene, WorldTriangle};
use midway_tests::{
    estimate::{cpu, gpu},
    shapes::{Shape, add, camera, diffuse},
};

use super::{STRIDE, device};
use crate::support::Random;

/// f32, over coordinates of some units.
const POSITION_TOLERANCE: f64 = 1e-5;
/// Normals and tangents are packed to 1e-4 radians at each vertex.
const DIRECTION_TOLERANCE: f64 = 3e-4;
/// Colours are halves.
const COLOR_TOLERANCE: f64 = 1e-3;

/// A ball with everything that a mesh can have, placed so often that it is not baked; and a copy that
/// is there once and is, with neither tangents nor normals.
fn scene() -> Scene {
    let shape = Shape::icosphere(5, Vec3::ZERO, 1.0).smooth(Vec3::ZERO);
    let direction = |p: &Vec3| p.any_orthonormal_vector();
    let ball = Mesh {
        uvs: [
            shape.positions.iter().map(|p| Vec2::new(p.x + 0.3 * p.z, p.y - 0.2 * p.z)).collect(),
            shape.positions.iter().map(|p| Vec2::new(p.y, p.z) * 7.0).collect(),
        ],
        colors: shape.positions.iter().map(|p| (*p * 0.5 + 0.5).extend(0.25 + 0.5 * p.x.abs())).collect(),
        tangents: shape.positions.iter().map(|p| direction(p).extend(-1.0)).collect(),
        positions: shape.positions,
        normals: shape.normals,
        triangles: shape.triangles,
        material: 1,
        ..Mesh::default()
    };
    let plain = Mesh { tangents: vec![], normals: vec![], colors: vec![], ..ball.clone() };
    let mut scene = Scene::default();
    add(&mut scene, Shape::parallelogram(Vec3::ZERO, Vec3::X, Vec3::Y), diffuse(Vec3::ONE, Vec3::ONE));
    scene.materials.push(diffuse(Vec3::splat(0.5), Vec3::ZERO));
    let instance = |mesh: u32, i: usize| {
        let side = if i % 2 == 1 { -1.0 } else { 1.0 };
        let scale = Vec3::new(0.5 + 0.1 * i as f32, side, 1.5);
        let turn = Quat::from_euler(EulerRot::XYZ, i as f32, 0.3, 0.1 * i as f32);
        let world_from_mesh = Mat4::from_scale_rotation_translation(scale, turn, Vec3::X * i as f32);
        Instance { mesh, world_from_mesh, light_group: None }
    };
    scene.meshes.extend([ball, plain]);
    scene.instances.extend((0..15).map(|i| instance(1, i)));
    scene.instances.extend([instance(2, 3)]);
    scene.cameras.push(camera(Vec3::Z * 9.0, Vec3::ZERO, 60.0));
    scene
}

/// What a kernel loads: the words of both outputs.
fn load(device: &dyn Device, packed: &PackedScene, points: &[(u32, f32, f32)]) -> Vec<[Vec<f32>; 2]> {
    let params = Params {
        surfaces_at: packed.surfaces_at,
        instances_at: packed.instances_at,
        n_baked: packed.n_baked,
        n_instances: packed.n_instances,
        ..Zeroable::zeroed()
    };
    let outputs = [0.0, 1.0].map(|attributes: f32| {
        let mut inputs = vec![[0u32; 4]; points.len() * STRIDE / 4];
        for (input, &(id, u, v)) in inputs.chunks_exact_mut(STRIDE / 4).zip(points) {
            input[0] = [id, u.to_bits(), v.to_bits(), attributes.to_bits()];
        }
        let zeros = vec![0u32; points.len() * STRIDE];
        let buffers: [(&str, &[u8]); 4] = [
            ("params", bytes_of(&params)),
            ("scene", cast_slice(&packed.scene)),
            ("probe_in", cast_slice(&inputs)),
            ("probe_out", cast_slice(&zeros)),
        ];
        device::run(device, "probe_surface", &buffers, points.len() as u32)["probe_out"].clone()
    });
    let floats = |words: &[u32]| -> Vec<f32> { words.iter().map(|&w| f32::from_bits(w)).collect() };
    let [geometry, attributes] = outputs;
    geometry.chunks(STRIDE).zip(attributes.chunks(STRIDE)).map(|(a, b)| [floats(a), floats(b)]).collect()
}

fn vector(words: &[f32]) -> DVec3 {
    DVec3::new(words[0].into(), words[1].into(), words[2].into())
}

#[track_caller]
fn near(actual: DVec3, expected: DVec3, tolerance: f64, what: &str) {
    let error = actual.distance(expected);
    assert!(error <= tolerance, "{what}: {actual}, not {expected}: off by {error:e}");
}

/// The same point, by the host. `u` and `v` are of the mesh's own order of vertices, which a mirrored
/// triangle of the world has exchanged where its instance is placed and not baked.
fn check(t: &WorldTriangle, u: f32, v: f32, [geometry, attributes]: &[Vec<f32>; 2]) {
    let weights = [1.0 - u - v, u, v].map(f64::from);
    let blend = |values: [DVec3; 3]| (0..3).map(|i| values[i] * weights[i]).sum::<DVec3>();
    let [a, b, c] = t.positions.map(Vec3::as_dvec3);
    near(vector(geometry), blend([a, b, c]), POSITION_TOLERANCE, "position");
    let ng = (b - a).cross(c - a).normalize();
    near(vector(&geometry[4..]), ng, 1e-4, "geometric normal");
    let ns = t.normals.map_or(ng, |normals| blend(normals.map(Vec3::as_dvec3)).normalize());
    let ns = if ns.dot(ng) < 0.0 { -ns } else { ns };
    near(vector(&geometry[8..]), ns, DIRECTION_TOLERANCE, "shading normal");
    assert_eq!(geometry[3].to_bits(), t.material);

    let uv = |set: usize| {
        let [a, b, c] = t.uvs[set].map(Vec2::as_dvec2);
        a * weights[0] + b * weights[1] + c * weights[2]
    };
    for (set, at) in [(0, 4), (1, 6)] {
        let actual = glam::DVec2::new(attributes[at].into(), attributes[at + 1].into());
        assert!(actual.distance(uv(set)) <= 1e-5, "uv {set}: {actual}, not {}", uv(set));
    }
    let color = |i: usize| t.colors.map_or(Vec4::ONE, |colors| colors[i]).as_dvec4();
    let expected = color(0) * weights[0] + color(1) * weights[1] + color(2) * weights[2];
    for (i, expected) in expected.to_array().into_iter().enumerate() {
        assert!((f64::from(attributes[i]) - expected).abs() <= COLOR_TOLERANCE, "colour {i}");
    }

    let tangent = vector(&geometry[12..]);
    let (along, sign) = expected_tangent(t, blend);
    assert!((tangent.length() - 1.0).abs() <= 1e-5 && tangent.dot(ns).abs() <= DIRECTION_TOLERANCE);
    let across = along - ns * along.dot(ns);
    // Where the direction is nearly the normal's, rounding turns it.
    if across.length() > 0.05 * along.length() {
        near(tangent, across.normalize(), 20.0 * DIRECTION_TOLERANCE, "tangent");
    }
    assert_eq!(f64::from(geometry[7]), sign, "the bitangent's sign");
}

/// Not orthogonal to anything; and the sign by which cross(n, t) points up in the image.
fn expected_tangent(t: &WorldTriangle, blend: impl Fn([DVec3; 3]) -> DVec3) -> (DVec3, f64) {
    if let Some(tangents) = t.tangents {
        return (blend(tangents.map(|t| t.truncate().as_dvec3())), tangents[0].w.into());
    }
    // p = p0 + dp/du (u - u0) + dp/dv (v - v0) at all three vertices.
    let [a, b, c] = t.positions.map(Vec3::as_dvec3);
    let [p, q, r] = t.uvs[0].map(Vec2::as_dvec2);
    let inverse = glam::DMat2::from_cols(q - p, r - p).inverse();
    let (e1, e2) = (b - a, c - a);
    let along_u = e1 * inverse.x_axis.x + e2 * inverse.x_axis.y;
    let along_v = e1 * inverse.y_axis.x + e2 * inverse.y_axis.y;
    let ng = e1.cross(e2);
    (along_u, if ng.cross(along_u).dot(-along_v) > 0.0 { 1.0 } else { -1.0 })
}

#[test]
fn surfaces_are_the_hosts_placed_and_mirrored_ones_too() {
    let scene = scene();
    let packed = PackedScene::new(&scene, &scene.cameras[0], &RenderSettings::default(), DeviceKind::Cpu)
        .expect("packed");
    assert_eq!(packed.n_instances, 15);
    let world: Vec<WorldTriangle> = scene.world_triangles().collect();
    // Baked: the lamp and the plain ball, the first and the last of the world's order.
    let n_ball = scene.meshes[1].triangles.len() as u32;
    assert_eq!(packed.n_baked, 2 + n_ball);
    let n_placed = 15 * n_ball;
    let world_index = |id: u32| match id {
        0..2 => id,
        _ if id < packed.n_baked => n_placed + id,
        _ => id - n_ball,
    };
    let mut random = Random::new(94);
    let points: Vec<(u32, f32, f32)> = (0..4000)
        .map(|i| {
            let n = if i % 4 == 0 { packed.n_baked } else { packed.n_baked + n_placed };
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            ((random.bits() % u64::from(n)) as u32, u, v)
        })
        .collect();
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        for (&(id, u, v), loaded) in points.iter().zip(load(&*device, &packed, &points)) {
            let triangle = &world[world_index(id) as usize];
            let linear = scene.instances[triangle.instance as usize].world_from_mesh;
            let exchanged = id >= packed.n_baked && linear.determinant() < 0.0;
            let (u, v) = if exchanged { (v, u) } else { (u, v) };
            check(triangle, u, v, &loaded);
        }
    }
}
