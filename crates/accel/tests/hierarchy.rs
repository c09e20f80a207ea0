//! The same inputs, degenerate ones among them, through every preset.

mod common;

use glam::Vec3;
use midway_accel::{
    AccelError, BuildOptions, Bvh, Child, Hierarchy, Hit, MAX_LEAF_SIZE, Quality, STACK_SIZE,
    WIDE_BALANCED_DEPTH, WIDE_STACK_SIZE, WideBvh, build, build_wide, closest_hit,
};

use common::{Random, inputs, ray, slivers, soup};

fn presets() -> Vec<BuildOptions> {
    let mut all = Vec::new();
    for quality in [Quality::Fast, Quality::Balanced, Quality::Best] {
        for spatial_splits in [false, true] {
            for max_leaf_size in [0, 1, 4, MAX_LEAF_SIZE, 1000] {
                all.push(BuildOptions { spatial_splits, quality, max_leaf_size, ..BuildOptions::default() });
            }
        }
    }
    all
}

/// Where the cheapest wide hierarchy would be deeper, a balanced one is built.
#[test]
fn wide_hierarchies_are_no_deeper_than_asked() {
    let mut n_balanced = 0;
    // Each twice as far out as the one before: the cheapest hierarchy splits off a few at a time.
    let spread = (0..120).map(|i| {
        let at = Vec3::splat((i as f32 - 60.0).exp2());
        [at, at + Vec3::X * at.x, at + Vec3::Y * at.x]
    });
    for (name, triangles) in inputs().into_iter().chain([("spread", spread.collect())]) {
        let options = BuildOptions { max_depth: 1, ..BuildOptions::default() };
        let wide = build_wide(&triangles, &options).unwrap();
        wide.validate(&triangles).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(wide.max_depth <= WIDE_BALANCED_DEPTH, "{name}: {} levels", wide.max_depth);
        n_balanced += usize::from(wide.statistics.balanced_fallback);
    }
    assert!(n_balanced > 0, "none had to be balanced");
}

#[test]
fn every_input_is_valid_with_every_preset() {
    for (name, triangles) in inputs() {
        for options in presets() {
            let bvh = build(&triangles, &options).unwrap();
            bvh.validate(&triangles).unwrap_or_else(|e| panic!("{name}, {options:?}: {e}"));
            assert!(bvh.max_depth < STACK_SIZE, "{name}, {options:?}");
            assert!(bvh.statistics.sah_cost.is_finite(), "{name}, {options:?}");
            assert!(largest_leaf(&bvh) <= options.max_leaf_size.clamp(1, MAX_LEAF_SIZE));
            let wide = build_wide(&triangles, &options).unwrap();
            wide.validate(&triangles).unwrap_or_else(|e| panic!("wide {name}, {options:?}: {e}"));
            assert!(wide.max_depth < WIDE_STACK_SIZE, "wide {name}, {options:?}");
            assert!(wide.statistics.sah_cost.is_finite(), "wide {name}, {options:?}");
            if !options.spatial_splits {
                assert_eq!(bvh.statistics.duplicated_references, 0, "{name}");
                assert_eq!(wide.statistics.duplicated_references, 0, "{name}");
            }
        }
    }
}

fn largest_leaf(bvh: &Bvh) -> usize {
    (0..bvh.statistics.inner_nodes as u32)
        .flat_map(|node| bvh.children(node))
        .map(|(_, child)| match child {
            Child::Leaf { count, .. } => count as usize,
            _ => 0,
        })
        .max()
        .unwrap_or(0)
}

#[test]
fn closest_hit_is_that_of_brute_force() {
    for (name, triangles) in inputs() {
        // With one triangle in the hierarchy there is nothing to miss: brute force.
        let alone: Vec<Bvh> =
            (triangles.iter().take(500)).map(|t| build(&[*t], &BuildOptions::default()).unwrap()).collect();
        let triangles = &triangles[..alone.len()];
        for spatial_splits in [false, true] {
            let options = BuildOptions { spatial_splits, ..BuildOptions::default() };
            let hits = check_hits(name, &build(triangles, &options).unwrap(), triangles, &alone);
            let wide_hits = check_hits(name, &build_wide(triangles, &options).unwrap(), triangles, &alone);
            if ["soup", "grid", "slivers", "far away", "small in large"].contains(&name) {
                assert!(hits.min(wide_hits) > 100, "{name}: only {hits} of the rays hit anything");
            }
        }
    }
}

fn check_hits(name: &str, bvh: &impl Hierarchy, triangles: &[[Vec3; 3]], alone: &[Bvh]) -> usize {
    let mut random = Random(11);
    let mut hits = 0;
    for _ in 0..300 {
        let (origin, dir) = ray(triangles, &mut random);
        let found = closest_hit(bvh, triangles, origin, dir, f32::INFINITY);
        let expected = brute_force(alone, triangles, origin, dir);
        assert_eq!(found, expected, "{name}, from {origin} to {dir}");
        hits += usize::from(found.is_some());
    }
    hits
}

