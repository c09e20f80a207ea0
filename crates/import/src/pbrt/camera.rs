//! Camera and film.
//!
//! pbrt's cameras look along +z with y up and x to the right: a left-handed frame. Whether the world
//! that they stand in is left-handed too depends on the file (`Scale -1 1 1` before the camera is
//! the custom of exporters). Where it is, the scene's world is pbrt's with z turned round, so that
//! images are not mirrored; else the two are the same.

use glam::{DMat3, DMat4, DVec3};
use midway_scene::{Camera, Projection};

use super::{colours::Version, params::Params};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// Full vertical field of view that stands in for what is not rendered, degrees.
const STAND_IN_FOV: f64 = 40.0;
/// More pixels along an axis than any film has.
const MAX_RESOLUTION: f64 = 65_536.0;

/// What `Film` says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    pub resolution: [u32; 2],
    /// What a luminance of 1 comes to in the image, the shutter being open for 1.
    pub sensitivity: f64,
}

impl Film {
    pub fn default_of(version: Version) -> Self {
        let resolution = if version == Version::V3 { [640, 480] } else { [1280, 720] };
        Self { resolution, sensitivity: 1.0 }
    }

    pub fn read(params: &Params, version: Version, warnings: &mut Warnings) -> Result<Self, ImportError> {
        let mut film = Self::default_of(version);
        for (pixels, name) in film.resolution.iter_mut().zip(["xresolution", "yresolution"]) {
            let Some(&[number]) = params.numbers(name)? else {
                continue;
            };
            if number.fract() != 0.0 || !(1.0..=MAX_RESOLUTION).contains(&number) {
                return Err(params.malformed(format!("\"{name}\" has to be from 1 to {MAX_RESOLUTION}")));
            }
            *pixels = number as u32;
        }
        film.sensitivity = f64::from(params.float_or("iso", 100.0)?) / 100.0
            * f64::from(params.float_or("scale", 1.0)?)
            * f64::from(params.float_or("imagingratio", 1.0)?);
        if !(film.sensitivity > 0.0 && film.sensitivity.is_finite()) {
            return Err(params.malformed("the film's \"iso\" or \"scale\" has to be above 0"));
        }
        if params.string("sensor")?.unwrap_or("cie1931") != "cie1931" || params.has("whitebalance") {
            let message = "sensors other than cie1931, and white balance, are not used";
            warnings.add(WarningKind::Camera, params.place.short(), message);
        }
        params.ignore(&["filename", "diagonal", "savefp16", "maxcomponentvalue", "maxsampleluminance"]);
        params.warn_of_unused("the film", warnings);
        Ok(film)
    }
}

/// What `Camera` says.
pub(super) struct View {
    /// World from camera as pbrt has it.
    world_from_camera: DMat4,
    /// The same with orthonormal axes.
    rigid: DMat4,
    kind: Kind,
    /// Of the camera's lengths in the world.
    scale: f64,
    lens_radius: f64,
    focus_distance: f64,
    window: Option<[f64; 4]>,
    aspect: Option<f64>,
    /// Seconds for which the shutter is open.
    pub exposure: f64,
}

enum Kind {
    /// The field of view of the shorter axis, degrees.
    Perspective(f64),
    Orthographic,
}

