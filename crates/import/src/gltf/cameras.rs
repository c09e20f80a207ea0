//! Cameras.

use glam::DMat4;
use midway_scene::{Camera, Projection};

use super::json::Json;
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

/// The camera of a node; none where the node flattens it.
pub(super) fn read(
    camera: &Json,
    node: &Json,
    world_from_node: &DMat4,
    warnings: &mut Warnings,
) -> Result<Option<Camera>, ImportError> {
    let (projection, aspect) = match (camera.get("perspective"), camera.get("orthographic")) {
        (Some(perspective), _) => perspective_of(&perspective)?,
        (None, Some(orthographic)) => orthographic_of(&orthographic)?,
        (None, None) => {
            return Err(camera.malformed("a camera has a \"perspective\" or an \"orthographic\" part"));
        }
    };
    let Some(rigid) = without_scale(world_from_node) else {
        let message = "cameras scaled to nothing are left out";
        warnings.add(WarningKind::Camera, node.pointer(), message);
        return Ok(None);
    };
    let name = if node.name().is_empty() { camera.name() } else { node.name() };
    Ok(Some(Camera {
        name,
        aspect: aspect.filter(|a| *a > 0.0 && a.is_finite()),
        projection,
        ..Camera::perspective(rigid.as_mat4(), 1.0)
    }))
}

fn perspective_of(perspective: &Json) -> Result<(Projection, Option<f32>), ImportError> {
    let yfov = perspective.required("yfov")?;
    let radians = yfov.float()?;
    if !(radians > 0.0 && radians < std::f32::consts::PI) {
        return Err(yfov.malformed("a field of view between 0 and π is expected here"));
    }
    let aspect = perspective.get("aspectRatio").map(|a| a.float()).transpose()?;
    Ok((Projection::Perspective { yfov: radians }, aspect))
}

fn orthographic_of(orthographic: &Json) -> Result<(Projection, Option<f32>), ImportError> {
    let [xmag, ymag] = ["xmag", "ymag"].map(|key| orthographic.required(key));
    let (x, y) = (xmag?.float()?, ymag?.float()?);
    if x == 0.0 || y == 0.0 {
        return Err(orthographic.malformed("magnifications other than 0 are expected here"));
    }
    // Half of what is seen; a sign would mirror the image, which no exporter means.
    Ok((Projection::Orthographic { height: 2.0 * y.abs() }, Some((x / y).abs())))
}

/// The rotation and translation of a transform: its view direction and, as nearly as that allows,
/// its up direction. None where it has none, or is not finite.
pub(super) fn without_scale(m: &DMat4) -> Option<DMat4> {
    let z = m.z_axis.truncate().try_normalize()?;
    let y = m.y_axis.truncate();
    let x = y.cross(z).try_normalize()?;
    let translation = m.w_axis.truncate();
    let rigid =
        DMat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), translation.extend(1.0));
    rigid.as_mat4().is_finite().then_some(rigid)
}
