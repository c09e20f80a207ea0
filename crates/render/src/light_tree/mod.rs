//! The tree over lights that next-event estimation descends (`lib/light_tree.wgsl`).

mod bound;
mod build;
mod wide;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use midway_scene::{Bounds, LightKind, Sides};

use self::{
    bound::{Cone, Reach},
    build::build,
    wide::widen,
};
pub use self::{
    bound::{LightBound, Reach as LightReach},
    wide::{Child, Link, WIDTH, WideNode},
};
use crate::{
    LightSampling,
    lights::{Light, LightSource, Lights, luminance},
    world::World,
};

/// The lights of a scene as a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTree {
    /// Of all lights; none where there are none.
    pub bound: Option<LightBound>,
    /// The root first; none where there is no light.
    pub nodes: Vec<WideNode>,
    /// For each light the way to it, two bits a level from the lowest, which of the children.
    pub ways: Vec<u32>,
}

/// Lights from which on a tree pays, unless they lie together: two triangles of one lamp are 15 % slower by
/// it and no better, eight lights apart have 0.4 to 0.6 of the error (bench/NOTES.md).
const LEAST_LIGHTS: usize = 8;
/// The share of the scene's diameter over which they lie at least: a lamp of four thousand triangles is one
/// light to nearly all that it shines on.
const LEAST_SPREAD: f32 = 0.25;

impl LightTree {
    /// The tree where lights are to be drawn by one, in a scene of this radius.
    pub fn wanted(sampling: LightSampling, lights: &Lights, world: &World<'_>, radius: f32) -> Option<Self> {
        match sampling {
            LightSampling::Power => None,
            LightSampling::Tree => Some(Self::new(lights, world)),
            LightSampling::Auto => (lights.lights.len() >= LEAST_LIGHTS)
                .then(|| Self::new(lights, world))
                .filter(|tree| tree.spread() >= LEAST_SPREAD * 2.0 * radius),
        }
    }

    /// The diagonal of the box around the lights that are somewhere, 0 without any.
    fn spread(&self) -> f32 {
        let bounds = self.bound.map_or(Bounds::EMPTY, |bound| bound.bounds);
        if bounds.is_empty() { 0.0 } else { bounds.diagonal().length() }
    }

    /// Over all lights that are ever drawn by power.
    fn new(lights: &Lights, world: &World<'_>) -> Self {
        let bounds: Vec<LightBound> = lights.lights.iter().map(|light| bound_of(light, world)).collect();
        let drawn = (0u32..).zip(&lights.table).filter(|(_, entry)| entry.pmf > 0.0).map(|(light, _)| light);
        Self::over(&bounds, drawn.collect())
    }

    fn over(bounds: &[LightBound], lights: Vec<u32>) -> Self {
        let binary = build(bounds, lights);
        let nodes = widen(&binary);
        let mut ways = vec![0; bounds.len()];
        let mut waiting: Vec<(u32, u32, u32)> = nodes.first().map(|_| (0, 0, 0)).into_iter().collect();
        while let Some((node, way, depth)) = waiting.pop() {
            for (place, child) in (0u32..).zip(nodes[node as usize].iter().flatten()) {
                let way = way | place << (2 * depth);
                match child.link {
                    Link::Light(light) => ways[light as usize] = way,
                    Link::Node(node) => waiting.push((node, way, depth + 1)),
                }
            }
        }
        Self { bound: binary.first().map(|root| root.bound), nodes, ways }
    }
}

fn bound_of(light: &Light, world: &World<'_>) -> LightBound {
    match light.source {
        LightSource::Triangle(index) => {
            let triangle = world.triangle(index);
            let both = world.scene().materials[triangle.material as usize].emits == Sides::Both;
            LightBound {
                bounds: Bounds::of_points(&triangle.positions),
                // There is one: triangles without area are no lights.
                normals: Cone { axis: triangle.geometric_normal().unwrap_or(Vec3::Z).as_dvec3(), angle: 0.0 },
                emission: FRAC_PI_2,
                intensity: light.power / (PI * if both { 2.0 } else { 1.0 }),
                reach: if both { Reach::Both } else { Reach::Front },
            }
        }
        LightSource::Delta(index) => bound_of_delta(&world.scene().lights[index as usize].kind),
        // A surface sees half of it: the mean radiance over the sphere times π.
        LightSource::Environment => at_infinity(0.25 * light.power / f64::from(light.measure)),
    }
}

