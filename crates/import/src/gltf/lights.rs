//! `KHR_lights_punctual`: point, spot and directional lights.
//!
//! Candela and lux are taken as W·sr⁻¹ and W·m⁻², as the nits of emissive materials are taken as
//! W·m⁻²·sr⁻¹, so that lights and emissive surfaces of a file keep their ratio. Blender's exporter
//! multiplies the first two by 683 lm/W and not the third: in its files they are divided again.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DMat4, Vec3};
use midway_scene::{Light, LightKind, SpotFalloff};

use super::{cameras::without_scale, json::Json, nodes::light_group};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

pub(super) const EXTENSION: &str = "KHR_lights_punctual";
/// Luminous efficacy that Blender's exporter reckons with, lm·W⁻¹.
const LUMENS_PER_WATT: f32 = 683.0;
/// How the exporter names itself.
const BLENDER: &str = "Khronos glTF Blender I/O";
/// Cones that are not nested are made so: the inner one is this part of the outer.
const WIDEST_INNER: f32 = 0.999;

/// The document's lights.
pub(super) struct Lights<'a> {
    definitions: Vec<Json<'a>>,
    scale: f32,
}

impl<'a> Lights<'a> {
    pub fn new(root: &Json<'a>, warnings: &mut Warnings) -> Result<Self, ImportError> {
        let definitions = root.extension(EXTENSION).map_or(Ok(Vec::new()), |e| e.items("lights"))?;
        let generator = root.get("asset").and_then(|asset| asset.get("generator"));
        let blender = generator.is_some_and(|g| g.string().is_ok_and(|g| g.starts_with(BLENDER)));
        if let (true, Some(first)) = (blender, definitions.first()) {
            let message = "lights from Blender are divided by 683 lm/W, by which it multiplies them alone";
            warnings.add(WarningKind::Light, first.pointer(), message);
        }
        Ok(Self { definitions, scale: if blender { LUMENS_PER_WATT.recip() } else { 1.0 } })
    }

    /// The light of a node that refers to one.
    pub fn of(
        &self,
        node: &Json,
        world_from_node: &DMat4,
        warnings: &mut Warnings,
    ) -> Result<Option<Light>, ImportError> {
        let Some(reference) = node.extension(EXTENSION) else {
            return Ok(None);
        };
        let index = reference.required("light")?;
        let light = &self.definitions[index.index("light", self.definitions.len())?];
        let Some(rigid) = without_scale(world_from_node) else {
            let message = "lights scaled to nothing are left out";
            warnings.add(WarningKind::Light, node.pointer(), message);
            return Ok(None);
        };
        if light.get("range").is_some() {
            let message = "ranges of lights are not used: light falls off with the square of the distance";
            warnings.add(WarningKind::Light, light.pointer(), message);
        }
        let intensity = self.intensity(light)?;
        let position = rigid.w_axis.truncate().as_vec3();
        let direction = -rigid.z_axis.truncate().as_vec3();
        let kind = light.required("type")?;
        let kind = match kind.string()? {
            "point" => LightKind::Point { position, intensity },
            "directional" => LightKind::Directional { direction, irradiance: intensity },
            "spot" => {
                let (inner_angle, outer_angle) = cones(light, warnings)?;
                let falloff = SpotFalloff::CosineSquared;
                LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, falloff }
            }
            _ => return Err(kind.malformed("a light's type is point, spot or directional")),
        };
        let name = if node.name().is_empty() { light.name() } else { node.name() };
        Ok(Some(Light { name, kind, group: light_group(node) }))
    }

    fn intensity(&self, light: &Json) -> Result<Vec3, ImportError> {
        let colour = Vec3::from_array(light.floats_or("color", [1.0; 3])?);
        let intensity = colour * light.float_or("intensity", 1.0)? * self.scale;
        if intensity.is_finite() && intensity.min_element() >= 0.0 {
            return Ok(intensity);
        }
        Err(light.malformed("a light's colour and intensity have to be finite and at least 0"))
    }
}

/// Half the angles of the cones.
fn cones(light: &Json, warnings: &mut Warnings) -> Result<(f32, f32), ImportError> {
    let (mut inner, mut outer) = (0.0, FRAC_PI_4);
    if let Some(spot) = light.get("spot") {
        inner = spot.float_or("innerConeAngle", inner)?;
        outer = spot.float_or("outerConeAngle", outer)?;
    }
    if !(outer > 0.0 && outer <= FRAC_PI_2 + 1e-4) {
        return Err(light.malformed("a spot's outer cone is between 0 and π/2"));
    }
    if !(0.0..=outer * WIDEST_INNER).contains(&inner) {
        if !(0.0..=outer).contains(&inner) {
            let message = "spots whose inner cone is not within the outer one have a hard edge";
            warnings.add(WarningKind::Repaired, light.pointer(), message);
        }
        inner = outer * WIDEST_INNER;
    }
    Ok((inner, outer))
}
