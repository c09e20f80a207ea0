//! Random inputs, and the way between the kernels' vectors and f64.

use glam::DVec3;
use midway_kernels::native::lib::{Material, SURFACE_DIFFUSE};
use wgsl_cpu::runtime::{Vec2, Vec3};

/// A generator of its own, so that the kernels' hash is not tested with itself (SplitMix64,
/// Steele et al. 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1), of 24 bits, as kernels draw.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.between(0.0, 1.0) < p
    }

    pub fn unit2(&mut self) -> Vec2<f32> {
        Vec2::new(self.unit(), self.unit())
    }

    pub fn unit3(&mut self) -> Vec3<f32> {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// Uniform on the hemisphere about `n`.
    pub fn direction_about(&mut self, n: DVec3) -> DVec3 {
        let d = self.direction();
        if d.dot(n) < 0.0 { -d } else { d }
    }

    /// A shading normal in ng's hemisphere, tilted by at most about `tilt` radians.
    pub fn tilted(&mut self, ng: DVec3, tilt: f64) -> DVec3 {
        (ng + self.direction() * tilt.tan().min(0.95) * self.between(0.0, 1.0)).normalize()
    }
}

pub fn double(v: Vec3<f32>) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

pub fn single(v: DVec3) -> Vec3<f32> {
    Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

/// A material that does not emit.
pub fn surface(kind: u32, reflectance: [f32; 3], ior: f32, flags: u32) -> Material {
    Material {
        reflectance: Vec3::from(reflectance),
        kind,
        emission: Vec3::splat(0.0),
        ior,
        sigma_a: Vec3::splat(0.0),
        flags,
    }
}

pub fn diffuse(reflectance: [f32; 3]) -> Material {
    surface(SURFACE_DIFFUSE, reflectance, 1.0, 0)
}

/// Asserts that two numbers differ by at most `tolerance`; NaN never passes.
#[track_caller]
pub fn assert_near(actual: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (actual - expected).abs();
    assert!(error <= tolerance, "{what}: {actual}, not {expected}: off by {error:e}, over {tolerance:e}");
}
