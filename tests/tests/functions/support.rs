//! Random inputs, and the way between the kernels' vectors and f64.

use std::ops::{Add, Mul};

use glam::DVec3;
use midway_kernels::{
    ALBEDO_TABLES,
    native::lib::{self, Albedos, Curve, Frame, HeldBack, Material, RawMaterial},
};
use wgsl_cpu::runtime::{Vec2, Vec3, Vec4, dot};

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

/// A record of a kind with everything white, smooth and plain.
pub fn raw(kind: u32) -> RawMaterial {
    RawMaterial {
        kind,
        flags: 0,
        color: Vec3::splat(1.0),
        emission: Vec3::splat(0.0),
        ior: 1.5,
        specular_color: Vec3::splat(1.0),
        specular: 1.0,
        roughness: Vec2::splat(0.0),
        metallic: 0.0,
        transmission: 0.0,
        eta_or_sheen: Vec4::splat(0.0),
        k_or_coat: Vec3::splat(0.0),
        rotation: Vec2::new(1.0, 0.0),
    }
}

/// A material of a record, with curves from the tables as `bindings/material.wgsl` reads them.
pub fn finish(raw: RawMaterial) -> Material {
    let both = lib::interface_alpha(raw);
    let sheen = alpha_curve(lib::CURVE_SHEEN, lib::sheen_alpha(raw));
    let of_coat = |curve| alpha_curve(curve, lib::coat_alpha(raw));
    let coat = lib::schlick_albedo(lib::COAT_F0, of_coat(lib::CURVE_LOSS), of_coat(lib::CURVE_GRAZING));
    let mut albedos = Albedos { sheen, coat, ..lib::no_albedos() };
    if both.x > 0.0 {
        if lib::holds_back(raw) {
            albedos.held = held_back(both, lib::held_at_nodes(raw, albedos));
        }
        if lib::has_stretched_curves(both, raw.flags) {
            return lib::finish_material(raw, stretched(albedos, both));
        }
        if lib::has_solid_losses(both, raw.flags) {
            return lib::finish_material(raw, solid(albedos, both, raw.ior));
        }
        let alpha = 0.5 * (both.x + both.y);
        let [front, back] = if raw.ior > 1.0 {
            [lib::CURVE_RARE_LOSS, lib::CURVE_DENSE_LOSS]
        } else {
            [lib::CURVE_DENSE_LOSS, lib::CURVE_RARE_LOSS]
        };
        (albedos.a, albedos.b) = if lib::needs_dielectric_losses(raw) {
            (index_curve(front, alpha, raw.ior), index_curve(back, alpha, raw.ior))
        } else if raw.kind == lib::SURFACE_PLASTIC {
            let single = lib::is_single_bounce(raw.flags);
            if single {
                albedos.across = index_curve(lib::CURVE_DENSE_LOSS, alpha, raw.ior);
            }
            let loss =
                if single { index_curve(front, alpha, raw.ior) } else { alpha_curve(lib::CURVE_LOSS, alpha) };
            (loss, index_curve(lib::CURVE_RARE_REFLECTED, alpha, raw.ior))
        } else {
            (alpha_curve(lib::CURVE_LOSS, alpha), alpha_curve(lib::CURVE_GRAZING, alpha))
        };
    }
    lib::finish_material(raw, albedos)
}

fn row(row: u32) -> Vec4<f32> {
    let float = |i: u32| {
        let at = (16 * row + 4 * i) as usize;
        f32::from_le_bytes(ALBEDO_TABLES[at..at + 4].try_into().expect("4 bytes"))
    };
    Vec4::new(float(0), float(1), float(2), float(3))
}

fn table(at: u32) -> Curve {
    Curve { low: row(at), high: row(at + 1) }
}

/// The third table between its entries.
fn stretched(plain: Albedos, alpha: Vec2<f32>) -> Albedos {
    let number = |word: u32| {
        bilinear(lib::stretched_place(alpha), [lib::ALBEDO_ALPHAS, lib::ALBEDO_RATIOS], |alpha, ratio| {
            row(lib::STRETCHED_AT + (ratio * lib::ALBEDO_ALPHAS + alpha) * lib::STRETCHED_STRIDE + word)
        })
    };
    let curve = |word| Curve { low: number(word), high: number(word + 1) };
    Albedos { a: curve(0), across: curve(2), b: curve(4), stretch: number(6), ..plain }
}

/// The fourth.
fn solid(plain: Albedos, alpha: Vec2<f32>, ior: f32) -> Albedos {
    let place = lib::solid_place(alpha, ior).to_array();
    let first = |axis: usize, n: u32| (place[axis] as u32).min(n - 2);
    let first = [first(0, lib::SOLID_ALPHAS), first(1, lib::SOLID_INDICES), first(2, lib::SOLID_RATIOS)];
    let number = |word: u32| {
        let corner = |i: u32, j: u32, k: u32| {
            let step = [i, j, k];
            let weight = |axis: usize| {
                let t = place[axis] - first[axis] as f32;
                if step[axis] == 1 { t } else { 1.0 - t }
            };
            let entry =
                ((first[0] + i) * lib::SOLID_INDICES + first[1] + j) * lib::SOLID_RATIOS + first[2] + k;
            row(lib::SOLID_AT + entry * lib::SOLID_STRIDE + word) * (weight(0) * weight(1) * weight(2))
        };
        let pair = |i, j| corner(i, j, 0) + corner(i, j, 1);
        pair(0, 0) + pair(0, 1) + (pair(1, 0) + pair(1, 1))
    };
    let curve = |word| Curve { low: number(word), high: number(word + 1) };
    Albedos {
        a: curve(0),
        b: curve(2),
        across: curve(4),
        dense_low: curve(6),
        dense_mid: curve(8),
        dense_high: curve(10),
        dense_across: number(12),
        stretch: number(13),
        ..plain
    }
}

