//! Lights.
//!
//! pbrt-v4 divides each light's spectrum by its luminance and the film shows a luminance of 1 as 1:
//! `rgb L` is what the image holds, a spectrum that is not RGB counts by its colour alone, and `scale`
//! and `power` (in lumens, or what `scale` stands for) say how much there is. pbrt-v3 takes values as
//! they are.

use std::f32::consts::PI;

use glam::{DMat4, DVec3, Vec3};
use midway_scene::{ColorInput, LightKind, Sides, SpotFalloff};

use super::{
    colours::{Reader, Use},
    environment::{self, Layout},
    lex::shortened,
    params::Params,
    textures::Textures,
};
use crate::{
    ImportError,
    images::Encoding,
    warning::{WarningKind, Warnings},
};

/// The narrowest falloff: the inner cone has to lie within the outer.
const LEAST_FALLOFF: f32 = 1e-4;

/// A light of pbrt's world.
pub(super) enum Found {
    Light(LightKind),
    Environment(Sky),
}

/// An infinite light.
pub(super) struct Sky {
    pub radiance: Vec3,
    pub image: Option<u32>,
    /// World from light.
    pub transform: DMat4,
}

/// Reads a `LightSource`; none where it is left out.
pub(super) fn read(
    kind: &str,
    params: &Params,
    world_from_light: DMat4,
    world_is_mirrored: bool,
    reader: &Reader,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<Option<Found>, ImportError> {
    let light = Light { params, world_from_light, reader, warnings };
    let found = match kind {
        "point" | "goniometric" => light.point(kind)?,
        "spot" | "projection" => light.spot(kind)?,
        "distant" => light.distant()?,
        "infinite" | "exinfinite" => Some(light.infinite(world_is_mirrored, textures)?),
        other => {
            let message = format!("lights \"{}\" are not used", shortened(other));
            warnings.add(WarningKind::Light, params.place.short(), message);
            return Ok(None);
        }
    };
    params.ignore(&["samples", "nsamples"]);
    params.warn_of_unused(&format!("lights \"{kind}\""), warnings);
    Ok(found)
}

struct Light<'a> {
    params: &'a Params,
    world_from_light: DMat4,
    reader: &'a Reader<'a>,
    warnings: &'a mut Warnings,
}

