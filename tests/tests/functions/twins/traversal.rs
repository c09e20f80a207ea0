//! Traversal on both devices against every triangle tried in f64.

use bytemuck::cast_slice;
use glam::{DVec3, Vec3};
use midway_accel::{BuildOptions, Width, build, build_wide};
use midway_device::Device;
use midway_kernels::{constants as k, native::lib};
use midway_tests::estimate::{cpu, gpu};

use super::{STRIDE, device};
use crate::support::{Random, double, single};

pub type Triangle = [Vec3; 3];

/// Closer to an edge than this in barycentrics, or to a segment's end relatively, f32 may decide
/// either way.
const EDGE: f64 = 1e-5;
/// A distance's error, relative to it and to the scene's size: f32 positions of a few units.
const T_TOLERANCE: f64 = 1e-4;

#[derive(Clone, Copy, Debug)]
pub struct Ray {
    origin: Vec3,
    direction: Vec3,
    /// Of the shadow segment, in directions.
    length: f32,
}

/// What a device, or the reference, says of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    hit: Option<(f64, u32)>,
    is_blocked: bool,
}

/// The reference: every triangle, in f64. None where rounding may decide.
fn try_all(triangles: &[Triangle], ray: &Ray) -> Option<Answer> {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let mut hits: Vec<(f64, u32)> = Vec::new();
    for (triangle, index) in triangles.iter().zip(0..) {
        let [a, b, c] = triangle.map(Vec3::as_dvec3);
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let determinant = e1.dot(p);
        if determinant.abs() <= 1e-5 * e1.cross(e2).length() * d.length() {
            // Edge on. It matters only if the ray comes near.
            let normal = e1.cross(e2).normalize_or_zero();
            if (o - a).dot(normal).abs() <= 1e-3 {
                return None;
            }
            continue;
        }
        let s = o - a;
        let q = s.cross(e1);
        let (u, v, t) = (s.dot(p) / determinant, d.dot(q) / determinant, e2.dot(q) / determinant);
        let inside = u.min(v).min(1.0 - u - v);
        if t > -1e-3 && inside.abs() <= EDGE {
            return None;
        }
        if inside > 0.0 && t > 0.0 {
            if (t / f64::from(ray.length) - 1.0).abs() <= EDGE {
                return None;
            }
            hits.push((t, index));
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_tie = hits.len() > 1 && hits[1].0 - hits[0].0 <= 2.0 * T_TOLERANCE * hits[1].0;
    let is_blocked = hits.first().is_some_and(|hit| hit.0 < f64::from(ray.length));
    (!is_tie).then(|| Answer { hit: hits.first().copied(), is_blocked })
}

/// The slots of a hierarchy's leaves, as kernels read them.
pub fn slots(primitives: &[u32], triangles: &[Triangle]) -> Vec<[u32; 4]> {
    let slot = |&index: &u32| {
        let [a, b, c] = triangles[index as usize];
        let word4 = |v: Vec3, w: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w];
        [word4(a, index), word4(b - a, 0), word4(c - a, 0)]
    };
    primitives.iter().flat_map(slot).collect()
}

/// The slot of an instance whose record is at a place of the nodes.
pub fn instance_slot(record: u32) -> [[u32; 4]; 3] {
    [[0, 0, 0, record], [0, 0, 0, k::SLOT_INSTANCE], [0; 4]]
}

fn trace(device: &dyn Device, nodes: &[[u32; 4]], mut slots: Vec<[u32; 4]>, rays: &[Ray]) -> Vec<Answer> {
    slots.resize(slots.len().max(k::TRIANGLE_STRIDE as usize), [0; 4]);
    let inputs: Vec<[f32; 4]> = rays
        .iter()
        .flat_map(|ray| {
            [
                ray.origin.extend(ray.length).to_array(),
                ray.direction.extend(0.0).to_array(),
                [0.0; 4],
                [0.0; 4],
            ]
        })
        .collect();
    let zeros = vec![0u32; rays.len() * STRIDE];
    let buffers: [(&str, &[u8]); 4] = [
        ("probe_in", cast_slice(&inputs)),
        ("probe_out", cast_slice(&zeros)),
        ("nodes", cast_slice(nodes)),
        ("triangles", cast_slice(&slots)),
    ];
    let outputs = device::run(device, "probe_traversal", &buffers, rays.len() as u32);
    let answer = |words: &[u32]| Answer {
        hit: (words[3] != k::NONE).then(|| (f64::from(f32::from_bits(words[0])), words[3])),
        is_blocked: f32::from_bits(words[4]) == 1.0,
    };
    outputs["probe_out"].chunks(STRIDE).map(answer).collect()
}

/// How a device's answer differs from the reference.
fn difference(actual: &Answer, expected: &Answer) -> Option<String> {
    let same_hit = match (actual.hit, expected.hit) {
        (None, None) => true,
        (Some((t, triangle)), Some((t0, triangle0))) => {
            triangle == triangle0 && (t - t0).abs() <= T_TOLERANCE * t0.max(0.01)
        }
        _ => false,
    };
    let same = same_hit && actual.is_blocked == expected.is_blocked;
    (!same).then(|| format!("{actual:?}, not {expected:?}"))
}

/// A bumpy ball of some thousands of triangles in a box of large ones, with slivers and coincident
/// triangles' neighbours: all that a hierarchy finds hard.
pub fn mesh() -> Vec<Triangle> {
    const ROWS: usize = 40;
    let mut random = Random::new(90);
    let radii: Vec<f64> = (0..=ROWS * 2 * ROWS).map(|_| random.between(0.9, 1.1)).collect();
    let vertex = |row: usize, column: usize| {
        let (theta, phi) = (
            std::f64::consts::PI * (row as f64 + 0.01) / (ROWS as f64 + 0.02),
            std::f64::consts::PI * column as f64 / ROWS as f64,
        );
        let radius = radii[row * 2 * ROWS / (ROWS + 1) + column % (2 * ROWS)];
        (DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()) * radius).as_vec3()
    };
    let mut triangles = Vec::new();
    for row in 0..ROWS {
        for column in 0..2 * ROWS {
            let [a, b] = [vertex(row, column), vertex(row, column + 1)];
            let [c, d] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let (u, v) = (Vec3::new(axis.y, axis.z, axis.x) * 3.0, Vec3::new(axis.z, axis.x, axis.y) * 3.0);
        for centre in [axis * 3.0, axis * -3.0] {
            triangles.extend([
                [centre - u - v, centre + u - v, centre + u + v],
                [centre - u - v, centre + u + v, centre - u + v],
            ]);
        }
    }
    for i in 0..50 {
        let start = Vec3::new(-2.5, -2.5 + 0.1 * i as f32, 2.0);
        triangles.push([start, start + Vec3::X * 5.0, start + Vec3::new(5.0, 0.003, 0.1)]);
    }
    triangles
}

/// Incoherent rays: from anywhere anywhere, along axes, and off surfaces.
pub fn rays(triangles: &[Triangle], n: usize) -> Vec<Ray> {
    let mut random = Random::new(91);
    let ray = |i: usize| {
        let length = random.between(0.2, 6.0) as f32;
        let anywhere = (random.direction() * random.between(0.0, 4.5)).as_vec3();
        let axis =
            [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z][random.bits() as usize % 6];
        let (origin, direction) = match i % 4 {
            0 => (anywhere, random.direction().as_vec3()),
            1 => (anywhere, axis),
            // In a coordinate plane, so that one component alone is 0.
            2 => (anywhere, (random.direction().as_vec3() * (Vec3::ONE - axis.abs())).normalize()),
            _ => off_surface(&triangles[random.bits() as usize % triangles.len()], &mut random),
        };
        Ray { origin, direction, length }
    };
    (0..n).map(ray).collect()
}

/// From a point computed on a triangle, as kernels leave surfaces.
fn off_surface([a, b, c]: &Triangle, random: &mut Random) -> (Vec3, Vec3) {
    let uv = lib::sample_triangle(random.unit2());
    let point = a + uv.x * (b - a) + uv.y * (c - a);
    let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize();
    let mut direction = random.direction();
    while direction.dot(normal).abs() < 0.1 {
        direction = random.direction();
    }
    let origin =
        lib::offset_origin(single(point.as_dvec3()), single(normal * direction.dot(normal).signum()));
    (double(origin).as_vec3(), direction.as_vec3())
}

/// Every answer that rounding does not decide is the reference's; returns how many those were.
fn check(device: &dyn Device, triangles: &[Triangle], options: &BuildOptions, rays: &[Ray]) -> usize {
    let bvh = build_wide(triangles, options).expect("built");
    bvh.validate(triangles).expect("valid");
    let nodes: Vec<[u32; 4]> = bvh.nodes.iter().flat_map(|node| node.0).collect();
    check_packed(device, Width::Wide, &nodes, &slots(&bvh.primitives, triangles), triangles, rays)
}

/// The same of nodes and slots as they are; `triangles`: all of the world's, by their ids.
pub fn check_packed(
    device: &dyn Device,
    width: Width,
    nodes: &[[u32; 4]],
    slots: &[[u32; 4]],
    triangles: &[Triangle],
    rays: &[Ray],
) -> usize {
    let answers = match width {
        Width::Binary => trace_by_bench(device, "binary", nodes, slots, rays),
        Width::Wide => trace(device, nodes, slots.to_vec(), rays),
    };
    check_answers(device, &answers, triangles, rays)
}

fn check_answers(device: &dyn Device, answers: &[Answer], triangles: &[Triangle], rays: &[Ray]) -> usize {
    assert_eq!(answers.len(), rays.len());
    let mut n_decided = 0;
    for (ray, actual) in rays.iter().zip(answers) {
        if let Some(expected) = try_all(triangles, ray) {
            n_decided += 1;
            let difference = difference(actual, &expected);
            assert!(difference.is_none(), "{}: {ray:?}: {difference:?}", device.info().name);
        }
    }
    n_decided
}

#[test]
fn traversal_finds_what_trying_all_triangles_finds() {
    let triangles = mesh();
    assert!(triangles.len() >= 6000);
    let rays = rays(&triangles, 8000);
    let devices = [Some(cpu()), gpu()];
    if let [Some(cpu), Some(gpu)] = &devices {
        assert_ne!(cpu.info().name, gpu.info().name);
    }
    for device in devices.into_iter().flatten() {
        for spatial_splits in [false, true] {
            let options = BuildOptions { spatial_splits, ..Default::default() };
            let n = check(&*device, &triangles, &options, &rays);
            assert!(n as f64 >= 0.97 * rays.len() as f64, "only {n} of {} rays decide", rays.len());
        }
    }
}

/// The binary hierarchy by both of its kernels, and the wide one by those of `bench rays`: 2000 rays are no
/// multiple of the 512 that a group of the last takes.
#[test]
fn measured_traversals_find_what_trying_all_triangles_finds() {
    let triangles = mesh();
    let rays = rays(&triangles, 2000);
    let options = BuildOptions::default();
    let binary = build(&triangles, &options).expect("built");
    let wide = build_wide(&triangles, &options).expect("built");
    let wide_nodes = wide.nodes.iter().flat_map(|node| node.0).collect();
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        for (kind, nodes, primitives) in [
            ("binary", &binary.nodes, &binary.primitives),
            ("speculative", &binary.nodes, &binary.primitives),
            ("wide", &wide_nodes, &wide.primitives),
            ("refilled", &wide_nodes, &wide.primitives),
        ] {
            let slots = slots(primitives, &triangles);
            let answers = trace_by_bench(&*device, kind, nodes, &slots, &rays);
            let n = check_answers(&*device, &answers, &triangles, &rays);
            assert!(n as f64 >= 0.97 * rays.len() as f64, "only {n} of {} rays decide", rays.len());
        }
    }
}

