//! What directives have made so far: meshes, where they are, and what they look like.

use std::{collections::HashMap, path::Path};

use glam::{DMat3, DMat4, DVec4, Vec3};
use midway_scene::{Environment, Instance, Light, LightKind, Material, Mesh, Opacity, Scene, Surface};

use super::{
    camera::{Film, View, turned},
    environment,
    lights::Sky,
    params::Params,
};
use crate::{
    ImportError, Place,
    geometry::{MAX_INSTANCES, MAX_TRIANGLES, scaled_normal},
    warning::{WarningKind, Warnings},
};

/// A mesh somewhere in pbrt's world.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    mesh: u32,
    world_from_mesh: DMat4,
}

/// What tells materials in the scene apart: one in the file, its area light, what of it is there,
/// the medium inside.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct Look {
    pub material: usize,
    pub area_light: Option<usize>,
    pub alpha: String,
    pub inside: String,
}

/// The world so far.
#[derive(Default)]
pub(super) struct World {
    meshes: Vec<Mesh>,
    n_triangles: u64,
    placed: Vec<Placed>,
    /// An object being defined: its name and its meshes.
    open_object: Option<(String, Vec<Placed>)>,
    objects: HashMap<String, Vec<Placed>>,
    pub materials: Vec<Material>,
    looks: HashMap<Look, u32>,
    /// Unit spheres, by material and by which side is out.
    spheres: HashMap<(u32, bool), u32>,
    pub lights: Vec<LightKind>,
    sky: Option<Sky>,
    pub view: Option<View>,
    pub film: Option<Film>,
}

impl World {
    /// A material of a look, made where there is none yet.
    pub fn material(&mut self, look: Look, make: impl FnOnce() -> Material) -> u32 {
        let next = self.materials.len() as u32;
        let index = *self.looks.entry(look).or_insert(next);
        if index == next {
            self.materials.push(make());
        }
        index
    }

    /// A material of its own.
    pub fn single_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    pub fn in_object(&self) -> bool {
        self.open_object.is_some()
    }

    /// A unit sphere that is there already.
    pub fn sphere(&self, material: u32, reversed: bool) -> Option<u32> {
        self.spheres.get(&(material, reversed)).copied()
    }

    pub fn remember_sphere(&mut self, material: u32, reversed: bool, mesh: u32) {
        self.spheres.insert((material, reversed), mesh);
    }

