//! Making boxes safe for a slab test.

use glam::Vec3;
use midway_scene::Bounds;

/// Grown on each side by four units in the last place of its own coordinates, so that a slab test
/// in f32 does not miss what lies on a face. Saturates at the largest finite number.
/// What is empty stays so.
pub(crate) fn padded(bounds: Bounds) -> Bounds {
    if bounds.is_empty() {
        return Bounds::EMPTY;
    }
    let largest = bounds.min.abs().max(bounds.max.abs());
    let pad = (largest * (4.0 * f32::EPSILON)).max(Vec3::splat(f32::MIN_POSITIVE));
    Bounds {
        min: (bounds.min - pad).max(Vec3::splat(f32::MIN)),
        max: (bounds.max + pad).min(Vec3::splat(f32::MAX)),
    }
}
