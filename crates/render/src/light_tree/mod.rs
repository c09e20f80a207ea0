//! The tree over lights that next-event estimation descends (`lib/light_tree.wgsl`).

mod bound;
mod build;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use midway_scene::{Bounds, LightKind, Sides};

pub use self::{
    bound::Reach as LightReach,
    build::{Link, Node},
};
use self::{
    bound::{Cone, LightBound, Reach},
    build::build,
};
use crate::{
    LightSampling,
    lights::{Light, LightSource, Lights, luminance},
    world::World,
};

/// The lights of a scene as a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTree {
    /// The root first; none where there is no light.
    pub nodes: Vec<Node>,
    /// For each light the way to its leaf, a bit a level from the lowest, 1 for the second child.
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
        let bounds = self.nodes.first().map_or(Bounds::EMPTY, |root| root.bound.bounds);
        if bounds.is_empty() { 0.0 } else { bounds.diagonal().length() }
    }

    /// Over all lights that are ever drawn by power.
    fn new(lights: &Lights, world: &World<'_>) -> Self {
        let bounds: Vec<LightBound> = lights.lights.iter().map(|light| bound_of(light, world)).collect();
        let drawn = (0u32..).zip(&lights.table).filter(|(_, entry)| entry.pmf > 0.0).map(|(light, _)| light);
        Self::over(&bounds, drawn.collect())
    }

    fn over(bounds: &[LightBound], lights: Vec<u32>) -> Self {
        let nodes = build(bounds, lights);
        let mut ways = vec![0; bounds.len()];
        let mut waiting: Vec<(u32, u32, u32)> = nodes.first().map(|_| (0, 0, 0)).into_iter().collect();
        while let Some((node, way, depth)) = waiting.pop() {
            match nodes[node as usize].link {
                Link::Light(light) => ways[light as usize] = way,
                Link::Children(first) => {
                    waiting.extend([(first, way, depth + 1), (first + 1, way | 1 << depth, depth + 1)]);
                }
            }
        }
        Self { nodes, ways }
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

    /// Every light once, by its way, in at most 32 levels, within the bounds of all nodes above it.
    fn check(bounds: &[LightBound], lights: &[u32]) {
        let tree = LightTree::over(bounds, lights.to_vec());
        assert_eq!(tree.nodes.len(), 2 * lights.len() - 1);
        for &light in lights {
            let (mut way, mut node) = (tree.ways[light as usize], 0u32);
            for level in 0.. {
                let Node { bound, link } = tree.nodes[node as usize];
                let own = &bounds[light as usize];
                assert!(bound.bounds.contains(&own.bounds) && bound.intensity >= own.intensity);
                assert!(bound.reach >= own.reach && bound.emission >= own.emission);
                match link {
                    Link::Light(found) => {
                        assert_eq!((found, way), (light, 0));
                        break;
                    }
                    Link::Children(first) => (node, way) = (first + (way & 1), way >> 1),
                }
                assert!(level < 32);
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
        assert_eq!(LightTree::over(&lights, Vec::new()).nodes, []);
    }

    /// Each twice as far out as the one before: by cost alone one light a level is split off.
    #[test]
    fn levels_never_run_out() {
        let lights: Vec<LightBound> =
            (0..120).flat_map(|i| [point((i as f32).exp2(), 1.0), point(-(i as f32).exp2(), 1.0)]).collect();
        check(&lights, &(0..240).collect::<Vec<_>>());
    }

    /// Lights at infinity are under one child of the root, the others under the other.
    #[test]
    fn lights_at_infinity_are_apart() {
        let mut lights: Vec<LightBound> = (0..20).map(|i| point(i as f32, 1.0)).collect();
        for i in [3, 4, 11] {
            lights[i] = at_infinity(1.0);
        }
        let tree = LightTree::over(&lights, (0..20).collect());
        for (light, way) in lights.iter().zip(&tree.ways) {
            assert_eq!(way & 1 == 1, light.reach == Reach::Infinite);
        }
        check(&lights, &(0..20).collect::<Vec<_>>());
    }
}
