//! Lights as records of vec4.

use glam::Vec3;
use midway_kernels::constants as k;
use midway_scene::{LightGroups, LightKind, SpotFalloff, WorldTriangle};

use super::{Word4, Words, medium_or_none, word4};
use crate::{
    lights::{LightSource, Lights},
    medium::MediumFinder,
    world::World,
};

/// A direction that no one models along, so that it meets no edge.
const SLANTED: Vec3 = Vec3::new(0.267_261, 0.534_522, 0.801_784);

/// All lights, with the table that draws them, and behind the records what triangles do not need.
pub(super) fn pack_lights(
    lights: &Lights,
    groups: &LightGroups,
    world: &World<'_>,
    media: Option<&MediumFinder<'_>>,
    words: &mut Words,
) {
    let details_at = words.next() as usize + lights.lights.len() * k::LIGHT_STRIDE as usize;
    let mut details = Vec::new();
    for (light, entry) in lights.lights.iter().zip(&lights.table) {
        let (kind, data, medium, group) = match light.source {
            LightSource::Triangle(index) => {
                let triangle = world.triangle(index);
                let group = groups.instances[triangle.instance as usize];
                (k::LIGHT_TRIANGLE, index, medium_at_triangle(&triangle, media), group)
            }
            LightSource::Delta(index) => {
                let at = (details_at + details.len()) as u32;
                let (kind, medium) =
                    pack_delta(&world.scene().lights[index as usize].kind, media, &mut details);
                (kind, at, medium, groups.lights[index as usize])
            }
            LightSource::Environment => (k::LIGHT_ENVIRONMENT, 0, k::NONE, groups.environment),
        };
        words.extend([
            [data, entry.pmf.to_bits(), entry.threshold.to_bits(), entry.alias],
            [light.measure.to_bits(), medium, kind, group.into()],
        ]);
    }
    words.extend(details);
}

fn medium_at_triangle(triangle: &WorldTriangle, media: Option<&MediumFinder<'_>>) -> u32 {
    triangle.geometric_normal().map_or(k::NONE, |normal| {
        let [a, b, c] = triangle.positions;
        let centre = (a + b + c) / 3.0;
        let lift = centre.abs().max_element().max((b - a).length()) * 1e-5;
        medium_or_none(media, centre + normal * lift, normal)
    })
}

/// Appends what there is of a light without extent; its kind and the medium around it.
fn pack_delta(light: &LightKind, media: Option<&MediumFinder<'_>>, details: &mut Vec<Word4>) -> (u32, u32) {
    match *light {
        LightKind::Point { position, intensity } => {
            details.extend([word4(position, k::FALLOFF_NONE), word4(intensity, 0), word4(Vec3::Z, 0)]);
            (k::LIGHT_POINT, medium_or_none(media, position, SLANTED))
        }
        LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, falloff } => {
            let (falloff, full, zero) = cone(inner_angle, outer_angle, falloff);
            details.extend([
                word4(position, falloff),
                word4(intensity, full.to_bits()),
                word4(direction.normalize(), zero.to_bits()),
            ]);
            (k::LIGHT_POINT, medium_or_none(media, position, SLANTED))
        }
        LightKind::Directional { direction, irradiance } => {
            details.extend([word4(-direction.normalize(), 0), word4(irradiance, 0)]);
            (k::LIGHT_DIRECTIONAL, k::NONE)
        }
    }
}

/// The falloff as kernels name it, and between which 1 - cosine or angles it lies: told apart even
/// where f32 rounds them to one.
fn cone(inner: f32, outer: f32, falloff: SpotFalloff) -> (u32, f32, f32) {
    let drop = |angle: f32| (2.0 * (0.5 * f64::from(angle)).sin().powi(2)) as f32;
    let (falloff, full, zero) = match falloff {
        SpotFalloff::CosineSquared => (k::FALLOFF_COSINE_SQUARED, drop(inner), drop(outer)),
        SpotFalloff::Smoothstep => (k::FALLOFF_SMOOTHSTEP, drop(inner), drop(outer)),
        SpotFalloff::Angle => (k::FALLOFF_ANGLE, inner, outer),
    };
    (falloff, full.min(zero.next_down()), zero)
}