fn trace_by_bench(
    device: &dyn Device,
    kind: &str,
    nodes: &[[u32; 4]],
    slots: &[[u32; 4]],
    rays: &[Ray],
) -> Vec<Answer> {
    let run = |question: &str, t_max: fn(&Ray) -> f32| {
        let input = |ray: &Ray| [ray.origin.extend(t_max(ray)), ray.direction.extend(0.0)];
        let input: Vec<glam::Vec4> = rays.iter().flat_map(input).collect();
        let zeros = vec![0u32; rays.len() * 4];
        let buffers: [(&str, &[u8]); 4] = [
            ("rays", cast_slice(&input)),
            ("hits", cast_slice(&zeros)),
            ("nodes", cast_slice(nodes)),
            ("triangles", cast_slice(slots)),
        ];
        let kernel = format!("bench_{question}_{kind}");
        device::run(device, &kernel, &buffers, rays.len() as u32)["hits"].clone()
    };
    let (closest, any) = (run("closest", |_| f32::MAX), run("any", |ray| ray.length));
    let answer = |(closest, any): (&[u32], &[u32])| Answer {
        hit: (closest[3] != k::NONE).then(|| (f64::from(f32::from_bits(closest[0])), closest[3])),
        is_blocked: any[3] != k::NONE,
    };
    closest.chunks(4).zip(any.chunks(4)).map(answer).collect()
}

#[test]
fn traversal_of_nothing_and_of_one_triangle() {
    let one = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        for triangles in [&[][..], &one[..]] {
            let rays = rays(&one, 500);
            let n = check(&*device, triangles, &BuildOptions::default(), &rays);
            assert!(n >= 480, "only {n} of 500 rays decide");
        }
    }
}

#[test]
fn wrong_answers_are_seen() {
    let right = Answer { hit: Some((1.0, 7)), is_blocked: true };
    assert!(difference(&right, &right).is_none());
    for wrong in [
        Answer { hit: None, ..right },
        Answer { hit: Some((1.001, 7)), ..right },
        Answer { hit: Some((1.0, 8)), ..right },
        Answer { hit: Some((f64::NAN, 7)), ..right },
        Answer { is_blocked: false, ..right },
    ] {
        assert!(difference(&wrong, &right).is_some(), "{wrong:?}");
    }
}