    pub fn add_mesh(&mut self, mesh: Mesh) -> u32 {
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    /// Puts a mesh into the world, or into the object being defined. Where the transform flattens it
    /// it is left out, which is said.
    pub fn place(
        &mut self,
        mesh: u32,
        world_from_mesh: DMat4,
        params: &Params,
        warnings: &mut Warnings,
    ) -> Result<(), ImportError> {
        let world_from_mesh = affine(world_from_mesh, params)?;
        if DMat3::from_mat4(world_from_mesh).determinant() == 0.0 {
            let message = "meshes scaled to nothing are left out";
            warnings.add(WarningKind::Unused, params.place.short(), message);
            return Ok(());
        }
        let placed = Placed { mesh, world_from_mesh };
        match &mut self.open_object {
            Some((_, list)) => list.push(placed),
            None => self.put(placed, &params.place)?,
        }
        Ok(())
    }

    fn put(&mut self, placed: Placed, place: &Place) -> Result<(), ImportError> {
        let too_big = |what: &str, limit| {
            Err(ImportError::TooBig { place: place.clone(), what: what.to_owned(), limit })
        };
        self.n_triangles += self.meshes[placed.mesh as usize].triangles.len() as u64;
        if self.n_triangles > MAX_TRIANGLES {
            return too_big("the world has too many triangles", MAX_TRIANGLES);
        }
        if self.placed.len() as u64 >= MAX_INSTANCES {
            return too_big("the world has too many meshes", MAX_INSTANCES);
        }
        self.placed.push(placed);
        Ok(())
    }

    pub fn begin_object(&mut self, name: &str, params: &Params) -> Result<(), ImportError> {
        if self.in_object() {
            return Err(params.malformed("ObjectBegin is not allowed within ObjectBegin"));
        }
        self.open_object = Some((name.to_owned(), Vec::new()));
        Ok(())
    }

    pub fn end_object(&mut self, params: &Params) -> Result<(), ImportError> {
        let object = self.open_object.take();
        let (name, list) = object.ok_or_else(|| params.malformed("ObjectEnd has no ObjectBegin"))?;
        self.objects.insert(name, list);
        Ok(())
    }

    /// Puts an object's meshes into the world once more.
    pub fn instance(&mut self, name: &str, ctm: DMat4, params: &Params) -> Result<(), ImportError> {
        if self.in_object() {
            return Err(params.malformed("ObjectInstance is not allowed within ObjectBegin"));
        }
        let Some(list) = self.objects.get(name).cloned() else {
            let name = super::lex::shortened(name);
            return Err(params.malformed(format!("the object \"{name}\" is not defined")));
        };
        for placed in list {
            let world_from_mesh = affine(ctm * placed.world_from_mesh, params)?;
            self.put(Placed { world_from_mesh, ..placed }, &params.place)?;
        }
        Ok(())
    }

    /// Adds an infinite light; constant ones add up, and of others there is one.
    pub fn add_sky(&mut self, sky: Sky, params: &Params, warnings: &mut Warnings) {
        match &mut self.sky {
            None => self.sky = Some(sky),
            Some(known) if known.image.is_none() && sky.image.is_none() => known.radiance += sky.radiance,
            Some(known) => {
                let message = "of several infinite lights the one with an image, or the first such, is used";
                warnings.add(WarningKind::Light, params.place.short(), message);
                if known.image.is_none() {
                    *known = sky;
                }
            }
        }
    }

    /// Whether the scene's world is the mirror image of pbrt's.
    pub fn is_mirrored(&self) -> bool {
        self.scene_from_world().determinant() < 0.0
    }

    fn scene_from_world(&self) -> DMat4 {
        self.view.as_ref().map_or(turned(), View::scene_from_world)
    }

    /// The scene, but for its images.
    pub fn finish(mut self, film: Film, path: &Path) -> Result<Scene, ImportError> {
        let scene_from_world = self.scene_from_world();
        let exposure = (film.sensitivity * self.view.as_ref().map_or(1.0, |view| view.exposure)) as f32;
        for material in &mut self.materials {
            material.emission.value *= exposure;
        }
        let lights = self.lights.iter().map(|kind| Light {
            name: String::new(),
            kind: moved(*kind, scene_from_world, exposure),
            group: None,
        });
        let lights = lights.collect();
        let instances = self.placed.iter().map(|placed| Instance {
            mesh: placed.mesh,
            world_from_mesh: (scene_from_world * placed.world_from_mesh).as_mat4(),
            light_group: None,
        });
        let environment = self.sky.map(|sky| Environment {
            radiance: sky.radiance * exposure,
            image: sky.image,
            world_from_environment: environment::rotation(scene_from_world * sky.transform)
                .unwrap_or_default(),
        });
        if self.open_object.is_some() {
            let problem = "an ObjectBegin has no ObjectEnd".to_owned();
            return Err(ImportError::Malformed { place: Place::new(path, ""), problem });
        }
        Ok(Scene {
            cameras: self.view.iter().map(|view| view.camera(&film)).collect(),
            instances: instances.collect(),
            meshes: self.meshes,
            materials: self.materials,
            lights,
            environment,
            ..Scene::default()
        })
    }
}

/// The transform with a last row that is exactly (0, 0, 0, 1).
fn affine(mut m: DMat4, params: &Params) -> Result<DMat4, ImportError> {
    let off = (m.row(3) - DVec4::W).abs().max_element();
    if off > 1e-6 || !m.as_mat4().is_finite() {
        return Err(params.malformed("the transform is not finite and affine"));
    }
    for (column, last) in
        [(&mut m.x_axis, 0.0), (&mut m.y_axis, 0.0), (&mut m.z_axis, 0.0), (&mut m.w_axis, 1.0)]
    {
        column.w = last;
    }
    Ok(m)
}

fn moved(kind: LightKind, scene_from_world: DMat4, exposure: f32) -> LightKind {
    let point = |p: Vec3| scene_from_world.transform_point3(p.as_dvec3()).as_vec3();
    let vector = |v: Vec3| scene_from_world.transform_vector3(v.as_dvec3()).as_vec3();
    match kind {
        LightKind::Point { position, intensity } => {
            LightKind::Point { position: point(position), intensity: intensity * exposure }
        }
        LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, falloff } => {
            LightKind::Spot {
                position: point(position),
                direction: vector(direction),
                intensity: intensity * exposure,
                inner_angle,
                outer_angle,
                falloff,
            }
        }
        LightKind::Directional { direction, irradiance } => {
            LightKind::Directional { direction: vector(direction), irradiance: irradiance * exposure }
        }
    }
}

/// The area of a mesh in the world.
pub(super) fn area(mesh: &Mesh, world_from_mesh: DMat4) -> f64 {
    let positions: Vec<Vec3> =
        mesh.positions.iter().map(|p| world_from_mesh.transform_point3(p.as_dvec3()).as_vec3()).collect();
    mesh.triangles.iter().map(|t| scaled_normal(&positions, *t).length() / 2.0).sum()
}

/// Whether something of a material is looked up by (u, v).
pub(super) fn is_textured(material: &Material) -> bool {
    use midway_scene::ConductorFresnel::{Complex, Schlick};
    let opacity = match &material.opacity {
        Opacity::Opaque => None,
        Opacity::Mask(input, _) | Opacity::Blend(input) => input.texture.as_ref(),
    };
    let rough = |r: &midway_scene::Roughness| r.along.texture.is_some() || r.across.texture.is_some();
    let surface = match &material.surface {
        Surface::Null => false,
        Surface::Diffuse { reflectance } => reflectance.texture.is_some(),
        Surface::Conductor { fresnel: Schlick { f0: tint } | Complex { tint, .. }, roughness } => {
            tint.texture.is_some() || rough(roughness)
        }
        Surface::Dielectric { reflection, transmission, roughness, .. } => {
            reflection.texture.is_some() || transmission.texture.is_some() || rough(roughness)
        }
        Surface::Plastic { reflectance, specular, roughness, .. } => {
            reflectance.texture.is_some() || specular.texture.is_some() || rough(roughness)
        }
        Surface::MetallicRoughness(model) => {
            let scalars = [
                &model.metallic,
                &model.roughness,
                &model.transmission,
                &model.clearcoat,
                &model.clearcoat_roughness,
                &model.anisotropy,
            ];
            let colors = [&model.base_color, &model.sheen_color];
            colors.iter().any(|c| c.texture.is_some()) || scalars.iter().any(|s| s.texture.is_some())
        }
    };
    surface || opacity.is_some() || material.normal_map.is_some() || material.emission.texture.is_some()
}
