//! Making cameras.

use glam::{Mat4, Vec3};

use crate::{Bounds, Camera, Projection, SceneError};

/// Vertical field of view of a framed camera, radians: 40 degrees.
const FRAMING_YFOV: f32 = 0.698_131_7;
/// Room left around what is framed.
const FRAMING_MARGIN: f32 = 1.05;

impl Camera {
    /// A pinhole without a name; `yfov` in radians.
    pub fn perspective(world_from_camera: Mat4, yfov: f32) -> Self {
        Self {
            name: String::new(),
            world_from_camera,
            projection: Projection::Perspective { yfov },
            lens_radius: 0.0,
            focus_distance: 1.0,
            aspect: None,
            resolution: None,
        }
    }

    /// At `eye`, looking at `target`, `up` pointing up in the image as far as it can; where `up`
    /// is along the view, another axis takes its place. `yfov` in radians.
    ///
    /// # Errors
    ///
    /// [`SceneError::BadValue`] where `eye` and `target` coincide or a value is not finite, or
    /// `yfov` is not in (0, π).
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, yfov: f32) -> Result<Self, SceneError> {
        let bad = |problem| Err(SceneError::bad("camera", problem));
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return bad("its position, target and up direction have to be finite");
        }
        if !(yfov > 0.0 && yfov < std::f32::consts::PI) {
            return bad("its field of view has to be in (0, 180) degrees");
        }
        let Some(z) = (eye - target).try_normalize() else {
            return bad("its position and its target are the same point");
        };
        let x = [up, Vec3::Y, Vec3::Z]
            .into_iter()
            .filter_map(|up| up.try_normalize())
            .map(|up| up.cross(z))
            .find(|x| x.length() > 1e-3)
            .and_then(Vec3::try_normalize)
            .unwrap_or(Vec3::X);
        let y = z.cross(x);
        let world_from_camera = Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), eye.extend(1.0));
        Ok(Self::perspective(world_from_camera, yfov))
    }

    /// For files with no camera: looks along -z, y up, at the middle of `bounds`, from where all
    /// of it is in an image `aspect` times as wide as high. Empty bounds are taken for a unit
    /// cube about the origin.
    pub fn framing(bounds: &Bounds, aspect: f32) -> Self {
        let (centre, half) = if bounds.is_empty() {
            (Vec3::ZERO, Vec3::splat(0.5))
        } else {
            (bounds.centre(), bounds.diagonal() * 0.5)
        };
        let aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
        let half_height = half.y.max(half.x / aspect) * FRAMING_MARGIN;
        let to_front = half_height / (0.5 * FRAMING_YFOV).tan();
        // Something flat seen edge on, or a point, still needs a distance.
        let smallest = (half.max_element() * 0.1).max(centre.abs().max_element() * 1e-4);
        let distance = half.z + to_front.max(smallest).max(f32::MIN_POSITIVE.sqrt());
        Self::perspective(Mat4::from_translation(centre + Vec3::Z * distance), FRAMING_YFOV)
    }

    /// The full vertical field of view, radians; none where rays are parallel.
    pub fn yfov(&self) -> Option<f32> {
        match self.projection {
            Projection::Perspective { yfov } => Some(yfov),
            Projection::Orthographic { .. } => None,
        }
    }

    /// Where it is, in the world.
    pub fn position(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }
}
