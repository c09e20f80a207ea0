//! Lights as records of vec4.

use midway_kernels::constants as k;

use super::{Word4, medium_or_none};
use crate::{lights::Lights, medium::MediumFinder, world::World};

/// All lights, with the table that draws them.
pub(super) fn pack_lights(
    lights: &Lights,
    world: &World<'_>,
    media: &MediumFinder<'_>,
    words: &mut Vec<Word4>,
) {
    for (light, entry) in lights.lights.iter().zip(&lights.table) {
        let triangle = world.triangle(light.triangle);
        let medium = triangle.geometric_normal().map_or(k::NONE, |normal| {
            let [a, b, c] = triangle.positions;
            let centre = (a + b + c) / 3.0;
            let lift = centre.abs().max_element().max((b - a).length()) * 1e-5;
            medium_or_none(media, centre + normal * lift, normal)
        });
        words.push([light.triangle, entry.pmf.to_bits(), entry.threshold.to_bits(), entry.alias]);
        words.push([light.area.to_bits(), medium, 0, 0]);
    }
}
