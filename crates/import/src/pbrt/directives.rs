//! The directives, one by one.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    rc::Rc,
};

use glam::{DMat4, DVec3, Vec3};
use midway_scene::{Material, Opacity, ScalarInput, Scene, Surface};

use super::{
    camera::{Film, View},
    colours::{ColourSpace, Reader, Use, Version},
    files,
    later::Later,
    lex::{Lexer, Token, shortened, shown},
    lights::{self, Found},
    materials::{self, Materials},
    params::{self, Params},
    shapes,
    state::{AreaLight, Stack, State, look_at},
    textures::Textures,
    world::{self, Look, World},
};
use crate::{
    ImportError, Place,
    files::SceneFolder,
    warning::{WarningKind, Warnings},
};

/// Files within files.
const MAX_INCLUDE_DEPTH: usize = 32;
/// Files that may be included, each as often as it is.
const MAX_INCLUDES: usize = 1 << 16;
/// Bytes that may be read by including, each file as often as it is.
const MAX_INCLUDED_BYTES: u64 = 1 << 32;
/// v3 lets through only what is exactly 0: less than a step of 16 bits.
const V3_ALPHA_CUTOFF: f32 = 1e-5;

/// Reads directives and keeps what they have made.
pub(super) struct Interpreter<'w> {
    folder: SceneFolder,
    version: Version,
    pub(super) warnings: &'w mut Warnings,
    pub(super) state: State,
    stack: Stack,
    textures: Textures,
    pub(super) materials: Materials,
    pub(super) world: World,
    /// Absorption coefficients of named media.
    media: HashMap<String, Vec3>,
    coordinate_systems: HashMap<String, DMat4>,
    pub(super) later: Later,
    n_area_lights: usize,
    in_world: bool,
    /// `WorldEnd` has been met.
    ended: bool,
    open_files: Vec<PathBuf>,
    n_includes: usize,
    included_bytes: u64,
}

/// The numbers of `m`, 16 of them, column by column.
fn matrix(numbers: [f64; 16]) -> DMat4 {
    DMat4::from_cols_array(&numbers)
}

impl<'w> Interpreter<'w> {
    pub fn new(folder: SceneFolder, version: Version, warnings: &'w mut Warnings) -> Self {
        Self {
            folder,
            version,
            warnings,
            state: State::new(),
            stack: Stack::default(),
            textures: Textures::default(),
            materials: Materials::new(),
            world: World::default(),
            media: HashMap::new(),
            coordinate_systems: HashMap::new(),
            later: Later::default(),
            n_area_lights: 0,
            in_world: false,
            ended: false,
            open_files: Vec::new(),
            n_includes: 0,
            included_bytes: 0,
        }
    }

    /// Reads the scene's own file.
    pub fn main(&mut self, path: &Path, text: &str) -> Result<(), ImportError> {
        self.open_files.extend(path.canonicalize());
        self.run(&mut Lexer::new(path, text))
    }

    pub fn finish(mut self, path: &Path) -> Result<Scene, ImportError> {
        if !self.stack.is_empty() {
            let message = "a block is open at the end of the file";
            self.warnings.add(WarningKind::Repaired, Place::new(path, "").short(), message);
        }
        self.define_mixtures()?;
        self.materials.warn_of_awaited(self.warnings);
        self.dress_later();
        let film = self.world.film.unwrap_or(Film::default_of(self.version));
        let mut scene = self.world.finish(film, path)?;
        scene.images = self.textures.images.decode(self.warnings);
        Ok(scene)
    }

    fn run(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        while !self.ended {
            match lexer.next()? {
                None => return Ok(()),
                Some(Token::Word(directive)) => self.directive(directive, lexer)?,
                Some(other) => {
                    return Err(
                        lexer.malformed(format!("a directive is expected instead of {}", shown(&other)))
                    );
                }
            }
        }
        Ok(())
    }