fn bound_of_delta(kind: &LightKind) -> LightBound {
    let at = |position: Vec3, intensity: Vec3, normals, emission| LightBound {
        bounds: Bounds::of_points(&[position]),
        normals,
        emission,
        intensity: luminance(intensity.as_dvec3()),
        reach: Reach::Front,
    };
    match *kind {
        LightKind::Point { position, intensity } => {
            at(position, intensity, Cone { axis: DVec3::Z, angle: PI }, FRAC_PI_2)
        }
        LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, .. } => {
            let normals = Cone { axis: direction.as_dvec3().normalize(), angle: inner_angle.into() };
            at(position, intensity, normals, f64::from(outer_angle - inner_angle).max(0.0))
        }
        LightKind::Directional { irradiance, .. } => at_infinity(luminance(irradiance.as_dvec3())),
    }
}

fn at_infinity(irradiance: f64) -> LightBound {
    let normals = Cone { axis: DVec3::Z, angle: PI };
    LightBound {
        bounds: Bounds::EMPTY,
        normals,
        emission: FRAC_PI_2,
        intensity: irradiance,
        reach: Reach::Infinite,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f32, intensity: f64) -> LightBound {
        let bounds = Bounds::of_points(&[Vec3::new(x, 0.0, 0.0)]);
        LightBound { bounds, intensity, reach: Reach::Front, ..at_infinity(1.0) }
    }

    /// Every light once, by its way, in at most 16 levels, within the bounds of all nodes above it.
    fn check(bounds: &[LightBound], lights: &[u32]) {
        let tree = LightTree::over(bounds, lights.to_vec());
        let children = || tree.nodes.iter().flatten().flatten();
        assert_eq!(children().filter(|child| matches!(child.link, Link::Light(_))).count(), lights.len());
        assert_eq!(
            children().filter(|child| matches!(child.link, Link::Node(_))).count(),
            tree.nodes.len() - 1
        );
        for &light in lights {
            let (mut way, mut node) = (tree.ways[light as usize], 0u32);
            for level in 0.. {
                assert!(level < 16);
                let child = tree.nodes[node as usize][(way & 3) as usize].expect("a child");
                let (bound, own) = (child.bound, &bounds[light as usize]);
                assert!(bound.bounds.contains(&own.bounds) && bound.intensity >= own.intensity);
                assert!(bound.reach >= own.reach && bound.emission >= own.emission);
                way >>= 2;
                match child.link {
                    Link::Light(found) => {
                        assert_eq!((found, way), (light, 0));
                        break;
                    }
                    Link::Node(next) => node = next,
                }
            }
        }
    }

    #[test]
    fn every_light_has_a_way() {
        let lights: Vec<LightBound> =
            (0..1000).map(|i| point((i * 37 % 101) as f32, f64::from(i % 7))).collect();
        check(&lights, &(0..1000).collect::<Vec<_>>());
        check(&lights, &[7]);
        check(&lights, &(0..1000).filter(|i| i % 3 == 0).collect::<Vec<_>>());
        check(&vec![point(1.0, 1.0); 100], &(0..100).collect::<Vec<_>>());
        assert!(LightTree::over(&lights, Vec::new()).nodes.is_empty());
    }

    /// Each twice as far out as the one before: by cost alone one light a level is split off.
    #[test]
    fn levels_never_run_out() {
        let lights: Vec<LightBound> =
            (0..120).flat_map(|i| [point((i as f32).exp2(), 1.0), point(-(i as f32).exp2(), 1.0)]).collect();
        check(&lights, &(0..240).collect::<Vec<_>>());
    }

    /// Nodes are full but at the leaves.
    #[test]
    fn nodes_are_full() {
        let lights: Vec<LightBound> = (0..1000).map(|i| point((i * 37 % 101) as f32, 1.0)).collect();
        let tree = LightTree::over(&lights, (0..1000).collect());
        assert!(tree.nodes.len() < 520, "{} nodes", tree.nodes.len());
        let half_full =
            |node: &&WideNode| node.iter().flatten().any(|child| matches!(child.link, Link::Node(_)));
        assert!(tree.nodes.iter().filter(half_full).all(|node| node.iter().all(Option::is_some)));
    }

    /// No child of the root has lights at infinity and others.
    #[test]
    fn lights_at_infinity_are_apart() {
        let mut lights: Vec<LightBound> = (0..20).map(|i| point(i as f32, 1.0)).collect();
        for i in [3, 4, 11] {
            lights[i] = at_infinity(1.0);
        }
        let tree = LightTree::over(&lights, (0..20).collect());
        for (light, way) in lights.iter().zip(&tree.ways) {
            let child = tree.nodes[0][(way & 3) as usize].expect("a child");
            assert_eq!(child.bound.reach, light.reach);
        }
        check(&lights, &(0..20).collect::<Vec<_>>());
    }
}
