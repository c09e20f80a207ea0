//! Placed meshes are met as if their triangles were copied.

mod common;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use midway_accel::{
    BuildOptions, Bvh, Child, Hierarchy, Hit, Level, Placement, TwoLevel, WideBvh, WideNode, Width,
    build_wide, closest_hit, mesh_options,
};

use common::{Random, Triangles, inputs, soup};

const WIDTHS: [Width; 2] = [Width::Binary, Width::Wide];

/// Turned, scaled unevenly, moved, every other one mirrored.
fn placements(n: usize, n_meshes: u32, reach: f32, seed: u64) -> Vec<Placement> {
    let mut random = Random(seed);
    (0..n as u32)
        .map(|i| {
            let axis = random.point(2.0).as_dvec3().normalize_or(DVec3::X);
            let rotation = DQuat::from_axis_angle(axis, f64::from(random.unit()) * 6.0);
            let mut scale = DVec3::ONE + random.point(1.0).as_dvec3();
            if i % 2 == 1 {
                scale.y = -scale.y;
            }
            let moved = random.point(reach).as_dvec3();
            let world_from_mesh = DAffine3::from_scale_rotation_translation(scale, rotation, moved);
            Placement { mesh: i % n_meshes, world_from_mesh }
        })
        .collect()
}

fn two_level(width: Width, world: &Triangles, meshes: &[Triangles], placements: Vec<Placement>) -> TwoLevel {
    let bvhs = meshes.iter().map(|m| Level::build(width, m, &[], &mesh_options(width)).unwrap()).collect();
    TwoLevel::build(width, world, bvhs, placements, &BuildOptions::default()).unwrap()
}

/// The world's own triangles, then those of each placement.
fn flattened(world: &Triangles, meshes: &[Triangles], placements: &[Placement]) -> Triangles {
    let mut all = world.clone();
    for p in placements {
        let place = |v: Vec3| p.world_from_mesh.transform_point3(v.as_dvec3()).as_vec3();
        all.extend(meshes[p.mesh as usize].iter().map(|t| t.map(place)));
    }
    all
}

/// A ray through the inside of a triangle: at edges rounding decides.
fn inner_ray(triangles: &[[Vec3; 3]], random: &mut Random) -> (Vec3, Vec3) {
    let pick = (random.unit() * triangles.len() as f32) as usize;
    let [a, b, c] = triangles[pick.min(triangles.len() - 1)];
    let (u, v) = (0.05 + 0.4 * random.unit(), 0.05 + 0.4 * random.unit());
    let target = a + u * (b - a) + v * (c - a);
    let direction = random.point(2.0);
    (target - 3.0 * direction, direction)
}

#[test]
fn placed_meshes_are_met_as_if_they_were_copied() {
    WIDTHS.into_iter().for_each(placed_meshes_are_met);
}

fn placed_meshes_are_met(width: Width) {
    let meshes = [soup(300, 0.2, 1.0, 1), soup(40, 0.5, 1.0, 2)];
    let world = soup(200, 0.3, 6.0, 3);
    let two_level = two_level(width, &world, &meshes, placements(40, 2, 6.0, 4));
    let all = flattened(&world, &meshes, &two_level.placements);
    let flat = build_wide(&all, &BuildOptions::default()).unwrap();
    let first = |placement: usize| -> usize {
        let before = two_level.placements[..placement].iter();
        world.len() + before.map(|p| meshes[p.mesh as usize].len()).sum::<usize>()
    };
    let mut random = Random(5);
    let (mut n_placed, mut n_hits, mut n_decided_by_rounding) = (0, 0, 0);
    for _ in 0..4000 {
        let (origin, dir) = inner_ray(&all, &mut random);
        let vertices = |mesh: u32, t: u32| meshes[mesh as usize][t as usize];
        let found = two_level.closest_hit(&world, vertices, origin, dir, f32::MAX);
        let expected = closest_hit(&flat, &all, origin, dir, f32::MAX);
        let id = |h: &Hit| h.triangle as usize + h.placement.map_or(0, |p| first(p as usize));
        n_placed += usize::from(found.is_some_and(|h| h.placement.is_some()));
        n_hits += usize::from(expected.is_some());
        let same = match (found, expected) {
            (Some(a), Some(b)) => id(&a) == id(&b) && (a.t - b.t).abs() <= 1e-4 * b.t.max(1.0),
            (a, b) => a.is_none() && b.is_none(),
        };
        n_decided_by_rounding += usize::from(!same);
    }
    assert!(n_hits > 2000 && n_placed > 1000, "{n_hits} hits, {n_placed} of placed meshes");
    // Rounding decides of a few whether they meet an edge.
    assert!(n_decided_by_rounding <= 20, "{n_decided_by_rounding} of 4000 rays differ");
}

