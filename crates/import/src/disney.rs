//! What Burley's model has in other terms than glTF's, from which it is rendered (Physically-Based Shading at
//! Disney, 2012).

use glam::Vec3;
use midway_scene::{ColorInput, ScalarInput};

use crate::images::{Images, Input};

/// Rec. 709.
const LUMINANCE: Vec3 = Vec3::new(0.212_671, 0.715_16, 0.072_169);

/// What is said of a sheen that is not [`Sheen::is_whole`].
pub(crate) const SHEEN_IN_PART: &str =
    "textures of a sheen's colour that lie otherwise than its strength's count as white";

/// The colour of a sheen.
pub(crate) struct Sheen {
    pub color: ColorInput,
    /// Whether each of its textures counts.
    pub is_whole: bool,
}

/// A strength times white, or in part the hue of the base.
pub(crate) fn sheen(
    images: &mut Images,
    base: &ColorInput,
    tint: &ScalarInput,
    strength: &ScalarInput,
) -> Sheen {
    if strength.value == 0.0 {
        return Sheen { color: Vec3::ZERO.into(), is_whole: true };
    }
    let color = |values: &[Vec3]| {
        let luminance = values[0].dot(LUMINANCE);
        let hue = if luminance > 0.0 { values[0] / luminance } else { Vec3::ONE };
        (Vec3::ONE + (hue - Vec3::ONE) * values[1].clamp(Vec3::ZERO, Vec3::ONE)) * values[2]
    };
    // Without a tint the base is of no matter.
    let base = if tint.value == 0.0 { Vec3::ONE.into() } else { base.clone() };
    let whole = [base.clone().into(), tint.clone().into(), strength.clone().into()];
    if let Some(color) = images.computed(&whole, color) {
        return Sheen { color, is_whole: true };
    }
    let plain = |strength: Input| {
        [ColorInput::from(base.value).into(), ScalarInput::from(tint.value).into(), strength]
    };
    let in_part = images.computed(&plain(strength.clone().into()), color);
    let flat = || color(&[base.value, Vec3::splat(tint.value), Vec3::splat(strength.value)]);
    let color = in_part.unwrap_or_else(|| flat().clamp(Vec3::ZERO, Vec3::ONE).into());
    Sheen { color, is_whole: false }
}

/// glTF's roughness of a coat by its gloss: α from 0.1 to 0.001.
pub(crate) fn coat_roughness(images: &mut Images, gloss: &ScalarInput) -> ScalarInput {
    let roughness = |gloss: Vec3| (0.1 + (0.001 - 0.1) * gloss.clamp(Vec3::ZERO, Vec3::ONE)).map(f32::sqrt);
    let computed = images.computed_scalar(&[gloss.clone().into()], move |values| roughness(values[0]));
    computed.unwrap_or_else(|| roughness(Vec3::splat(gloss.value)).x.into())
}
