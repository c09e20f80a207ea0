//! Mixtures of two materials as one: of diffuse ones, and of others that differ in what light is multiplied
//! by, the sum; of one model with other parameters that of the parameters between.

use glam::Vec3;
use midway_scene::{
    ColorInput, ConductorFresnel, Material, MetallicRoughness, Roughness, ScalarInput, Surface,
};

use crate::images::{Images, Input};

/// A mixture, and whether it scatters as the sum of both.
pub(crate) struct Mixture {
    pub material: Material,
    pub is_exact: bool,
}

/// One material for a share of one and the rest of another. None where they are of different models, or where
/// their textures do not lie alike.
pub(crate) fn mixed(
    images: &mut Images,
    [first, second]: [&Material; 2],
    of_second: &Input,
) -> Option<Mixture> {
    let alike = first.scatters == second.scatters
        && first.opacity == second.opacity
        && first.normal_map == second.normal_map;
    let mut mixer = Mixer { images, of_second, is_exact: true };
    let surface = alike.then(|| mixer.surface(&first.surface, &second.surface))??;
    Some(Mixture { material: Material { surface, ..first.clone() }, is_exact: mixer.is_exact })
}

struct Mixer<'m> {
    images: &'m mut Images,
    of_second: &'m Input,
    is_exact: bool,
}

