//! pbrt-v4's materials. Those of v3 are in `materials_v3`.

use std::collections::{BTreeMap, HashMap};

use glam::Vec3;
use midway_scene::{
    ColorInput, ConductorFresnel, Material, MetallicRoughness, NormalMap, Roughness, Surface,
};

use super::{
    colours::{Reader, Use, Version},
    lex::shortened,
    materials_v3,
    params::Params,
    textures::{Scalar, Textures},
};
use crate::{
    ImportError, Place, default_material,
    images::{Encoding, Input},
    metals::{self, ComplexIor},
    mixture,
    warning::{WarningKind, Warnings},
};

/// Materials read so far. The first is the one in force before any is named.
pub(super) struct Materials {
    pub list: Vec<Material>,
    named: HashMap<String, usize>,
    /// By index: those that are named and not defined yet, as v4 allows, with where they are named first.
    awaited: BTreeMap<usize, (String, Place)>,
}

impl Materials {
    pub fn new() -> Self {
        let grey = Material::new(Surface::diffuse(Vec3::splat(0.5)));
        Self { list: vec![grey], named: HashMap::new(), awaited: BTreeMap::new() }
    }

    /// Adds a definition under a name or none, or in its place where it was awaited; returns its index.
    pub fn define(&mut self, name: Option<&str>, material: Material) -> usize {
        let material = Material { name: name.unwrap_or_default().to_owned(), ..material };
        let reserved = name.and_then(|name| self.named.get(name)).copied();
        if let Some(index) = reserved.filter(|index| self.awaited.contains_key(index)) {
            self.fill(index, material);
            return index;
        }
        let index = self.list.len();
        self.list.push(material);
        if let Some(name) = name {
            self.named.insert(name.to_owned(), index);
        }
        index
    }

    /// Puts a definition in the place that was kept for it.
    pub fn fill(&mut self, index: usize, material: Material) {
        self.awaited.remove(&index);
        let name = std::mem::take(&mut self.list[index].name);
        self.list[index] = Material { name, ..material };
    }

    /// Keeps a place for a definition, grey until then, under a name or none.
    pub fn reserve(&mut self, name: Option<&str>, place: &Place) -> usize {
        let known = name.and_then(|name| self.named.get(name)).copied();
        let index = known.filter(|index| self.is_awaited(*index));
        let index = index.unwrap_or_else(|| self.define(name, default_material()));
        self.awaited.entry(index).or_insert_with(|| (name.unwrap_or_default().to_owned(), place.clone()));
        index
    }

    /// Whether an index is one of a definition that is still to come.
    pub fn is_awaited(&self, index: usize) -> bool {
        self.awaited.contains_key(&index)
    }

    /// Whether a name is one of a material that is there.
    pub fn is_defined(&self, name: &str) -> bool {
        self.named.get(name).is_some_and(|index| !self.is_awaited(*index))
    }

    /// The index of a name that is known.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.named.get(name).copied()
    }

    /// One by name. Where there is none yet, a place for it in v4; in v3 grey, and a warning.
    pub fn named(&mut self, name: &str, place: &Place, version: Version, warnings: &mut Warnings) -> usize {
        match self.named.get(name) {
            Some(&known) => known,
            None if version == Version::V4 => self.reserve(Some(name), place),
            None => {
                warn_of_undefined(name, place, warnings);
                self.define(Some(name), default_material())
            }
        }
    }

    /// Lists what was named and never defined.
    pub fn warn_of_awaited(&self, warnings: &mut Warnings) {
        for (name, place) in self.awaited.values() {
            warn_of_undefined(name, place, warnings);
        }
    }
}

fn warn_of_undefined(name: &str, place: &Place, warnings: &mut Warnings) {
    let message = format!("the material \"{}\" is not defined: rendered as diffuse grey", shortened(name));
    warnings.add(WarningKind::Approximation, place.short(), message);
}