fn brute_force(alone: &[Bvh], triangles: &[[Vec3; 3]], origin: Vec3, dir: Vec3) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for (i, bvh) in alone.iter().enumerate() {
        let hit = closest_hit(bvh, &triangles[i..=i], origin, dir, f32::INFINITY);
        if let Some(hit) = hit.filter(|h| best.is_none_or(|b| h.t < b.t)) {
            best = Some(Hit { triangle: i as u32, ..hit });
        }
    }
    best
}

#[test]
fn t_max_is_a_strict_bound() {
    let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
    let bvh = build(&triangles, &BuildOptions::default()).unwrap();
    let origin = Vec3::new(0.25, 0.25, 2.0);
    let hit = |t_max| closest_hit(&bvh, &triangles, origin, Vec3::NEG_Z, t_max);
    assert_eq!(hit(2.0), None);
    assert_eq!(hit(2.1).unwrap().t, 2.0);
    assert_eq!((hit(9.0).unwrap().u, hit(9.0).unwrap().v), (0.25, 0.25));
    assert_eq!(closest_hit(&bvh, &triangles, origin, Vec3::NAN, 9.0), None);
}

#[test]
fn not_finite_vertices_are_an_error() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for options in presets() {
            let mut triangles = soup(10, 1.0, 1.0, 1);
            triangles[7][2].y = bad;
            let error = build(&triangles, &options).unwrap_err();
            assert!(matches!(error, AccelError::NotFinite { triangle: 7 }), "{error}");
        }
    }
}

#[test]
fn number_of_threads_does_not_change_the_hierarchy() {
    let triangles = soup(20_000, 0.05, 1.0, 1);
    let nodes = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let bvh = pool.install(|| build(&triangles, &BuildOptions::default()).unwrap());
        let wide = pool.install(|| build_wide(&triangles, &BuildOptions::default()).unwrap());
        (bvh.nodes, bvh.primitives, wide.nodes, wide.primitives)
    };
    assert!(nodes(1) == nodes(3));
}

#[test]
fn splitting_pays_on_slivers() {
    let triangles = slivers();
    let cost = |spatial_splits| {
        let options = BuildOptions { spatial_splits, ..BuildOptions::default() };
        let bvh = build(&triangles, &options).unwrap();
        assert_eq!(bvh.statistics.duplicated_references > 0, spatial_splits);
        bvh.statistics.sah_cost
    };
    let (whole, split) = (cost(false), cost(true));
    assert!(split <= 0.9 * whole, "{split} against {whole}");
}

type Damage = (&'static str, fn(&mut Bvh));

/// `validate` has to fail on each kind of damage.
#[test]
fn validate_finds_damage() {
    let triangles = soup(200, 0.1, 1.0, 1);
    let good = build(&triangles, &BuildOptions::default()).unwrap();
    let damaged = |damage: fn(&mut Bvh)| {
        let mut bvh = good.clone();
        damage(&mut bvh);
        bvh.validate(&triangles)
    };
    damaged(|_| {}).unwrap();
    let kinds: [Damage; 8] = [
        ("no nodes", |b| b.nodes.clear()),
        ("cut short", |b| b.nodes.truncate(b.nodes.len() - 1)),
        ("box shrunk", |b| b.nodes[1][0] = b.nodes[0][0]),
        ("child out of range", |b| b.nodes[0][3] = 1 << 20),
        ("cycle", |b| b.nodes[0][3] = 0),
        ("slot twice", |b| b.primitives[3] = b.primitives[90]),
        ("triangle out of range", |b| b.primitives[3] = 1 << 20),
        ("depth", |b| b.max_depth -= 1),
    ];
    for (name, damage) in kinds {
        assert!(damaged(damage).is_err(), "{name} was not found");
    }
}

type WideDamage = (&'static str, fn(&mut WideBvh));

#[test]
fn validate_finds_damage_of_wide_hierarchies() {
    let triangles = soup(200, 0.1, 1.0, 1);
    let good = build_wide(&triangles, &BuildOptions::default()).unwrap();
    let damaged = |damage: fn(&mut WideBvh)| {
        let mut bvh = good.clone();
        damage(&mut bvh);
        bvh.validate(&triangles)
    };
    damaged(|_| {}).unwrap();
    let kinds: [WideDamage; 8] = [
        ("no nodes", |b| b.nodes.clear()),
        ("cut short", |b| b.nodes.truncate(b.nodes.len() - 1)),
        ("boxes shrunk", |b| b.nodes[0].0[3][2] = 0),
        ("grid moved", |b| b.nodes[1].0[0][0] ^= 1 << 23),
        ("child out of range", |b| b.nodes[0].0[1][0] = 1 << 20),
        ("cycle", |b| b.nodes[0].0[1][0] = 0),
        ("triangle out of range", |b| b.primitives[3] = 1 << 20),
        ("depth", |b| b.max_depth -= 1),
    ];
    for (name, damage) in kinds {
        assert!(damaged(damage).is_err(), "{name} was not found");
    }
}

#[test]
fn child_references_survive_the_packing() {
    for child in [
        Child::Inner(0),
        Child::Inner(0x7fff_ffff),
        Child::Leaf { first: 0, count: 0 },
        Child::Leaf { first: (1 << 27) - 1, count: MAX_LEAF_SIZE as u32 },
    ] {
        assert_eq!(Child::decode(child.encode()), child);
    }
}