impl View {
    pub fn read(
        kind: &str,
        camera_from_world: DMat4,
        params: &Params,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportError> {
        let world_from_camera = camera_from_world.inverse();
        let mut warn = |message: &str| {
            warnings.add(WarningKind::Camera, params.place.short(), message);
        };
        let parsed = match kind {
            "perspective" => Kind::Perspective(fov(params)?),
            "orthographic" => Kind::Orthographic,
            _ => {
                warn(
                    "cameras other than perspective and orthographic are rendered by a pinhole of 40 degrees",
                );
                params.ignore(&[
                    "lensfile",
                    "aperturediameter",
                    "focusdistance",
                    "aperture",
                    "simpleweighting",
                    "mapping",
                ]);
                Kind::Perspective(STAND_IN_FOV)
            }
        };
        let Some((rigid, scale)) = without_scale(world_from_camera) else {
            return Err(params.malformed("the camera's transform has no inverse"));
        };
        let number =
            |name: &str, default: f32| Ok::<_, ImportError>(f64::from(params.float_or(name, default)?));
        let (lens_radius, focus_distance) = (number("lensradius", 0.0)?, number("focaldistance", 1e6)?);
        if lens_radius < 0.0 || focus_distance <= 0.0 {
            return Err(
                params.malformed("\"lensradius\" has to be at least 0, and \"focaldistance\" above it")
            );
        }
        let window = match params.numbers("screenwindow")? {
            None => None,
            Some(&[x0, x1, y0, y1]) if x1 > x0 && y1 > y0 => Some([x0, x1, y0, y1]),
            Some(_) => return Err(params.malformed("\"screenwindow\" has to be x0 < x1 and y0 < y1")),
        };
        if window.is_some_and(|[x0, x1, y0, y1]| (x0 + x1).abs() > 1e-4 || (y0 + y1).abs() > 1e-4) {
            warn("screen windows that are not centred are rendered as if they were");
        }
        let aspect = params.float("frameaspectratio")?.map(f64::from).filter(|a| *a > 0.0);
        let exposure = number("shutterclose", 1.0)? - number("shutteropen", 0.0)?;
        params.warn_of_unused(&format!("cameras \"{kind}\""), warnings);
        Ok(Self {
            world_from_camera,
            rigid,
            kind: parsed,
            lens_radius: lens_radius * scale,
            focus_distance: focus_distance * scale,
            window,
            scale,
            aspect,
            exposure: if exposure > 0.0 { exposure } else { 1.0 },
        })
    }

    /// Of the scene from pbrt's: turned round where pbrt's is left-handed.
    pub fn scene_from_world(&self) -> DMat4 {
        if self.world_from_camera.determinant() > 0.0 { turned() } else { DMat4::IDENTITY }
    }

    /// The scene's camera.
    pub fn camera(&self, film: &Film) -> Camera {
        let [width, height] = film.resolution.map(f64::from);
        let frame = self.aspect.unwrap_or(width / height);
        let default =
            if frame > 1.0 { [-frame, frame, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / frame, 1.0 / frame] };
        let [x0, x1, y0, y1] = self.window.unwrap_or(default);
        let projection = match self.kind {
            Kind::Perspective(fov) => {
                let half = (fov.to_radians() / 2.0).tan() * (y1 - y0) / 2.0;
                Projection::Perspective { yfov: (2.0 * half.atan()) as f32 }
            }
            Kind::Orthographic => Projection::Orthographic { height: ((y1 - y0) * self.scale) as f32 },
        };
        Camera {
            name: String::new(),
            world_from_camera: (self.scene_from_world() * self.rigid * turned()).as_mat4(),
            projection,
            lens_radius: self.lens_radius as f32,
            focus_distance: self.focus_distance as f32,
            aspect: Some(((x1 - x0) / (y1 - y0)) as f32),
            resolution: Some(film.resolution),
        }
    }
}

/// z turned round.
pub(super) fn turned() -> DMat4 {
    DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0))
}

fn fov(params: &Params) -> Result<f64, ImportError> {
    let half = params.float("halffov")?.map(|half| 2.0 * half);
    let fov = half.unwrap_or(params.float_or("fov", 90.0)?);
    if fov > 0.0 && fov < 180.0 {
        return Ok(f64::from(fov));
    }
    Err(params.malformed("\"fov\" has to be between 0 and 180"))
}

/// The same with orthonormal axes of the same handedness, and the scale along the view. None where
/// there are no such axes.
fn without_scale(m: DMat4) -> Option<(DMat4, f64)> {
    let sign = DMat3::from_mat4(m).determinant().signum();
    let z = m.z_axis.truncate().try_normalize()?;
    let x = m.y_axis.truncate().cross(z).try_normalize()?;
    let y = z.cross(x);
    let rigid = DMat4::from_cols(
        (x * sign).extend(0.0),
        y.extend(0.0),
        z.extend(0.0),
        m.w_axis.truncate().extend(1.0),
    );
    let scale = m.z_axis.truncate().length();
    (rigid.as_mat4().is_finite() && scale > 0.0).then_some((rigid, scale))
}