/// The fifth.
fn held_back(alpha: Vec2<f32>, at_nodes: Vec4<f32>) -> HeldBack {
    let number = |word: u32| {
        bilinear(lib::held_place(alpha), [lib::HELD_ALPHAS, lib::HELD_RATIOS], |alpha, ratio| {
            let factors = row(lib::HELD_AT + (alpha * lib::HELD_RATIOS + ratio) * lib::HELD_STRIDE + word);
            dot(factors, at_nodes)
        })
    };
    let powers = |function| {
        Vec4::new(number(function), number(function + 3), number(function + 6), number(function + 9))
    };
    HeldBack { all: powers(0), across: powers(1), blended: powers(2) }
}

/// What a table of that many columns and rows says between its entries.
fn bilinear<T: Add<Output = T> + Mul<f32, Output = T>>(
    place: Vec2<f32>,
    sizes: [u32; 2],
    entry: impl Fn(u32, u32) -> T,
) -> T {
    let [x, y] = [(place.x as u32).min(sizes[0] - 2), (place.y as u32).min(sizes[1] - 2)];
    let [t, u] = [place.x - x as f32, place.y - y as f32];
    let between = |y| entry(x, y) * (1.0 - t) + entry(x + 1, y) * t;
    between(y) * (1.0 - u) + between(y + 1) * u
}

fn between(place: f32, entries: u32, entry: impl Fn(u32) -> Curve) -> Curve {
    let first = (place as u32).min(entries - 2);
    lib::blend_curves(entry(first), entry(first + 1), place - first as f32)
}

fn alpha_curve(curve: u32, alpha: f32) -> Curve {
    let entry = |i| table((i * lib::N_ALPHA_CURVES + curve) * 2);
    between(lib::alpha_place(alpha), lib::ALBEDO_ALPHAS, entry)
}

fn index_curve(curve: u32, alpha: f32, ior: f32) -> Curve {
    let at = |i: u32, j: u32| {
        table(lib::INDEX_CURVES_AT + ((i * lib::ALBEDO_ALPHAS + j) * lib::N_INDEX_CURVES + curve) * 2)
    };
    between(lib::index_place(ior), lib::ALBEDO_INDICES, |i| {
        between(lib::alpha_place(alpha), lib::ALBEDO_ALPHAS, |j| at(i, j))
    })
}

pub fn diffuse(reflectance: [f32; 3]) -> Material {
    finish(RawMaterial { color: Vec3::from(reflectance), ..raw(lib::SURFACE_DIFFUSE) })
}

/// Smooth metal by Schlick.
pub fn mirror(f0: [f32; 3]) -> Material {
    finish(RawMaterial { color: Vec3::from(f0), ..raw(lib::SURFACE_CONDUCTOR) })
}

/// Smooth solid glass that tints what it transmits.
pub fn glass(tint: [f32; 3], ior: f32) -> Material {
    let flags = lib::MATERIAL_INSIDE;
    finish(RawMaterial { color: Vec3::from(tint), ior, flags, ..raw(lib::SURFACE_DIELECTRIC) })
}

/// A smooth sheet of it.
pub fn sheet(tint: [f32; 3], ior: f32) -> Material {
    finish(RawMaterial { color: Vec3::from(tint), ior, ..raw(lib::SURFACE_DIELECTRIC) })
}

/// A frame of normals; its tangent is perpendicular to ns, and the coat's normal leans to the other side.
pub fn frame(ng: DVec3, ns: DVec3) -> Frame {
    Frame {
        ng: single(ng),
        ns: single(ns),
        tangent: single(ns.any_orthonormal_vector()),
        bitangent_sign: 1.0,
        coat_ns: single(2.0 * ng.dot(ns) * ng - ns),
    }
}

/// Asserts that two numbers differ by at most `tolerance`; NaN never passes.
#[track_caller]
pub fn assert_near(actual: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (actual - expected).abs();
    assert!(error <= tolerance, "{what}: {actual}, not {expected}: off by {error:e}, over {tolerance:e}");
}

/// f of a pair of directions, without densities.
pub fn bsdf_eval(material: Material, place: Frame, wo: Vec3<f32>, wi: Vec3<f32>, mode: u32) -> Vec3<f32> {
    lib::bsdf_terms(material, place, wo, wi, mode).f
}

/// The density of wi given wo on a path of this mode.
pub fn bsdf_pdf(material: Material, place: Frame, wo: Vec3<f32>, wi: Vec3<f32>, mode: u32) -> f32 {
    lib::bsdf_terms(material, place, wo, wi, mode).pdf_fwd
}