/// A material being read.
pub(super) struct Definition<'a> {
    pub params: &'a Params,
    pub reader: &'a Reader<'a>,
    pub textures: &'a mut Textures,
    pub materials: &'a mut Materials,
    pub warnings: &'a mut Warnings,
}

impl Definition<'_> {
    /// The material of a type by that type's name.
    pub fn read(mut self, kind: &str) -> Result<Material, ImportError> {
        let surface = match self.surface_v4(kind)? {
            Some(surface) => surface,
            None => match materials_v3::surface(&mut self, kind)? {
                Some(surface) => surface,
                None => self.unknown(kind)?,
            },
        };
        let mut material = Material::new(surface);
        if kind == "mix" {
            material = self.mix()?;
        }
        if kind == "uber" {
            material.opacity = materials_v3::opacity(&mut self)?;
        }
        if let Some(file) = self.params.string("normalmap")? {
            let (params, reader) = (self.params, self.reader);
            let texture = self.textures.plain(file, Encoding::Normal, params, reader, self.warnings)?;
            material.normal_map = texture.map(|texture| NormalMap { texture, scale: 1.0 });
        }
        if self.params.has("displacement") || self.params.has("bumpmap") {
            self.warn(WarningKind::Texture, "displacements and bump maps are not used");
        }
        self.params.warn_of_unused(&format!("materials \"{kind}\""), self.warnings);
        Ok(material)
    }

    pub fn warn(&mut self, kind: WarningKind, message: impl Into<String>) {
        self.warnings.add(kind, self.params.place.short(), message);
    }

    pub fn approximated(&mut self, message: impl Into<String>) {
        self.warn(WarningKind::Approximation, message);
    }

    pub fn albedo(&mut self, name: &str, default: f32) -> Result<ColorInput, ImportError> {
        self.textures.albedo(self.params, name, default, self.reader, self.warnings)
    }

    pub fn scalar(&mut self, name: &str) -> Result<Option<Scalar>, ImportError> {
        self.textures.scalar(self.params, name, self.warnings)
    }

    fn surface_v4(&mut self, kind: &str) -> Result<Option<Surface>, ImportError> {
        Ok(Some(match kind {
            "" | "interface" | "none" => Surface::Null,
            "diffuse" => Surface::Diffuse { reflectance: self.albedo("reflectance", 0.5)? },
            "coateddiffuse" => self.coated_diffuse()?,
            "conductor" => {
                let roughness = self.roughness("", 0.0)?;
                Surface::Conductor { fresnel: self.fresnel("")?, roughness }
            }
            "coatedconductor" => self.coated_conductor()?,
            "dielectric" => self.dielectric(false)?,
            "thindielectric" => self.dielectric(true)?,
            "diffusetransmission" => {
                self.params.ignore(&["transmittance", "scale"]);
                self.approximated("\"diffusetransmission\" is rendered without what it transmits");
                Surface::Diffuse { reflectance: self.albedo("reflectance", 0.25)? }
            }
            // Read by `mix`, which replaces all of it.
            "mix" => Surface::Null,
            _ => return Ok(None),
        }))
    }

    /// α of a microfacet surface: `roughness`, or `uroughness` and `vroughness`, after a prefix;
    /// by pbrt-v4's √ unless `remaproughness` says otherwise.
    fn roughness(&mut self, prefix: &str, default: f32) -> Result<Roughness, ImportError> {
        self.roughness_by(prefix, default, f32::sqrt)
    }

    pub fn roughness_by(
        &mut self,
        prefix: &str,
        default: f32,
        remap: impl Fn(f32) -> f32,
    ) -> Result<Roughness, ImportError> {
        let [u, v] = ["u", "v"].map(|axis| format!("{prefix}{axis}roughness"));
        let is_isotropic = !self.params.has(&u) && !self.params.has(&v);
        let all = self.scalar(&format!("{prefix}roughness"))?.unwrap_or(default.into());
        let along = self.scalar(&u)?.unwrap_or(all.clone());
        let across = self.scalar(&v)?.unwrap_or(all);
        let remaps = self.params.bool_or("remaproughness", true)?;
        let mut map =
            |scalar| self.textures.map(scalar, |x| if remaps { remap(x.max(0.0)) } else { x.max(0.0) });
        let along_mapped = map(&along);
        // One image serves both.
        let across = if is_isotropic { along_mapped.clone() } else { map(&across) };
        let along = along_mapped;
        Ok(Roughness { along, across, squared: false, single_bounce: true })
    }

    fn coated_diffuse(&mut self) -> Result<Surface, ImportError> {
        self.ignore_coat();
        Ok(Surface::Plastic {
            reflectance: self.albedo("reflectance", 0.5)?,
            specular: Vec3::ONE.into(),
            ior: self.reader.ior(self.params, &["eta"], 1.5)?,
            nonlinear: true,
            roughness: self.roughness("", 0.0)?,
        })
    }

    /// What the random walk between a coat and its base takes; a medium between the two is said.
    fn ignore_coat(&mut self) {
        self.params.ignore(&["thickness", "maxdepth", "nsamples", "g"]);
        if self.params.has("albedo") {
            self.approximated("the medium within a coat (\"albedo\") is left out");
        }
    }

    /// η and k by a prefix, or a reflectance at normal incidence.
    fn fresnel(&mut self, prefix: &str) -> Result<ConductorFresnel, ImportError> {
        let [eta, k, reflectance] = ["eta", "k", "reflectance"].map(|name| match name {
            "reflectance" => name.to_owned(),
            _ => format!("{prefix}{name}"),
        });
        if self.params.has(&reflectance) {
            let f0 = self.albedo(&reflectance, 0.0)?;
            let plain = f0.texture.is_none();
            let fresnel = fresnel_of_reflectance(f0.value);
            return Ok(if plain { fresnel } else { ConductorFresnel::Schlick { f0 } });
        }
        let ComplexIor { eta, k } = self.complex_ior(&eta, &k)?;
        Ok(ConductorFresnel::Complex { eta, k, tint: Vec3::ONE.into() })
    }

    /// Copper where nothing is said.
    pub fn complex_ior(&mut self, eta: &str, k: &str) -> Result<ComplexIor, ImportError> {
        let copper = metals::metal("Cu").unwrap_or(ComplexIor { eta: Vec3::ONE, k: Vec3::ZERO });
        Ok(ComplexIor {
            eta: self.reader.colour_or(self.params, eta, Use::Unbounded, copper.eta)?,
            k: self.reader.colour_or(self.params, k, Use::Unbounded, copper.k)?,
        })
    }

    /// A metal under a clear coat, by glTF's model.
    fn coated_conductor(&mut self) -> Result<Surface, ImportError> {
        self.ignore_coat();
        self.approximated("\"coatedconductor\" is rendered as a metal under glTF's clear coat");
        let coat = self.reader.ior(self.params, &["interface.eta"], 1.5)?;
        let base_color = match self.fresnel("conductor.")? {
            ConductorFresnel::Schlick { f0 } => f0,
            ConductorFresnel::Complex { eta, k, .. } => normal_reflectance(eta / coat, k / coat).into(),
        };
        // glTF's roughness is the root of α, which is the root of pbrt's.
        let fourth_root = |x: f32| x.sqrt().sqrt();
        let metal = self.roughness_by("conductor.", 0.0, fourth_root)?.along;
        let clear = self.roughness_by("interface.", 0.0, fourth_root)?.along;
        Ok(Surface::MetallicRoughness(Box::new(MetallicRoughness {
            base_color,
            metallic: 1.0.into(),
            roughness: metal,
            clearcoat: 1.0.into(),
            clearcoat_roughness: clear,
            ..MetallicRoughness::default()
        })))
    }

    fn dielectric(&mut self, thin: bool) -> Result<Surface, ImportError> {
        Ok(Surface::Dielectric {
            ior: self.reader.ior(self.params, &["eta"], 1.5)?,
            dispersion: 0.0,
            reflection: Vec3::ONE.into(),
            transmission: Vec3::ONE.into(),
            sigma_a: Vec3::ZERO,
            thin,
            roughness: if thin { Roughness::smooth() } else { self.roughness("", 0.0)? },
        })
    }

    /// Between two named materials, by `materials` (v4) or `namedmaterial1` and `2` (v3).
    fn mix(&mut self) -> Result<Material, ImportError> {
        let names: Vec<String> = match self.params.strings("materials")? {
            Some(names) => names.to_vec(),
            None => ["namedmaterial1", "namedmaterial2"]
                .into_iter()
                .map(|name| Ok(self.params.string(name)?.unwrap_or_default().to_owned()))
                .collect::<Result<_, ImportError>>()?,
        };
        let [first, second] = &names[..] else {
            return Err(self.params.malformed("a \"mix\" is of two materials"));
        };
        let [a, b] = [first, second].map(|name| {
            let (place, version) = (&self.params.place, self.reader.version);
            let index = self.materials.named(name, place, version, self.warnings);
            self.materials.list[index].clone()
        });
        let amount: Input = match self.params.texture("amount")? {
            Some(_) if self.reader.version == Version::V4 => {
                self.scalar("amount")?.unwrap_or(0.5.into()).input.into()
            }
            _ => self.albedo("amount", 0.5)?.into(),
        };
        // How much of the second there is in v4, and of the first in v3.
        let [a, b] = if self.params.has("materials") { [a, b] } else { [b, a] };
        if let Some(mixture) = mixture::mixed(&mut self.textures.images, [&a, &b], &amount) {
            if !mixture.is_exact {
                self.approximated("mixtures of materials of one type are rendered with mixed parameters");
            }
            return Ok(Material { name: String::new(), ..mixture.material });
        }
        self.approximated("mixtures of materials are rendered as the one there is more of");
        let of_second = match amount {
            Input::Color(color) => color.value.y,
            Input::Scalar(scalar) => scalar.value,
        };
        Ok(if of_second <= 0.5 { a } else { b })
    }

    fn unknown(&mut self, kind: &str) -> Result<Surface, ImportError> {
        let message = format!("materials \"{}\" are rendered as diffuse", shortened(kind));
        self.approximated(message);
        for name in ["reflectance", "color", "Kd"] {
            if self.params.has(name) {
                return Ok(Surface::Diffuse { reflectance: self.albedo(name, 0.5)? });
            }
        }
        Ok(Surface::diffuse(Vec3::splat(0.5)))
    }
}

/// η = 1 and the k that reflects so much at normal incidence, as pbrt-v4 has it.
fn fresnel_of_reflectance(reflectance: Vec3) -> ConductorFresnel {
    let r = reflectance.clamp(Vec3::ZERO, Vec3::splat(0.9999));
    let k = r.map(|r| 2.0 * (r / (1.0 - r)).sqrt());
    ConductorFresnel::Complex { eta: Vec3::ONE, k, tint: Vec3::ONE.into() }
}

/// Of a metal in air: ((η - 1)² + k²) / ((η + 1)² + k²).
fn normal_reflectance(eta: Vec3, k: Vec3) -> Vec3 {
    let k2 = k * k;
    let below = (eta + 1.0) * (eta + 1.0) + k2;
    (((eta - 1.0) * (eta - 1.0) + k2) / below).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_there_and_back() {
        let wanted = Vec3::new(0.0, 0.5, 0.95);
        let ConductorFresnel::Complex { eta, k, .. } = fresnel_of_reflectance(wanted) else {
            panic!("not complex");
        };
        assert!((normal_reflectance(eta, k) - wanted).abs().max_element() <= 1e-5);
    }
}