    fn directive(&mut self, directive: &str, lexer: &mut Lexer) -> Result<(), ImportError> {
        if self.transform(directive, lexer)? || self.block(directive, lexer)? {
            return Ok(());
        }
        match directive {
            "Include" | "Import" => self.include(directive, lexer),
            "Camera" => self.camera(lexer),
            "Film" => {
                let (kind, params) = named(lexer)?;
                if kind == "image" {
                    self.version = Version::V3;
                }
                self.world.film = Some(Film::read(&params, self.version, self.warnings)?);
                Ok(())
            }
            // How an image is estimated is not for the scene to say.
            "Sampler" | "PixelFilter" | "Integrator" | "Accelerator" | "SurfaceIntegrator"
            | "VolumeIntegrator" | "Renderer" => named(lexer).map(drop),
            "Option" => {
                lexer.string()?;
                params::skip_value(lexer)
            }
            "ColorSpace" => {
                let name = lexer.string()?;
                let known = ColourSpace::named(&name);
                let unknown = || format!("the colour space \"{}\" is not known", shortened(&name));
                self.state.colour_space = known.ok_or_else(|| lexer.malformed(unknown()))?;
                Ok(())
            }
            "Attribute" => {
                let (target, params) = named(lexer)?;
                self.state.add_defaults(&target, params);
                Ok(())
            }
            "ReverseOrientation" => {
                self.state.reverse_orientation = !self.state.reverse_orientation;
                Ok(())
            }
            "Texture" => self.texture(lexer),
            "Material" | "MakeNamedMaterial" => self.material(directive, lexer),
            "NamedMaterial" => {
                let name = lexer.string()?.into_owned();
                let place = lexer.place();
                self.state.material = self.materials.named(&name, &place, self.version, self.warnings);
                Ok(())
            }
            "LightSource" => self.light(lexer),
            "AreaLightSource" => self.area_light(lexer),
            "Shape" => self.shape(lexer),
            "MakeNamedMedium" => self.medium(lexer),
            "MediumInterface" => {
                self.state.inside = lexer.string()?.into();
                if matches!(lexer.peek()?, Some(Token::Quoted(_))) {
                    lexer.string()?;
                }
                Ok(())
            }
            other => Err(lexer.malformed(format!("{} is not a directive", shortened(other)))),
        }
    }

