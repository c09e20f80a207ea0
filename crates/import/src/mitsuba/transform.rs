//! `<transform>`: a list of steps, the first one applied first.

use glam::{DMat4, DVec3, Mat3, Mat4, Vec2, Vec3};
use roxmltree::Node;

use super::value::{number, numbers, triple};

/// `x`, `y` and `z`, each `default` where it is absent; none where one is not a number or all are
/// absent.
pub(super) fn xyz<'a>(attribute: &impl Fn(&str) -> Option<&'a str>, default: f32) -> Option<Vec3> {
    let names = ["x", "y", "z"];
    if names.iter().all(|name| attribute(name).is_none()) {
        return None;
    }
    let [x, y, z] = names.map(|name| attribute(name).map_or(Some(default), number));
    Some(Vec3::new(x?, y?, z?))
}

/// One step. `attribute` has what the element says, names substituted.
///
/// # Errors
///
/// What is wrong with it.
pub(super) fn step<'a>(node: Node, attribute: impl Fn(&str) -> Option<&'a str>) -> Result<DMat4, String> {
    let tag = node.tag_name().name();
    let expected = |what: &str| format!("<{tag}> needs {what}");
    let vector = |default: f32| match attribute("value") {
        Some(text) => triple(text).or_else(|| number(text).map(Vec3::splat)),
        None => xyz(&attribute, default),
    };
    match tag {
        "translate" => {
            let by = vector(0.0).ok_or_else(|| expected("x, y and z"))?;
            Ok(DMat4::from_translation(by.as_dvec3()))
        }
        "scale" => {
            let by = vector(1.0).ok_or_else(|| expected("x, y and z, or a value"))?;
            Ok(DMat4::from_scale(by.as_dvec3()))
        }
        "rotate" => {
            let axis = vector(0.0).and_then(|axis| axis.as_dvec3().try_normalize());
            let axis = axis.ok_or_else(|| expected("an axis"))?;
            let angle = attribute("angle").and_then(number).ok_or_else(|| expected("an angle"))?;
            Ok(DMat4::from_axis_angle(axis, f64::from(angle).to_radians()))
        }
        "matrix" => {
            let values = attribute("value").and_then(numbers).unwrap_or_default();
            matrix(&values).ok_or_else(|| expected("16 numbers, or 9, of an affine transform"))
        }
        "lookat" | "lookAt" | "look_at" => {
            let point = |name: &str| attribute(name).and_then(triple).map(Vec3::as_dvec3);
            let (origin, target) = (point("origin"), point("target"));
            let (Some(origin), Some(target)) = (origin, target) else {
                return Err(expected("an origin and a target"));
            };
            look_at(origin, target, point("up")).ok_or_else(|| expected("a direction, and up across it"))
        }
        _ => Err(format!("<{tag}> is not a transform that is known")),
    }
}

/// Row by row; none where the last row is not 0 0 0 1.
fn matrix(values: &[f32]) -> Option<DMat4> {
    match values.len() {
        9 => {
            let rows = Mat3::from_cols_slice(values).transpose();
            Some(Mat4::from_mat3(rows).as_dmat4())
        }
        16 => {
            let m = Mat4::from_cols_slice(values).transpose();
            (m.row(3) == glam::Vec4::W).then(|| m.as_dmat4())
        }
        _ => None,
    }
}

/// Looks along +z, y up and so x to the left; without `up`, any direction across.
fn look_at(origin: DVec3, target: DVec3, up: Option<DVec3>) -> Option<DMat4> {
    let z = (target - origin).try_normalize()?;
    let up = up.filter(|up| *up != DVec3::ZERO).unwrap_or_else(|| z.any_orthogonal_vector());
    let x = up.cross(z).try_normalize()?;
    let y = z.cross(x);
    Some(DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0)))
}

/// A transform of texture coordinates, as the part of a 4 x 4 matrix that moves (u, v).
pub(super) fn of_uv(m: Mat4) -> Mat3 {
    Mat3::from_cols(
        Vec2::new(m.x_axis.x, m.x_axis.y).extend(0.0),
        Vec2::new(m.y_axis.x, m.y_axis.y).extend(0.0),
        Vec2::new(m.w_axis.x, m.w_axis.y).extend(1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(xml: &str) -> Result<DMat4, String> {
        let document = roxmltree::Document::parse(xml).unwrap();
        let node = document.root_element();
        step(node, |name| node.attribute(name))
    }

    fn image(xml: &str, point: [f64; 3]) -> DVec3 {
        of(xml).unwrap().transform_point3(DVec3::from(point))
    }

    #[test]
    fn steps_move_points_as_they_say() {
        let close = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from(b)).length() <= 1e-6, "{a} {b:?}");
        close(image("<translate y='2'/>", [1.0, 1.0, 1.0]), [1.0, 3.0, 1.0]);
        close(image("<scale value='2'/>", [1.0, 2.0, 3.0]), [2.0, 4.0, 6.0]);
        close(image("<scale x='-1'/>", [1.0, 2.0, 3.0]), [-1.0, 2.0, 3.0]);
        close(image("<rotate z='2' angle='90'/>", [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        close(
            image("<matrix value='0 -1 0 5  1 0 0 6  0 0 1 7  0 0 0 1'/>", [1.0, 0.0, 0.0]),
            [5.0, 7.0, 7.0],
        );
        close(image("<matrix value='0 -1 0  1 0 0  0 0 1'/>", [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        let look = "<lookat origin='0,0,5' target='0,0,0' up='0,1,0'/>";
        close(image(look, [0.0, 0.0, 1.0]), [0.0, 0.0, 4.0]);
        close(image(look, [1.0, 0.0, 0.0]), [-1.0, 0.0, 5.0]);
    }

    #[test]
    fn bad_steps_are_refused() {
        for xml in [
            "<translate/>",
            "<scale value='nan'/>",
            "<rotate x='0' angle='3'/>",
            "<rotate x='1'/>",
            "<matrix value='1 2 3'/>",
            "<matrix value='1 0 0 0  0 1 0 0  0 0 1 0  0 0 1 1'/>",
            "<lookat origin='0,0,0' target='0,0,0' up='0,1,0'/>",
            "<lookat origin='0,0,0' target='0,1,0' up='0,1,0'/>",
            "<shear x='1'/>",
        ] {
            assert!(of(xml).is_err(), "{xml}");
        }
    }
}
