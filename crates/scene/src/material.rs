//! Surfaces: how they scatter, what they emit, and where they are not there.

use glam::Vec3;

use crate::{ColorInput, ScalarInput, Texture};

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The file's name for it, or empty.
    pub name: String,
    /// How it scatters.
    pub surface: Surface,
    /// Which sides scatter; the other absorbs. Dielectrics and [`Surface::Null`] have both.
    pub scatters: Sides,
    /// Where it is there at all.
    pub opacity: Opacity,
    /// Bends the shading normal.
    pub normal_map: Option<NormalMap>,
    /// Emitted radiance, W·m⁻²·sr⁻¹; zero for none.
    pub emission: ColorInput,
    /// Which sides emit.
    pub emits: Sides,
}

impl Material {
    /// A surface that scatters on both sides and emits nothing.
    pub fn new(surface: Surface) -> Self {
        Self {
            name: String::new(),
            surface,
            scatters: Sides::Both,
            opacity: Opacity::Opaque,
            normal_map: None,
            emission: Vec3::ZERO.into(),
            emits: Sides::Front,
        }
    }

    /// The same, emitting from its front.
    #[must_use]
    pub fn emitting(mut self, radiance: Vec3) -> Self {
        self.emission = radiance.into();
        self
    }

    /// Whether it emits anything.
    pub fn is_emissive(&self) -> bool {
        self.emission.value.max_element() > 0.0
    }
}

/// Sides of a surface. The front is where triangles are counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The front alone.
    Front,
    /// Both.
    Both,
}

/// How much of a surface is there. Rays of every kind pass through the rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Opacity {
    /// All.
    Opaque,
    /// All where the input is at least the cutoff, nothing elsewhere.
    Mask(ScalarInput, f32),
    /// The input is the chance of being there.
    Blend(ScalarInput),
}

/// A tangent-space normal map: texels in [0, 1] stand for components in [-1, 1], z along the normal,
/// y up in the image (OpenGL's and glTF's sense).
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// The map.
    pub texture: Texture,
    /// Multiplies x and y.
    pub scale: f32,
}

/// How a surface scatters.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Lambertian.
    Diffuse {
        /// Albedo, in [0, 1].
        reflectance: ColorInput,
    },
    /// A metal.
    Conductor {
        /// How much is reflected.
        fresnel: ConductorFresnel,
        /// GGX; smooth where 0.
        roughness: Roughness,
    },
    /// A boundary between two dielectrics.
    Dielectric {
        /// Index of refraction inside over outside, > 0; of green where it differs by colour.
        ior: f32,
        /// 20 over the Abbe number, in [0, [`MAX_DISPERSION`]]; 0 where the index does not differ by colour.
        /// See [`Surface::ior_spread`].
        dispersion: f32,
        /// Multiplies what is reflected, in [0, 1].
        reflection: ColorInput,
        /// Multiplies what is transmitted, in [0, 1].
        transmission: ColorInput,
        /// Absorption coefficient inside, per unit length (Beer-Lambert).
        sigma_a: Vec3,
        /// A thin wall: transmits without bending and has no inside.
        thin: bool,
        /// GGX; smooth where 0.
        roughness: Roughness,
    },
    /// A diffuse base under a dielectric coat.
    Plastic {
        /// Albedo of the base, in [0, 1].
        reflectance: ColorInput,
        /// Multiplies what the coat reflects, in [0, 1].
        specular: ColorInput,
        /// Index of refraction of the coat over outside, > 0.
        ior: f32,
        /// Whether light reflected inside, base to coat and back, takes on the base's colour again.
        nonlinear: bool,
        /// GGX of the coat; smooth where 0.
        roughness: Roughness,
    },
    /// glTF's metallic-roughness model with its extensions.
    MetallicRoughness(Box<MetallicRoughness>),
    /// Nothing happens here: light goes straight on.
    Null,
}

/// Reflectance of a metal by angle.
#[derive(Clone, Debug, PartialEq)]
pub enum ConductorFresnel {
    /// Schlick's approximation.
    Schlick {
        /// Reflectance at normal incidence, in [0, 1].
        f0: ColorInput,
    },
    /// Fresnel's equations with a complex index η + ik, for each of R, G and B.
    Complex {
        /// η.
        eta: Vec3,
        /// k.
        k: Vec3,
        /// Multiplies the reflectance, in [0, 1].
        tint: ColorInput,
    },
}

/// GGX (Trowbridge-Reitz) roughness along the tangent and across it.
#[derive(Clone, Debug, PartialEq)]
pub struct Roughness {
    /// Along the tangent.
    pub along: ScalarInput,
    /// Across it.
    pub across: ScalarInput,
    /// Whether α is the square of these (perceptual roughness) or themselves.
    pub squared: bool,
    /// Whether light that meets a second facet is lost, as in models of single scattering, or goes on.
    /// Plastic always keeps it.
    pub single_bounce: bool,
}

impl Roughness {
    /// Smooth.
    pub fn smooth() -> Self {
        Self::alpha(0.0)
    }

    /// The same α all round.
    pub fn alpha(alpha: f32) -> Self {
        Self { along: alpha.into(), across: alpha.into(), squared: false, single_bounce: false }
    }

