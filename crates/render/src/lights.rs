//! All lights, chosen by power through an alias table: one for each emissive triangle with area,
//! those without extent, and the environment.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use midway_scene::{LightKind, Scene, Sides, Sphere, WorldTriangle};
use rayon::prelude::*;

use crate::environment::EnvironmentMap;

/// What a light is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// Index of an emissive triangle in the world's order.
    Triangle(u32),
    /// Index into [`Scene::lights`].
    Delta(u32),
    /// The scene's environment.
    Environment,
}

/// One light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// What it is.
    pub source: LightSource,
    /// What is drawn from uniformly, > 0: a triangle's area; the solid angle that a point light
    /// shines into; at infinity the area of the disk that covers the scene.
    pub measure: f32,
    /// What it is chosen by: the luminance of its power, W.
    pub power: f64,
}

/// The lights of a scene, with the alias table that draws them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// Triangles first, the environment last.
    pub lights: Vec<Light>,
    /// For each light its chance, threshold and alias.
    pub table: Vec<AliasEntry>,
}

/// An entry of an alias table (Vose 1991).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AliasEntry {
    /// The chance of drawing this entry in all.
    pub pmf: f32,
    /// Below it the cell's own entry is drawn, else the alias.
    pub threshold: f32,
    /// The other entry.
    pub alias: u32,
}

impl Lights {
    /// Collects the lights of a valid scene: its emissive triangles, each given with its index, the
    /// lights that are not surfaces, and the environment. `mean_emission`: radiance over a
    /// triangle's front.
    pub fn collect(
        scene: &Scene,
        triangles: impl Iterator<Item = (u32, WorldTriangle)>,
        sphere: Sphere,
        environment: Option<&EnvironmentMap>,
        mean_emission: impl Fn(&WorldTriangle) -> Vec3,
    ) -> Lights {
        let disk = PI * f64::from(sphere.radius).powi(2);
        let area_lights = triangles.map(|(index, triangle)| {
            let both = scene.materials[triangle.material as usize].emits == Sides::Both;
            let area = triangle.area();
            let exitance = luminance(mean_emission(&triangle).as_dvec3()) * PI * if both { 2.0 } else { 1.0 };
            Light { source: LightSource::Triangle(index), measure: area, power: exitance * f64::from(area) }
        });
        let deltas = (0u32..).zip(&scene.lights).map(|(index, light)| Light {
            source: LightSource::Delta(index),
            measure: emission_measure(&light.kind, disk) as f32,
            power: luminance(light.kind.power(sphere.radius.into())),
        });
        let around = environment.map(|map| Light {
            source: LightSource::Environment,
            measure: disk as f32,
            power: map.total * disk,
        });
        let counts = |light: &Light| {
            light.power > 0.0 && light.power.is_finite() && light.measure > 0.0 && light.measure.is_finite()
        };
        let lights: Vec<Light> = area_lights.chain(deltas).chain(around).filter(counts).collect();
        let table = alias_table(lights.iter().map(|l| l.power).collect());
        Lights { lights, table }
    }

    /// The environment's place, if it is among them.
    pub fn environment(&self) -> Option<u32> {
        let last = self.lights.last()?;
        (last.source == LightSource::Environment).then(|| self.lights.len() as u32 - 1)
    }
}

/// What emission is drawn from: a solid angle, or the disk that covers the scene.
fn emission_measure(light: &LightKind, disk: f64) -> f64 {
    match *light {
        LightKind::Point { .. } => 2.0 * TAU,
        LightKind::Spot { outer_angle, .. } => 2.0 * TAU * (0.5 * f64::from(outer_angle)).sin().powi(2),
        LightKind::Directional { .. } => disk,
    }
}

/// Rec. 709 luminance.
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Vose's construction. Weights are finite and not negative; one at least is positive, or there are
/// none. What weighs nothing is never drawn.
pub fn alias_table(weights: Vec<f64>) -> Vec<AliasEntry> {
    let total: f64 = weights.iter().sum();
    let n = weights.len();
    let heaviest = (0..n).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or_default();
    let entry =
        |(i, w): (usize, &f64)| AliasEntry { pmf: (w / total) as f32, threshold: 1.0, alias: i as u32 };
    let mut table: Vec<AliasEntry> = weights.par_iter().enumerate().map(entry).collect();
    // In place: of a large sky each copy is a quarter of a gigabyte.
    let mut scaled = weights;
    scaled.par_iter_mut().for_each(|w| *w = *w / total * n as f64);
    let places = |is_small: bool| -> Vec<u32> {
        let wanted = |(_, w): &(usize, &f64)| (**w < 1.0) == is_small;
        scaled.par_iter().enumerate().filter(wanted).map(|(i, _)| i as u32).collect()
    };
    let (mut small, mut large) = (places(true), places(false));
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        let lacks = 1.0 - scaled[s as usize];
        let entry = &mut table[s as usize];
        (entry.threshold, entry.alias) = (scaled[s as usize] as f32, l);
        let left = &mut scaled[l as usize];
        *left -= lacks;
        if *left < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // Rounding leaves some that lack a little of 1, and may leave some that weigh nothing.
    for s in small {
        let entry = &mut table[s as usize];
        (entry.threshold, entry.alias) = (scaled[s as usize] as f32, heaviest as u32);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::alias_table;

    #[test]
    fn the_table_draws_each_entry_by_its_weight() {
        let weights = [3.0, 1.0, 0.5, 0.0, 7.0, 1e-3, 2.0, 0.0];
        let table = alias_table(weights.to_vec());
        let total: f64 = weights.iter().sum();
        for (i, weight) in weights.iter().enumerate() {
            let mut chance = 0.0;
            for (cell, entry) in table.iter().enumerate() {
                let own = f64::from(entry.threshold);
                chance += if cell == i { own } else { 0.0 };
                chance += if entry.alias as usize == i { 1.0 - own } else { 0.0 };
            }
            chance /= weights.len() as f64;
            assert!((chance - weight / total).abs() <= 1e-7, "{i}: {chance}");
            assert!((f64::from(table[i].pmf) - weight / total).abs() <= 1e-7);
            assert!(*weight > 0.0 || chance == 0.0);
        }
    }
}
