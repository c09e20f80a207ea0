//! Sensors, their films, and what they ask for besides.

use glam::{Mat3, Mat4, Vec3};
use midway_scene::{Camera, Projection};

use super::{Loader, document::Class, emitter::rotation, node::Node};
use crate::{ImportError, warning::WarningKind};

type Result<T> = std::result::Result<T, ImportError>;

/// Mitsuba's film where the file does not say.
const WIDTH: i64 = 768;
const HEIGHT: i64 = 576;
/// Pixels along a side that are believed.
const MAX_PIXELS: i64 = 1 << 16;
/// Half the diagonal of 35 mm film, millimetres: what focal lengths refer to.
const HALF_DIAGONAL: f32 = 21.633_307;
/// Where lenses focus unless the file says: at the far clipping distance.
const FAR_CLIP: f32 = 1e4;

impl Loader<'_> {
    pub(super) fn sensor(&mut self, node: Node) -> Result<()> {
        let resolution = self.film(node)?;
        let aspect = resolution[0] as f32 / resolution[1] as f32;
        let to_world = node.to_world()?;
        let plugin = node.plugin();
        let projection = match plugin {
            "perspective" | "thinlens" => Projection::Perspective { yfov: yfov(node, aspect)? },
            "orthographic" => Projection::Orthographic { height: self.film_height(node, to_world, aspect)? },
            other => {
                let message = format!("sensors of type {other:?} are not rendered");
                self.warn(WarningKind::Camera, node, &message);
                return Ok(());
            }
        };
        let has_lens = plugin == "thinlens";
        let lens_radius = if has_lens { node.float_or("aperture_radius", 0.0)? } else { 0.0 };
        let far_clip = node.float_or("far_clip", FAR_CLIP)?;
        let focus_distance = node.float_or("focus_distance", far_clip)?;
        if !(lens_radius >= 0.0 && focus_distance > 0.0) {
            return Err(node.malformed("its lens and its focus distance have to be positive"));
        }
        self.list_what_is_not_done(node);
        let (turn, mirrored) = rotation(node, to_world)?;
        let half_turn = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, -1.0));
        // A mirrored camera has x flipped; the world will be mirrored for it.
        let flip = Mat3::from_diagonal(Vec3::new(if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0));
        self.mirrored.push(mirrored);
        self.scene.cameras.push(Camera {
            name: node.id().to_owned(),
            world_from_camera: Mat4::from_translation(to_world.w_axis.truncate())
                * Mat4::from_mat3(turn * half_turn * flip),
            projection,
            lens_radius,
            focus_distance,
            aspect: Some(aspect),
            resolution: Some(resolution),
        });
        Ok(())
    }

    fn list_what_is_not_done(&mut self, node: Node) {
        if node.has("near_clip") || node.has("far_clip") {
            self.warn(WarningKind::Camera, node, "clipping distances are not used");
        }
        node.disregard(&["near_clip", "far_clip", "shutter_open", "shutter_close"]);
    }

    /// Width and height in pixels.
    fn film(&mut self, node: Node) -> Result<[u32; 2]> {
        let Some(film) = node.first(Class::Film)? else { return Ok([WIDTH as u32, HEIGHT as u32]) };
        let pixels = |name: &str, default: i64| {
            let n = film.integer(name)?.unwrap_or(default);
            let believed = (1..=MAX_PIXELS).contains(&n);
            let problem = format!("\"{name}\" has to be from 1 to {MAX_PIXELS} pixels");
            if believed { Ok(n as u32) } else { Err(film.malformed(problem)) }
        };
        let resolution = [pixels("width", WIDTH)?, pixels("height", HEIGHT)?];
        let crop = ["crop_width", "crop_height", "crop_offset_x", "crop_offset_y", "crop_size"];
        if crop.iter().any(|name| film.has(name)) {
            self.warn(WarningKind::Camera, film, "the film's crop is not used: the whole film is rendered");
        }
        if let Some(filter) = film.first(Class::Filter)?.filter(|filter| filter.plugin() != "box") {
            let message = format!("the pixel filter {:?} is not used", filter.plugin());
            self.warn(WarningKind::Camera, filter, &message);
        }
        Ok(resolution)
    }

    /// Of an orthographic film: 2 wide before its transform scales it.
    fn film_height(&mut self, node: Node, to_world: Mat4, aspect: f32) -> Result<f32> {
        let [x, y] = [to_world.x_axis, to_world.y_axis].map(|axis| axis.truncate().length());
        if (x - y).abs() > 1e-3 * y {
            let message = "orthographic films that are stretched have square pixels of their height";
            self.warn(WarningKind::Camera, node, message);
        }
        Ok(2.0 * y / aspect)
    }
}

/// Full vertical field of view, radians.
fn yfov(node: Node, aspect: f32) -> Result<f32> {
    let (axis, half_tangent) = match (node.float("fov")?, node.text("focal_length")?) {
        (Some(fov), _) => {
            if !(fov > 0.0 && fov < 180.0) {
                return Err(node.malformed("its field of view has to be in (0, 180) degrees"));
            }
            (node.text("fov_axis")?.unwrap_or("x"), (0.5 * fov.to_radians()).tan())
        }
        (None, focal_length) => {
            let text = focal_length.unwrap_or("50mm");
            let length = super::value::number(text.trim().trim_end_matches("mm")).filter(|f| *f > 0.0);
            let length = length.ok_or_else(|| node.malformed("its focal length has to be above 0 mm"))?;
            ("diagonal", HALF_DIAGONAL / length)
        }
    };
    let half_height = match axis {
        "x" => half_tangent / aspect,
        "y" => half_tangent,
        "diagonal" => half_tangent / aspect.hypot(1.0),
        "smaller" if aspect > 1.0 => half_tangent,
        "smaller" => half_tangent / aspect,
        "larger" if aspect > 1.0 => half_tangent / aspect,
        "larger" => half_tangent,
        other => return Err(node.malformed(format!("there is no axis {other:?} of a field of view"))),
    };
    Ok(2.0 * half_height.atan())
}