    /// Those that change the current transform; false where it is none of them.
    fn transform(&mut self, directive: &str, lexer: &mut Lexer) -> Result<bool, ImportError> {
        match directive {
            "Identity" => self.state.set(DMat4::IDENTITY),
            "Translate" => self.state.concat(DMat4::from_translation(lexer.numbers::<3>()?.into())),
            "Scale" => self.state.concat(DMat4::from_scale(lexer.numbers::<3>()?.into())),
            "Rotate" => {
                let [angle, x, y, z] = lexer.numbers()?;
                let axis = DVec3::new(x, y, z).try_normalize();
                let axis = axis.ok_or_else(|| lexer.malformed("the axis of Rotate has no direction"))?;
                self.state.concat(DMat4::from_axis_angle(axis, angle.to_radians()));
            }
            "LookAt" => {
                let looked = look_at(lexer.numbers()?);
                self.state.concat(looked.ok_or_else(|| lexer.malformed("LookAt has no direction"))?);
            }
            "Transform" => self.state.set(matrix(lexer.numbers()?)),
            "ConcatTransform" => self.state.concat(matrix(lexer.numbers()?)),
            "CoordinateSystem" => {
                self.coordinate_systems.insert(lexer.string()?.into_owned(), self.state.ctm);
            }
            "CoordSysTransform" => {
                let name = lexer.string()?;
                match self.coordinate_systems.get(&*name) {
                    Some(&ctm) => self.state.set(ctm),
                    None => {
                        let problem =
                            format!("the coordinate system \"{}\" is not defined", shortened(&name));
                        return Err(lexer.malformed(problem));
                    }
                }
            }
            "ActiveTransform" => {
                let which = match lexer.required("All, StartTime or EndTime")? {
                    Token::Word(word) => word.to_owned(),
                    other => shown(&other),
                };
                self.state.at_start = which != "EndTime";
                self.warn_of_motion(lexer);
            }
            "TransformTimes" => {
                lexer.numbers::<2>()?;
                self.warn_of_motion(lexer);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn warn_of_motion(&mut self, lexer: &Lexer) {
        let message = "motion is not rendered: everything stays where it is first";
        self.warnings.add(WarningKind::Animation, lexer.place().short(), message);
    }

    /// Those that open and close blocks; false where it is none of them.
    fn block(&mut self, directive: &str, lexer: &mut Lexer) -> Result<bool, ImportError> {
        let place = none(lexer);
        match directive {
            "AttributeBegin" => self.stack.push_attributes(&self.state, &place)?,
            "AttributeEnd" => self.stack.pop_attributes(&mut self.state, &place)?,
            "TransformBegin" => self.stack.push_transform(&self.state, &place)?,
            "TransformEnd" => self.stack.pop_transform(&mut self.state, &place)?,
            "ObjectBegin" => {
                self.world.begin_object(&lexer.string()?, &place)?;
                self.stack.push_object(&self.state, &place)?;
            }
            "ObjectEnd" => {
                self.stack.pop_object(&mut self.state, &place)?;
                self.world.end_object(&place)?;
            }
            "ObjectInstance" => self.world.instance(&lexer.string()?, self.state.ctm, &place)?,
            "WorldBegin" => {
                if self.in_world {
                    return Err(lexer.malformed("WorldBegin is there twice"));
                }
                self.in_world = true;
                self.state.ctm = DMat4::IDENTITY;
                self.state.at_start = true;
                self.coordinate_systems.insert("world".to_owned(), DMat4::IDENTITY);
            }
            "WorldEnd" => self.ended = true,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// `Import` leaves the state as it was.
    fn include(&mut self, directive: &str, lexer: &mut Lexer) -> Result<(), ImportError> {
        let name = lexer.string()?.into_owned();
        let place = lexer.place();
        let path = self.folder.find(&name, &place)?;
        if self.open_files.contains(&path) {
            return Err(lexer.malformed(format!("\"{}\" includes itself", shortened(&name))));
        }
        let bytes = files::read(&self.folder, &name, &place)?;
        self.n_includes += 1;
        self.included_bytes += bytes.len() as u64;
        let depth = self.open_files.len();
        for (n, what, limit) in [
            (depth as u64, "files are included too deeply", MAX_INCLUDE_DEPTH as u64),
            (self.n_includes as u64, "too many files are included", MAX_INCLUDES as u64),
            (self.included_bytes, "the included files are too large together", MAX_INCLUDED_BYTES),
        ] {
            if n > limit {
                return Err(ImportError::TooBig { place, what: what.to_owned(), limit });
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        let saved = (directive == "Import").then(|| self.state.clone());
        self.open_files.push(path.clone());
        self.run(&mut Lexer::new(&path, &text))?;
        self.open_files.pop();
        if let Some(saved) = saved {
            self.state = saved;
        }
        Ok(())
    }

    fn camera(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let (kind, params) = named(lexer)?;
        self.coordinate_systems.insert("camera".to_owned(), self.state.ctm.inverse());
        self.world.view = Some(View::read(&kind, self.state.ctm, &params, self.warnings)?);
        Ok(())
    }

    /// Parameters with `Attribute`'s for the target behind them.
    fn params(&self, lexer: &mut Lexer, target: &str) -> Result<Params, ImportError> {
        Ok(Params::read(lexer)?.with_defaults(self.state.defaults.get(target)))
    }

    fn texture(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let [name, kind, class] = [lexer.string()?, lexer.string()?, lexer.string()?];
        let params = self.params(lexer, "texture")?;
        let reader =
            Reader { folder: &self.folder, version: self.version, colour_space: self.state.colour_space };
        self.textures.define([&name, &kind, &class], &params, &reader, self.warnings)
    }

    fn material(&mut self, directive: &str, lexer: &mut Lexer) -> Result<(), ImportError> {
        let first = lexer.string()?.into_owned();
        let params = self.params(lexer, "material")?;
        let (name, kind) = if directive == "Material" {
            (None, first)
        } else {
            let kind = params.string("type")?.unwrap_or("").to_owned();
            (Some(first), kind)
        };
        let index = if self.version == Version::V4 && self.is_mixture_of_awaited(&kind, &params)? {
            let index = self.materials.reserve(name.as_deref(), &params.place);
            self.later.mixtures.push((index, params, self.state.colour_space));
            index
        } else {
            let material = self.definition(&kind, &params, self.state.colour_space)?;
            self.materials.define(name.as_deref(), material)
        };
        if name.is_none() {
            self.state.material = index;
        }
        Ok(())
    }

    pub(super) fn definition(
        &mut self,
        kind: &str,
        params: &Params,
        colour_space: ColourSpace,
    ) -> Result<Material, ImportError> {
        let reader = Reader { folder: &self.folder, version: self.version, colour_space };
        let definition = materials::Definition {
            params,
            reader: &reader,
            textures: &mut self.textures,
            materials: &mut self.materials,
            warnings: self.warnings,
        };
        definition.read(kind)
    }

    fn light(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let kind = lexer.string()?.into_owned();
        let params = self.params(lexer, "light")?;
        let reader =
            Reader { folder: &self.folder, version: self.version, colour_space: self.state.colour_space };
        let (ctm, mirrored) = (self.state.ctm, self.world.is_mirrored());
        let found = lights::read(&kind, &params, ctm, mirrored, &reader, &mut self.textures, self.warnings)?;
        match found {
            Some(Found::Light(light)) => self.world.lights.push(light),
            Some(Found::Environment(sky)) => self.world.add_sky(sky, &params, self.warnings),
            None => {}
        }
        Ok(())
    }

    fn area_light(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let kind = lexer.string()?.into_owned();
        let params = self.params(lexer, "light")?;
        if !matches!(kind.as_str(), "diffuse" | "area") {
            let message = format!("area lights \"{}\" are rendered as diffuse", shortened(&kind));
            self.warnings.add(WarningKind::Light, params.place.short(), message);
        }
        let (index, colour_space) = (self.n_area_lights, self.state.colour_space);
        self.n_area_lights += 1;
        self.state.area_light = Some(Rc::new(AreaLight { index, params, colour_space }));
        Ok(())
    }

    /// Absorption alone has a place in the scene: within dielectrics.
    fn medium(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let name = lexer.string()?.into_owned();
        let params = self.params(lexer, "medium")?;
        let reader =
            Reader { folder: &self.folder, version: self.version, colour_space: self.state.colour_space };
        let kind = params.string("type")?.unwrap_or("homogeneous");
        let sigma_a = reader.colour_or(&params, "sigma_a", Use::Unbounded, Vec3::ZERO)?;
        let sigma_s = reader.colour_or(&params, "sigma_s", Use::Unbounded, Vec3::ZERO)?;
        let scale = params.float_or("scale", 1.0)?.max(0.0);
        params.ignore(&["g", "preset", "Le", "Lescale"]);
        if kind != "homogeneous" || sigma_s != Vec3::ZERO || params.has("preset") || params.has("Le") {
            let message = "media that scatter, glow or vary are not rendered, but for a constant absorption";
            self.warnings.add(WarningKind::Approximation, params.place.short(), message);
        }
        let absorbs = kind == "homogeneous" && params.has("sigma_a");
        self.media.insert(name, if absorbs { sigma_a * scale } else { Vec3::ZERO });
        Ok(())
    }

    fn shape(&mut self, lexer: &mut Lexer) -> Result<(), ImportError> {
        let kind = lexer.string()?.into_owned();
        let params = self.params(lexer, "shape")?;
        let reversed = self.state.reverse_orientation;
        let sphere = full_sphere(&kind, &params)?;
        let ctm = match sphere {
            Some(radius) => self.state.ctm * DMat4::from_scale(DVec3::splat(f64::from(radius))),
            None => self.state.ctm,
        };
        let alpha = self.alpha(&params)?;
        let plain = self.state.area_light.is_none() || self.world.in_object();
        if let (Some(_), true) = (sphere, plain) {
            let material = self.plain_material(&alpha)?;
            self.note_undressed(material, &alpha);
            if let Some(mesh) = self.world.sphere(material, reversed) {
                return self.world.place(mesh, ctm, &params, self.warnings);
            }
        }
        let Some(mut shape) = shapes::read(&kind, &params, reversed, &self.folder, self.warnings)? else {
            return Ok(());
        };
        if let Some(radius) = sphere {
            shape.mesh.positions.iter_mut().for_each(|p| *p /= radius);
        }
        params.warn_of_unused(&format!("shapes \"{kind}\""), self.warnings);
        let material =
            if plain { self.plain_material(&alpha)? } else { self.lit_material(&alpha, &shape, ctm)? };
        self.note_undressed(material, &alpha);
        let mut mesh = shape.mesh;
        // What is still to be defined may have a texture.
        if self.materials.is_awaited(self.state.material)
            || world::is_textured(&self.world.materials[material as usize])
        {
            mesh = shapes::with_default_uvs(mesh);
        }
        mesh.material = material;
        let mesh = self.world.add_mesh(mesh);
        if sphere.is_some() && plain {
            self.world.remember_sphere(material, reversed, mesh);
        }
        self.world.place(mesh, ctm, &params, self.warnings)
    }

    /// What of a shape is there, where it says.
    fn alpha(&mut self, params: &Params) -> Result<Option<ScalarInput>, ImportError> {
        if params.has("shadowalpha") {
            let message = "\"shadowalpha\" is not used: shadows are those of \"alpha\"";
            self.warnings.add(WarningKind::Alpha, params.place.short(), message);
        }
        let Some(scalar) = self.textures.scalar(params, "alpha", self.warnings)? else {
            return Ok(None);
        };
        let input = scalar.input;
        // Of a texture the product is cut off at 1.
        let most = if input.texture.is_some() { f32::MAX } else { 1.0 };
        let value = input.value.clamp(0.0, most);
        Ok((value != 1.0 || input.texture.is_some()).then_some(ScalarInput { value, ..input }))
    }

    /// The current material as the scene has it, but for what it emits.
    fn dressed(&mut self, alpha: &Option<ScalarInput>) -> Material {
        let (material, inside) = (self.state.material, self.state.inside.clone());
        self.dressed_as(material, alpha, &inside)
    }

    pub(super) fn dressed_as(&mut self, index: usize, alpha: &Option<ScalarInput>, inside: &str) -> Material {
        let mut material = self.materials.list[index].clone();
        if let Some(alpha) = alpha {
            material.opacity = match self.version {
                Version::V3 => Opacity::Mask(alpha.clone(), V3_ALPHA_CUTOFF),
                Version::V4 => Opacity::Blend(alpha.clone()),
            };
        }
        let absorption = self.media.get(inside).copied().unwrap_or(Vec3::ZERO);
        match &mut material.surface {
            Surface::Dielectric { sigma_a, thin: false, .. } => *sigma_a = absorption,
            Surface::MetallicRoughness(model) if !model.thin => model.sigma_a = absorption,
            _ if absorption != Vec3::ZERO => {
                let message = "media are rendered within dielectrics only";
                self.warnings.add(WarningKind::Approximation, "", message);
            }
            _ => {}
        }
        material
    }

    fn look(&self, alpha: &Option<ScalarInput>, area_light: Option<usize>) -> Look {
        let (material, inside) = (self.state.material, self.state.inside.to_string());
        let alpha = alpha.as_ref().map(|alpha| format!("{alpha:?}")).unwrap_or_default();
        Look { material, area_light, alpha, inside }
    }

    fn plain_material(&mut self, alpha: &Option<ScalarInput>) -> Result<u32, ImportError> {
        if self.state.area_light.is_some() {
            let message = "area lights within ObjectBegin do not shine, as in pbrt";
            self.warnings.add(WarningKind::Light, "", message);
        }
        let material = self.dressed(alpha);
        Ok(self.world.material(self.look(alpha, None), || material))
    }

    /// The material of a shape that is an area light.
    fn lit_material(
        &mut self,
        alpha: &Option<ScalarInput>,
        shape: &shapes::Shape,
        ctm: DMat4,
    ) -> Result<u32, ImportError> {
        let Some(light) = self.state.area_light.clone() else {
            return self.plain_material(alpha);
        };
        let mut material = self.dressed(alpha);
        if self.version == Version::V4 && material.surface == Surface::Null {
            let message = "area lights on surfaces that are not there do not shine, as in pbrt";
            self.warnings.add(WarningKind::Light, "", message);
            return Ok(self.world.material(self.look(alpha, None), || material));
        }
        let reader = Reader { folder: &self.folder, version: self.version, colour_space: light.colour_space };
        let found = lights::area(&light.params, &reader, &mut self.textures, self.warnings)?;
        (material.emission, material.emits) = (found.emission, found.emits);
        let Some(power) = found.power else {
            let look = self.look(alpha, Some(light.index));
            return Ok(self.world.material(look, || material));
        };
        if shape.count > 1 {
            let message = "the \"power\" of an area light is that of each of a mesh's triangles, as in pbrt";
            self.warnings.add(WarningKind::Light, light.params.place.short(), message);
        }
        let area = world::area(&shape.mesh, ctm);
        let radiance = f64::from(power) * shape.count as f64 / (std::f64::consts::PI * area);
        if area > 0.0 && radiance.is_finite() {
            material.emission.value *= radiance as f32;
        }
        Ok(self.world.single_material(material))
    }
}

/// The radius of a sphere that is whole.
fn full_sphere(kind: &str, params: &Params) -> Result<Option<f32>, ImportError> {
    if kind != "sphere" || ["zmin", "zmax", "phimax"].iter().any(|name| params.has(name)) {
        return Ok(None);
    }
    Ok(Some(params.float_or("radius", 1.0)?).filter(|radius| *radius > 0.0))
}

/// A name and parameters.
fn named(lexer: &mut Lexer) -> Result<(String, Params), ImportError> {
    Ok((lexer.string()?.into_owned(), Params::read(lexer)?))
}

/// No parameters, for their place.
fn none(lexer: &Lexer) -> Params {
    Params::empty(lexer.place())
}