impl Mixer<'_> {
    fn surface(&mut self, first: &Surface, second: &Surface) -> Option<Surface> {
        if first == second {
            return Some(first.clone());
        }
        match (first, second) {
            (Surface::Diffuse { reflectance: a }, Surface::Diffuse { reflectance: b }) => {
                Some(Surface::Diffuse { reflectance: self.factor(a, b)? })
            }
            (
                Surface::Conductor { fresnel: f, roughness: r },
                Surface::Conductor { fresnel: g, roughness: s },
            ) => Some(Surface::Conductor { fresnel: self.fresnel(f, g)?, roughness: self.roughness(r, s)? }),
            (
                Surface::Dielectric {
                    ior: i,
                    dispersion: d,
                    reflection: f,
                    transmission: t,
                    sigma_a: a,
                    thin,
                    roughness: r,
                },
                Surface::Dielectric {
                    ior: j,
                    dispersion: e,
                    reflection: g,
                    transmission: u,
                    sigma_a: b,
                    thin: other,
                    roughness: s,
                },
            ) if thin == other => Some(Surface::Dielectric {
                ior: self.number(*i, *j)?,
                dispersion: self.number(*d, *e)?,
                reflection: self.factor(f, g)?,
                transmission: self.factor(t, u)?,
                sigma_a: self.vector(*a, *b)?,
                thin: *thin,
                roughness: self.roughness(r, s)?,
            }),
            (
                Surface::Plastic { reflectance: d, specular: f, ior: i, nonlinear, roughness: r },
                Surface::Plastic { reflectance: e, specular: g, ior: j, nonlinear: other, roughness: s },
            ) if nonlinear == other => {
                self.is_exact &= !nonlinear || d == e;
                Some(Surface::Plastic {
                    reflectance: self.factor(d, e)?,
                    specular: self.factor(f, g)?,
                    ior: self.number(*i, *j)?,
                    nonlinear: *nonlinear,
                    roughness: self.roughness(r, s)?,
                })
            }
            (Surface::MetallicRoughness(a), Surface::MetallicRoughness(b)) if a.thin == b.thin => {
                self.is_exact = false;
                Some(Surface::MetallicRoughness(Box::new(self.metallic_roughness(a, b)?)))
            }
            _ => None,
        }
    }

    fn fresnel(&mut self, first: &ConductorFresnel, second: &ConductorFresnel) -> Option<ConductorFresnel> {
        match (first, second) {
            (ConductorFresnel::Schlick { f0: a }, ConductorFresnel::Schlick { f0: b }) => {
                self.is_exact &= a == b;
                Some(ConductorFresnel::Schlick { f0: self.factor(a, b)? })
            }
            (
                ConductorFresnel::Complex { eta: n, k, tint: a },
                ConductorFresnel::Complex { eta: m, k: l, tint: b },
            ) => Some(ConductorFresnel::Complex {
                eta: self.vector(*n, *m)?,
                k: self.vector(*k, *l)?,
                tint: self.factor(a, b)?,
            }),
            _ => None,
        }
    }

    fn roughness(&mut self, first: &Roughness, second: &Roughness) -> Option<Roughness> {
        if first.squared != second.squared || first.single_bounce != second.single_bounce {
            return None;
        }
        Some(Roughness {
            along: self.scalar(&first.along, &second.along)?,
            across: self.scalar(&first.across, &second.across)?,
            ..first.clone()
        })
    }

    fn metallic_roughness(
        &mut self,
        first: &MetallicRoughness,
        second: &MetallicRoughness,
    ) -> Option<MetallicRoughness> {
        // Colours above 1 have no place in an image.
        let is_plain = first.specular_color.texture.is_none() && second.specular_color.texture.is_none();
        let specular_color = match first.specular_color == second.specular_color {
            true => first.specular_color.clone(),
            false if is_plain => self.vector(first.specular_color.value, second.specular_color.value)?.into(),
            false => return None,
        };
        let turned = (&first.clearcoat_normal, first.anisotropy_rotation, &first.anisotropy_direction)
            != (&second.clearcoat_normal, second.anisotropy_rotation, &second.anisotropy_direction);
        if turned {
            return None;
        }
        Some(MetallicRoughness {
            base_color: self.factor(&first.base_color, &second.base_color)?,
            metallic: self.scalar(&first.metallic, &second.metallic)?,
            roughness: self.scalar(&first.roughness, &second.roughness)?,
            specular: self.scalar(&first.specular, &second.specular)?,
            specular_color,
            ior: self.number(first.ior, second.ior)?,
            dispersion: self.number(first.dispersion, second.dispersion)?,
            transmission: self.scalar(&first.transmission, &second.transmission)?,
            sigma_a: self.vector(first.sigma_a, second.sigma_a)?,
            clearcoat: self.scalar(&first.clearcoat, &second.clearcoat)?,
            clearcoat_roughness: self.scalar(&first.clearcoat_roughness, &second.clearcoat_roughness)?,
            sheen_color: self.factor(&first.sheen_color, &second.sheen_color)?,
            sheen_roughness: self.scalar(&first.sheen_roughness, &second.sheen_roughness)?,
            anisotropy: self.scalar(&first.anisotropy, &second.anisotropy)?,
            ..first.clone()
        })
    }

    /// What light is multiplied by: the sum of two is that of the sum.
    fn factor(&mut self, first: &ColorInput, second: &ColorInput) -> Option<ColorInput> {
        if first == second {
            return Some(first.clone());
        }
        let inputs = [first.clone().into(), second.clone().into(), self.of_second.clone()];
        self.images.computed(&inputs, lerp)
    }

    fn scalar(&mut self, first: &ScalarInput, second: &ScalarInput) -> Option<ScalarInput> {
        if first == second {
            return Some(first.clone());
        }
        self.is_exact = false;
        let inputs = [first.clone().into(), second.clone().into(), self.of_second.clone()];
        self.images.computed_scalar(&inputs, lerp)
    }

    fn number(&mut self, first: f32, second: f32) -> Option<f32> {
        Some(self.vector(Vec3::splat(first), Vec3::splat(second))?.y)
    }

    /// Of what has no texture: between two only where the share is the same everywhere.
    fn vector(&mut self, first: Vec3, second: Vec3) -> Option<Vec3> {
        if first == second {
            return Some(first);
        }
        self.is_exact = false;
        let share = match self.of_second {
            Input::Color(ColorInput { value, texture: None }) => *value,
            Input::Scalar(ScalarInput { value, texture: None }) => Vec3::splat(*value),
            _ => return None,
        };
        Some(first + (second - first) * share.clamp(Vec3::ZERO, Vec3::ONE))
    }
}

/// Of reflectances and a share, which images times factors above 1 may exceed.
fn lerp(values: &[Vec3]) -> Vec3 {
    let [first, second, share] = [0, 1, 2].map(|i| values[i].min(Vec3::ONE));
    first + (second - first) * share
}
