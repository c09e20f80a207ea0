//! Traversal through placed meshes, on both devices, against every copied triangle tried in f64.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use midway_accel::{BuildOptions, Hierarchy, Level, Placement, TwoLevel, Width, mesh_options};
use midway_tests::estimate::{cpu, gpu};

use super::traversal::{Triangle, check_packed, instance_slot, mesh, rays, slots};
use crate::support::Random;

/// Turned, scaled unevenly, moved, every other one mirrored.
fn placements(n: usize) -> Vec<Placement> {
    let mut random = Random::new(93);
    (0..n)
        .map(|i| {
            let rotation = DQuat::from_axis_angle(random.direction(), random.between(0.0, 6.0));
            let mut scale = DVec3::new(random.between(0.2, 0.5), random.between(0.2, 0.5), 0.3);
            scale.x *= if i % 2 == 1 { -1.0 } else { 1.0 };
            let moved = random.direction() * random.between(0.0, 2.5);
            let world_from_mesh = DAffine3::from_scale_rotation_translation(scale, rotation, moved);
            Placement { mesh: 0, world_from_mesh }
        })
        .collect()
}

#[test]
fn traversal_through_instances_finds_what_trying_all_copies_finds() {
    [Width::Binary, Width::Wide].into_iter().for_each(check_width);
}

fn check_width(width: Width) {
    // The ball is placed; the box and the slivers around it are the world's own.
    let all = mesh();
    let (ball, world) = all.split_at(all.len() - 62);
    let n_ball = ball.len() as u32;
    let bottom = Level::build(width, ball, &[], &mesh_options(width)).expect("built");
    let options = BuildOptions::default();
    let top = TwoLevel::build(width, world, vec![bottom], placements(5), &options).expect("built");
    let mut copies: Vec<Triangle> = world.to_vec();
    let mut first_ids = Vec::new();
    for placement in &top.placements {
        first_ids.push(copies.len() as u32);
        let place = |v: Vec3| placement.world_from_mesh.transform_point3(v.as_dvec3()).as_vec3();
        copies.extend(ball.iter().map(|t| t.map(place)));
    }
    assert_eq!(copies.len() as u32, world.len() as u32 + 5 * n_ball);
    let of_world = top.world.primitives().iter().flat_map(|&primitive| {
        let placement = (primitive as usize).checked_sub(world.len());
        let instance = placement.map(|placement| instance_slot(top.record(placement as u32)).to_vec());
        instance.unwrap_or_else(|| slots(&[primitive], world))
    });
    let packed = [of_world.collect(), slots(top.meshes[0].primitives(), ball)].concat();
    let rays = rays(&copies, 2000);
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        let n = check_packed(&*device, width, &top.nodes(&first_ids), &packed, &copies, &rays);
        assert!(n >= 1900, "only {n} of {} rays decide", rays.len());
    }
}