#[test]
fn degenerate_meshes_can_be_placed() {
    let all = WIDTHS.into_iter().flat_map(|width| inputs().into_iter().map(move |input| (width, input)));
    for (width, (name, mesh)) in all {
        // Nothing larger than f32 holds can be placed in it.
        if ["huge", "largest"].contains(&name) {
            continue;
        }
        let reach = if name == "tiny" { 1e-37 } else { 1e3 };
        let meshes = [mesh];
        let two_level = two_level(width, &soup(20, 1.0, 5.0, 1), &meshes, placements(30, 1, reach, 2));
        two_level.meshes[0].validate_with_instances(&meshes[0], &[]).unwrap();
        let bounds = two_level.placement_bounds();
        two_level.world.validate_with_instances(&soup(20, 1.0, 5.0, 1), &bounds).unwrap();
        let levels = two_level.world.max_depth() + two_level.meshes[0].max_depth();
        assert!(levels + 3 <= width.stack_size(), "{name}: {levels} levels");
        for (p, bounds) in two_level.placements.iter().zip(&bounds) {
            for v in flattened(&vec![], &meshes, &[*p]).as_flattened() {
                assert!(bounds.contains_point(*v), "{name}: {v} is not in {bounds:?}");
            }
        }
    }
}

#[test]
fn many_placements_at_one_place_are_no_deeper_than_a_stack() {
    let meshes = [soup(1000, 0.1, 1.0, 1)];
    let at_once = vec![placements(1, 1, 1.0, 1)[0]; 3000];
    for width in WIDTHS {
        let two_level = two_level(width, &vec![], &meshes, at_once.clone());
        assert!(two_level.world.max_depth() + two_level.meshes[0].max_depth() + 3 <= width.stack_size());
        two_level.world.validate_with_instances(&[], &two_level.placement_bounds()).unwrap();
    }
}

/// Every reference among all nodes leads to where the two levels say.
#[test]
fn nodes_of_all_levels_lie_together() {
    WIDTHS.into_iter().for_each(nodes_lie_together);
}

fn nodes_lie_together(width: Width) {
    let meshes = [soup(300, 0.2, 1.0, 1), soup(40, 0.5, 1.0, 2)];
    let world = soup(100, 0.3, 6.0, 3);
    let two_level = two_level(width, &world, &meshes, placements(10, 2, 6.0, 4));
    let first_ids: Vec<u32> = (0..10).map(|i| 1000 * i).collect();
    let words = two_level.nodes(&first_ids);
    let n_nodes: usize = two_level.slots().map(Level::n_nodes).sum();
    let (nodes, records) = words.split_at(width.node_vec4() * n_nodes);
    assert_eq!(records.len(), 4 * 10);
    let all = match two_level.world.clone() {
        Level::Binary(world) => Level::Binary(Bvh { nodes: nodes.to_vec(), ..world }),
        Level::Wide(world) => {
            let nodes = nodes.chunks_exact(WideNode::VEC4).map(|node| WideNode(node.try_into().unwrap()));
            Level::Wide(WideBvh { nodes: nodes.collect(), ..world })
        }
    };
    let (mut first_node, mut first_slot) = (0, 0);
    let mut roots = Vec::new();
    for bvh in two_level.slots() {
        roots.push(first_node);
        for node in 0..bvh.n_nodes() as u32 {
            let together = all.children(first_node + node);
            assert_eq!(bvh.children(node).count(), all.children(first_node + node).count());
            for (own, together) in bvh.children(node).zip(together) {
                let expected = match own.1 {
                    Child::Inner(inner) => Child::Inner(first_node + inner),
                    Child::Leaf { first, count } => Child::Leaf { first: first_slot + first, count },
                };
                assert_eq!((own.0, expected), together);
            }
        }
        first_node += bvh.n_nodes() as u32;
        first_slot += bvh.primitives().len() as u32;
    }
    for (i, placement) in (0..).zip(&two_level.placements) {
        let record = &words[two_level.record(i) as usize..];
        assert_eq!(record[3][..2], [roots[placement.mesh as usize + 1], first_ids[i as usize]]);
    }
}

/// `validate_with_instances` has to fail on each kind of damage.
#[test]
fn validate_finds_damaged_instances() {
    let meshes = [soup(40, 0.5, 1.0, 2)];
    for width in WIDTHS {
        let two_level = two_level(width, &vec![], &meshes, placements(10, 1, 6.0, 4));
        let bounds = two_level.placement_bounds();
        two_level.world.validate_with_instances(&[], &bounds).unwrap();
        assert!(two_level.world.validate_with_instances(&[], &bounds[..9]).is_err(), "one too many");
        let more = [bounds.clone(), vec![bounds[0]]].concat();
        assert!(two_level.world.validate_with_instances(&[], &more).is_err(), "one is missing");
        let mut grown = bounds.clone();
        grown[3].max += Vec3::X;
        assert!(two_level.world.validate_with_instances(&[], &grown).is_err(), "one sticks out");
    }
}
