//! Unit vectors in 32 bits, as `oct_decode` in the kernels' `lib/surface.wgsl` reads them.

use glam::Vec3;

/// The steps of a coordinate.
const STEPS: f32 = 32767.0;

/// A unit vector's octahedral map in 2 x 16 bits, each coordinate rounded (Cigolle et al. 2014, "A
/// Survey of Efficient Representations for Independent Unit Vectors", "oct32").
pub(super) fn oct_encode(n: Vec3) -> u32 {
    let p = n / (n.x.abs() + n.y.abs() + n.z.abs());
    // The lower half of the octahedron is folded over the upper half's edges.
    let fold = |x: f32, y: f32| if p.z >= 0.0 { x } else { (1.0 - y.abs()).copysign(x) };
    let code = |x: f32| u32::from((x * STEPS).round() as i16 as u16);
    code(fold(p.x, p.y)) | code(fold(p.y, p.x)) << 16
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, vec3};
    use midway_kernels::{constants as k, native::lib};

    use super::*;

    #[test]
    fn packed_normals_keep_the_kernels_claim() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
        for axis in axes {
            let v = lib::oct_decode(oct_encode(axis));
            assert_eq!(vec3(v.x, v.y, v.z), axis);
        }
        let mut largest = 0.0f64;
        for i in 0..200_000u32 {
            let [a, b, ..] = midway_kernels::native::random4(i, 0, 0, 5);
            let (z, phi) = (2.0 * a - 1.0, std::f32::consts::TAU * b);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let n = vec3(r * phi.cos(), r * phi.sin(), z).normalize();
            let code = oct_encode(n);
            assert_ne!(code, k::FLAT_NORMAL);
            let v = lib::oct_decode(code);
            let v = DVec3::new(v.x.into(), v.y.into(), v.z.into());
            largest = largest.max(v.cross(n.as_dvec3()).length().asin());
            assert!(v.dot(n.as_dvec3()) > 0.0);
        }
        println!("largest error of a packed normal: {largest:e} radians");
        assert!(largest <= 1e-4, "{largest:e}");
    }
}