impl Light<'_> {
    fn warn(&mut self, message: &str) {
        self.warnings.add(WarningKind::Light, self.params.place.short(), message);
    }

    /// A spectrum times `scale`.
    fn emitted(&self, name: &str) -> Result<Vec3, ImportError> {
        emitted(self.params, name, self.reader)
    }

    /// The total flux asked for, where it is.
    fn power(&self, name: &str) -> Result<Option<f32>, ImportError> {
        Ok(self.params.float(name)?.filter(|power| *power > 0.0))
    }

    fn point(mut self, kind: &str) -> Result<Option<Found>, ImportError> {
        if kind == "goniometric" {
            self.params.ignore(&["filename", "mapname"]);
            self.warn("lights \"goniometric\" are rendered as shining alike in all directions");
        }
        let mut intensity = self.emitted("I")?;
        if let Some(power) = self.power("power")? {
            intensity *= power / (4.0 * PI);
        }
        let from = self.params.point_or("from", Vec3::ZERO)?;
        let position = self.world_from_light.transform_point3(from.as_dvec3()).as_vec3();
        Ok(Some(Found::Light(LightKind::Point { position, intensity })))
    }

    fn spot(mut self, kind: &str) -> Result<Option<Found>, ImportError> {
        let (outer, delta) = if kind == "projection" {
            self.params.ignore(&["filename", "mapname"]);
            self.warn("lights \"projection\" are rendered as spots of their field of view");
            (self.params.float_or("fov", 90.0)? / 2.0, 5.0)
        } else {
            (self.params.float_or("coneangle", 30.0)?, self.params.float_or("conedeltaangle", 5.0)?)
        };
        if !(outer > 0.0 && outer <= 180.0 && delta >= 0.0) {
            return Err(self.params.malformed(
                "\"coneangle\" has to be above 0 and at most 180, and \"conedeltaangle\" at least 0",
            ));
        }
        let outer_angle = outer.to_radians().min(PI);
        let inner_angle = (outer - delta).to_radians().clamp(0.0, outer_angle * (1.0 - LEAST_FALLOFF));
        let mut intensity = self.emitted("I")?;
        if let Some(power) = self.power("power")? {
            // The solid angle of the cone and half of that of the falloff, as pbrt-v4 has it.
            let (start, end) = (inner_angle.cos(), outer_angle.cos());
            intensity *= power / (2.0 * PI * ((1.0 - start) + (start - end) / 2.0));
        }
        let Some((position, direction)) = self.aim()? else {
            return Ok(None);
        };
        let position = position.as_vec3();
        let falloff = SpotFalloff::Smoothstep;
        let kind = LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, falloff };
        Ok(Some(Found::Light(kind)))
    }

    fn distant(mut self) -> Result<Option<Found>, ImportError> {
        let mut irradiance = self.emitted("L")?;
        if let Some(illuminance) = self.power("illuminance")? {
            irradiance *= illuminance;
        }
        let Some((_, direction)) = self.aim()? else {
            return Ok(None);
        };
        Ok(Some(Found::Light(LightKind::Directional { direction, irradiance })))
    }

    /// Where it is and the way it looks; none, and a warning, where it looks nowhere.
    fn aim(&mut self) -> Result<Option<(DVec3, Vec3)>, ImportError> {
        let from = self.params.point_or("from", Vec3::ZERO)?.as_dvec3();
        let to = self.params.point_or("to", Vec3::Z)?.as_dvec3();
        let direction = self.world_from_light.transform_vector3(to - from).try_normalize();
        if direction.is_none() {
            self.warn("lights whose \"from\" and \"to\" are the same point are left out");
        }
        let position = self.world_from_light.transform_point3(from);
        Ok(direction.map(|direction| (position, direction.as_vec3())))
    }

    fn infinite(mut self, world_is_mirrored: bool, textures: &mut Textures) -> Result<Found, ImportError> {
        if self.params.has("portal") {
            self.warn("portals are not used: the light comes from all around");
        }
        let mut radiance = self.emitted("L")?;
        let transform = self.world_from_light;
        let named = |name: &str| Ok::<_, ImportError>(self.params.string(name)?.map(str::to_owned));
        let (file, layout) = match (named("filename")?, named("mapname")?) {
            (Some(file), _) => (Some(file), Layout::Octahedral),
            (None, file) => (file, Layout::LatLong),
        };
        let illuminance = self.power("illuminance")?;
        let Some(file) = file.filter(|file| !file.is_empty()) else {
            if let Some(illuminance) = illuminance {
                radiance *= illuminance / PI;
            }
            return Ok(Found::Environment(Sky { radiance, image: None, transform }));
        };
        let image =
            textures.images.read_now(self.reader.folder, &file, Encoding::Srgb, &self.params.place)?;
        let finite = (0..image.texels.len()).all(|i| image.texels.linear(i).iter().all(|x| x.is_finite()));
        if !finite {
            return Err(self.params.malformed(format!("\"{}\" holds NaN or infinity", shortened(&file))));
        }
        let layout = if layout == Layout::Octahedral && image.width != image.height {
            self.warn("images of infinite lights that are not square are read as latitude and longitude");
            Layout::LatLong
        } else {
            layout
        };
        // An octahedral map becomes twice its texels.
        let n_texels = image.texels.len() as u64 * if layout == Layout::Octahedral { 2 } else { 1 };
        if !textures.images.has_room(n_texels) {
            let problem = format!("\"{}\" has more texels than files of this size hold", shortened(&file));
            return Err(self.params.malformed(problem));
        }
        if let Some(illuminance) = illuminance {
            let own = environment::illuminance(&image, layout);
            if own > 0.0 {
                radiance *= illuminance / own;
            }
        }
        let mirrored = (transform.determinant() < 0.0) != world_is_mirrored;
        let image = textures.images.ready(environment::resampled(&image, layout, mirrored));
        Ok(Found::Environment(Sky { radiance, image: Some(image), transform }))
    }
}

/// A light's spectrum times its `scale`.
fn emitted(params: &Params, name: &str, reader: &Reader) -> Result<Vec3, ImportError> {
    let spectrum = reader.colour_or(params, name, Use::Illuminant, Vec3::ONE)?;
    let scale = reader.colour_or(params, "scale", Use::Unbounded, Vec3::ONE)?;
    Ok(spectrum * scale)
}

/// What an area light makes of a surface.
pub(super) struct AreaEmission {
    pub emission: ColorInput,
    pub emits: Sides,
    /// Flux asked for, of each shape, in place of radiance.
    pub power: Option<f32>,
}

/// Reads an `AreaLightSource`, for one shape.
pub(super) fn area(
    params: &Params,
    reader: &Reader,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<AreaEmission, ImportError> {
    let mut emission: ColorInput = emitted(params, "L", reader)?.into();
    let two_sided = params.bool_or("twosided", false)?;
    let file = params.string("filename")?.map(str::to_owned);
    if let Some(file) = file {
        emission.texture = textures.plain(&file, Encoding::Srgb, params, reader, warnings)?;
    }
    let mut power = params.float("power")?.filter(|power| *power > 0.0);
    if power.is_some() && emission.texture.is_some() {
        let message = "the power of area lights with an image is that of a white one";
        warnings.add(WarningKind::Light, params.place.short(), message);
    }
    if two_sided {
        power = power.map(|power| power / 2.0);
    }
    params.ignore(&["samples", "nsamples"]);
    params.warn_of_unused("area lights", warnings);
    let emits = if two_sided { Sides::Both } else { Sides::Front };
    Ok(AreaEmission { emission, emits, power })
}