    /// Whether it is smooth everywhere.
    pub fn is_smooth(&self) -> bool {
        self.along.value == 0.0 && self.across.value == 0.0
    }
}

/// The normals of a coat.
#[derive(Clone, Debug, PartialEq)]
pub enum CoatNormal {
    /// Those of the surface below, its normal map's where it has one.
    Below,
    /// The mesh's own, by no map.
    Mesh,
    /// By a map of its own.
    Map(NormalMap),
}

/// The largest dispersion: red's index is then 1.
pub const MAX_DISPERSION: f32 = 40.0;

/// glTF 2.0's metallic-roughness model, `KHR_materials_specular`, `_ior`, `_dispersion`,
/// `_transmission`, `_volume`, `_clearcoat`, `_sheen` and `_anisotropy`. Fields are theirs; factors are in [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Albedo of the base, or F0 of the metal.
    pub base_color: ColorInput,
    /// 0 a dielectric, 1 a metal.
    pub metallic: ScalarInput,
    /// Perceptual: α is its square.
    pub roughness: ScalarInput,
    /// Strength of the dielectric's reflection.
    pub specular: ScalarInput,
    /// Its colour at normal incidence.
    pub specular_color: ColorInput,
    /// Index of refraction, inside over outside; of green where it differs by colour.
    pub ior: f32,
    /// As a dielectric's; of no effect where it is thin or does not transmit.
    pub dispersion: f32,
    /// How much of the base transmits in place of scattering diffusely.
    pub transmission: ScalarInput,
    /// Transmits without bending.
    pub thin: bool,
    /// Absorption coefficient inside, per unit length.
    pub sigma_a: Vec3,
    /// Strength of a clear coat of index 1.5.
    pub clearcoat: ScalarInput,
    /// Its perceptual roughness.
    pub clearcoat_roughness: ScalarInput,
    /// Its normals.
    pub clearcoat_normal: CoatNormal,
    /// Colour of the sheen; black for none.
    pub sheen_color: ColorInput,
    /// Its perceptual roughness.
    pub sheen_roughness: ScalarInput,
    /// How much longer highlights are along the tangent.
    pub anisotropy: ScalarInput,
    /// Turns the tangent, radians, counter-clockwise.
    pub anisotropy_rotation: f32,
    /// The direction that is turned in place of the tangent: red and green are its parts along the
    /// tangent and the bitangent, 0 to 1 standing for -1 to 1.
    pub anisotropy_direction: Option<Texture>,
}

impl Default for MetallicRoughness {
    /// A white dielectric of index 1.5, as rough as can be.
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE.into(),
            metallic: 0.0.into(),
            roughness: 1.0.into(),
            specular: 1.0.into(),
            specular_color: Vec3::ONE.into(),
            ior: 1.5,
            dispersion: 0.0,
            transmission: 0.0.into(),
            thin: true,
            sigma_a: Vec3::ZERO,
            clearcoat: 0.0.into(),
            clearcoat_roughness: 0.0.into(),
            clearcoat_normal: CoatNormal::Below,
            sheen_color: Vec3::ZERO.into(),
            sheen_roughness: 0.0.into(),
            anisotropy: 0.0.into(),
            anisotropy_rotation: 0.0,
            anisotropy_direction: None,
        }
    }
}

impl Surface {
    /// Lambertian of one colour.
    pub fn diffuse(reflectance: Vec3) -> Self {
        Self::Diffuse { reflectance: reflectance.into() }
    }

    /// A perfect mirror: reflectance at normal incidence, Schlick towards 1.
    pub fn mirror(f0: Vec3) -> Self {
        Self::Conductor {
            fresnel: ConductorFresnel::Schlick { f0: f0.into() },
            roughness: Roughness::smooth(),
        }
    }

    /// Smooth clear glass.
    pub fn glass(ior: f32) -> Self {
        Self::Dielectric {
            ior,
            dispersion: 0.0,
            reflection: Vec3::ONE.into(),
            transmission: Vec3::ONE.into(),
            sigma_a: Vec3::ZERO,
            thin: false,
            roughness: Roughness::smooth(),
        }
    }

    /// How far the index of refraction of blue (the F line, 486.1 nm) is above that of green (d, 587.6 nm),
    /// and red's (C, 656.3 nm) below it: `KHR_materials_dispersion`'s (n - 1) · 0.025 · dispersion. 0 for
    /// what has no inside, and for indices below 1, whose rarer side is air.
    pub fn ior_spread(&self) -> f32 {
        let (ior, dispersion) = match self {
            Self::Dielectric { ior, dispersion, .. } => (*ior, *dispersion),
            Self::MetallicRoughness(model) => (model.ior, model.dispersion),
            _ => return 0.0,
        };
        if self.has_inside() { (ior - 1.0).max(0.0) * 0.025 * dispersion } else { 0.0 }
    }

    /// Whether it has an inside that light may travel in.
    pub fn has_inside(&self) -> bool {
        match self {
            Self::Dielectric { thin, .. } => !thin,
            Self::MetallicRoughness(model) => !model.thin && model.transmission.value > 0.0,
            _ => false,
        }
    }
}
