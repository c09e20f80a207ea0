//! What lights emit, in watts.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::{Environment, Image, LightKind, Material, Scene, Sides, SpotFalloff, WorldTriangle};

impl Scene {
    /// Whether anything emits. A scene without lights renders black.
    pub fn has_light(&self) -> bool {
        let shines = |light: &LightKind| light.power(1.0).max_element() > 0.0;
        self.counts().emissive_triangles > 0
            || self.lights.iter().any(|light| shines(&light.kind))
            || self.environment.as_ref().is_some_and(|environment| environment.radiance.max_element() > 0.0)
    }

    /// What the environment's image is; none for a constant environment.
    pub fn environment_image(&self) -> Option<&Image> {
        self.environment.as_ref()?.image.and_then(|index| self.images.get(index as usize))
    }

    /// What all emissive triangles emit, W, their emission's textures left out: π times radiance
    /// and area, for each side that emits.
    ///
    /// # Panics
    ///
    /// Where an index is out of range: call [`Scene::validate`] first.
    pub fn emitted_power(&self) -> DVec3 {
        let emits = |instance: &u32| {
            let mesh = &self.meshes[self.instances[*instance as usize].mesh as usize];
            self.materials[mesh.material as usize].is_emissive()
        };
        let power = |instance: u32| -> DVec3 {
            let placed = self.placed(instance);
            let triangles = (0..placed.n_triangles()).map(|index| placed.triangle(index));
            triangles.map(|triangle| triangle_power(&triangle, &self.materials)).sum()
        };
        (0..self.instances.len() as u32).filter(emits).map(power).sum()
    }
}

fn triangle_power(triangle: &WorldTriangle, materials: &[Material]) -> DVec3 {
    let material = &materials[triangle.material as usize];
    let sides = if material.emits == Sides::Both { 2.0 } else { 1.0 };
    material.emission.value.as_dvec3() * (PI * sides * f64::from(triangle.area()))
}

impl LightKind {
    /// What it emits, W; of a directional light what crosses the disk of this radius that covers
    /// the scene.
    pub fn power(&self, scene_radius: f64) -> DVec3 {
        match *self {
            Self::Point { intensity, .. } => intensity.as_dvec3() * (2.0 * TAU),
            Self::Spot { intensity, inner_angle, outer_angle, falloff, .. } => {
                let share = spot_integral(inner_angle.into(), outer_angle.into(), falloff);
                intensity.as_dvec3() * share
            }
            Self::Directional { irradiance, .. } => {
                irradiance.as_dvec3() * (PI * scene_radius * scene_radius)
            }
        }
    }
}

/// The integral over the sphere of a spot's intensity, 1 within the inner cone.
fn spot_integral(inner: f64, outer: f64, falloff: SpotFalloff) -> f64 {
    let band = inner.cos() - outer.cos();
    let full = 1.0 - inner.cos();
    TAU * match falloff {
        SpotFalloff::CosineSquared => full + band / 3.0,
        SpotFalloff::Smoothstep => full + band / 2.0,
        SpotFalloff::Angle => 1.0 - (outer.sin() - inner.sin()) / (outer - inner),
    }
}

impl Environment {
    /// What crosses disks of this radius that cover the scene from all sides, W: the disk's area
    /// times the integral of radiance over the sphere, each texel over its own solid angle.
    pub fn power(&self, image: Option<&Image>, scene_radius: f64) -> DVec3 {
        let integral = image.map_or(DVec3::splat(2.0 * TAU), |image| {
            let edge = |row: u32| (PI * f64::from(row) / f64::from(image.height)).cos();
            let row_sum = |row: u32| {
                let first = row as usize * image.width as usize;
                let texels = (first..first + image.width as usize).map(|i| image.texels.linear(i));
                let sum: DVec3 =
                    texels.map(|[r, g, b, _]| Vec3::new(r, g, b).as_dvec3().max(DVec3::ZERO)).sum();
                sum * (TAU / f64::from(image.width) * (edge(row) - edge(row + 1)))
            };
            (0..image.height).map(row_sum).sum()
        });
        self.radiance.as_dvec3() * integral * (PI * scene_radius * scene_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By midpoints, from the definition of each falloff.
    #[test]
    fn spots_emit_the_integral_of_their_intensity() {
        let (inner, outer) = (0.4f64, 1.1f64);
        for falloff in [SpotFalloff::CosineSquared, SpotFalloff::Smoothstep, SpotFalloff::Angle] {
            let intensity = |angle: f64| {
                let cosine = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
                match falloff {
                    SpotFalloff::CosineSquared => cosine * cosine,
                    SpotFalloff::Smoothstep => cosine * cosine * (3.0 - 2.0 * cosine),
                    SpotFalloff::Angle => ((outer - angle) / (outer - inner)).clamp(0.0, 1.0),
                }
            };
            let n = 100_000;
            let step = outer / f64::from(n);
            let angles = (0..n).map(|i| (f64::from(i) + 0.5) * step);
            let sum: f64 = angles.map(|angle| intensity(angle) * angle.sin()).sum::<f64>() * step * TAU;
            let power = spot_integral(inner, outer, falloff);
            assert!((power - sum).abs() <= 1e-7, "{falloff:?}: {power}, not {sum}");
        }
    }

    #[test]
    fn an_image_of_one_colour_is_as_strong_as_the_constant() {
        let environment =
            Environment { radiance: Vec3::ONE, image: Some(0), world_from_environment: glam::Mat3::IDENTITY };
        let texels = crate::Texels::Float(vec![[1.0, 2.0, 3.0, 1.0]; 21].into());
        let image = Image { name: String::new(), width: 7, height: 3, texels };
        let (constant, by_image) = (environment.power(None, 2.0), environment.power(Some(&image), 2.0));
        assert!((constant.x - 16.0 * PI * PI).abs() <= 1e-9);
        assert!((by_image - constant * DVec3::new(1.0, 2.0, 3.0)).length() <= 1e-9);
    }
}
