//! Mitsuba's XML, of releases 0.5 and 0.6 and of 2 and 3.
//!
//! What the plugins mean is as Mitsuba 3.9.1 renders them; where release 0.6 has another default, the
//! file's version decides. Mitsuba's cameras look along +z with x to the left: they are turned about y.

mod bsdf;
mod document;
mod emitter;
mod indices;
mod medium;
mod mesh;
mod nearest;
mod node;
mod primitives;
mod sensor;
mod serialized;
mod shape;
mod texture;
mod transform;
mod value;

use std::{collections::HashMap, path::Path};

use glam::{Mat3, Mat4, Vec3};
use midway_scene::{Image, LightKind, Material, Scene, Texels};

use crate::{
    ImportError, Place,
    files::{self, SceneFolder},
    images::Images,
    warning::{WarningKind, Warnings},
};
use document::{Class, Document};
use node::Node;

/// How often an object may be in another by reference: what refers to itself never ends.
const MAX_DEPTH: usize = 32;

/// Reads a scene.
pub(crate) fn load(path: &Path, folder: SceneFolder, warnings: &mut Warnings) -> Result<Scene, ImportError> {
    let bytes = files::read_scene(path, true)?;
    let document = Document::read(&bytes, &Place::new(path, ""), &folder, warnings)?;
    let mut loader = Loader {
        is_old: document.is_old,
        folder,
        images: Images::default(),
        scene: Scene::default(),
        materials: HashMap::new(),
        mixtures: HashMap::new(),
        meshes: HashMap::new(),
        groups: HashMap::new(),
        group: None,
        n_triangles: 0,
        environment_is_mirrored: false,
        mirrored: Vec::new(),
        warnings,
    };
    loader.objects(Node::root(&document))?;
    loader.list_unused(&document);
    Ok(loader.finish())
}

/// A scene in the making.
struct Loader<'w> {
    is_old: bool,
    folder: SceneFolder,
    images: Images,
    scene: Scene,
    /// By BSDF, emitter and medium.
    materials: HashMap<shape::Look, u32>,
    /// Mixtures of BSDFs, by their object.
    mixtures: HashMap<usize, Material>,
    meshes: HashMap<shape::MeshKey, u32>,
    /// The meshes of each shape group, by its object, with their places in it.
    groups: HashMap<usize, Vec<(u32, Mat4)>>,
    /// Where shapes go that are in a group.
    group: Option<Vec<(u32, Mat4)>>,
    /// In the world.
    n_triangles: u64,
    /// Whether the image of the environment has to be mirrored.
    environment_is_mirrored: bool,
    /// For each camera whether its image is mirrored.
    mirrored: Vec<bool>,
    warnings: &'w mut Warnings,
}

impl Loader<'_> {
    fn warn(&mut self, kind: WarningKind, node: Node, message: &str) {
        self.warnings.add(kind, node.place().short(), message);
    }

    /// What stands in the scene itself.
    fn objects(&mut self, root: Node) -> Result<(), ImportError> {
        for (_, node) in root.children()? {
            match node.class() {
                Class::Shape => self.shape(node)?,
                Class::Emitter => self.emitter(node)?,
                Class::Sensor => self.sensor(node)?,
                Class::Integrator => self.integrator(node)?,
                // The others count where they are referred to.
                _ => {}
            }
        }
        Ok(())
    }

    /// Integrators are chosen on the command line.
    fn integrator(&mut self, node: Node) -> Result<(), ImportError> {
        let longest = node.integer("max_depth")?.filter(|n| *n > 0);
        if let Some(longest) = longest {
            let message =
                format!("the file asks for path length {longest}: give --max-path-length {longest}");
            self.warn(WarningKind::Unused, node, &message);
        }
        Ok(())
    }

    /// Lists what was never asked for of objects that something was made of.
    fn list_unused(&mut self, document: &Document) {
        for object in document.objects.iter().filter(|object| object.visited.get()) {
            for property in object.properties.iter().filter(|property| !property.used.get()) {
                let name = files::shortened(&property.name);
                let message = format!("\"{name}\" of {:?} is not used", files::shortened(&object.plugin));
                self.warnings.add(WarningKind::Unused, object.place.short(), message);
            }
            for (name, _) in document.children_of(object).filter(|(_, child)| child.is_unused_texture()) {
                let (name, plugin) = (files::shortened(name), files::shortened(&object.plugin));
                let message = format!("the texture {name:?} of {plugin:?} is not used");
                self.warnings.add(WarningKind::Texture, object.place.short(), message);
            }
        }
    }

    fn finish(mut self) -> Scene {
        self.scene.images = self.images.decode(self.warnings);
        let mirrored = self.mirrored.first().copied().unwrap_or(false);
        let same = |(camera, &is_mirrored)| (is_mirrored == mirrored).then_some(camera);
        let n_cameras = self.scene.cameras.len();
        self.scene.cameras = self.scene.cameras.into_iter().zip(&self.mirrored).filter_map(same).collect();
        if self.scene.cameras.len() < n_cameras {
            let message = "of mirrored cameras and others, those like the first are used";
            self.warnings.add(WarningKind::Camera, "", message);
        }
        if mirrored {
            let message = "the camera's image is mirrored: the world is mirrored in x for it";
            self.warnings.add(WarningKind::Camera, "", message);
            mirror(&mut self.scene);
        }
        if self.environment_is_mirrored != mirrored {
            mirror_environment(&mut self.scene);
        }
        self.scene
    }
}

/// Mirrors the world in x; of the environment only its frame, see [`mirror_environment`].
fn mirror(scene: &mut Scene) {
    const FLIP: Vec3 = Vec3::new(-1.0, 1.0, 1.0);
    let flip = Mat4::from_scale(FLIP);
    for instance in &mut scene.instances {
        instance.world_from_mesh = flip * instance.world_from_mesh;
    }
    for camera in &mut scene.cameras {
        camera.world_from_camera = flip * camera.world_from_camera;
    }
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Point { position, .. } => *position *= FLIP,
            LightKind::Spot { position, direction, .. } => {
                *position *= FLIP;
                *direction *= FLIP;
            }
            LightKind::Directional { direction, .. } => *direction *= FLIP,
        }
    }
    if let Some(environment) = &mut scene.environment {
        let flip = Mat3::from_diagonal(FLIP);
        environment.world_from_environment = flip * environment.world_from_environment * flip;
    }
}

/// Gives the environment a mirrored copy of its image.
fn mirror_environment(scene: &mut Scene) {
    let Some(environment) = &mut scene.environment else { return };
    let Some(index) = environment.image else { return };
    let image = &scene.images[index as usize];
    let texels = match &image.texels {
        Texels::Srgb8(texels) => Texels::Srgb8(rows_reversed(texels, image).into()),
        Texels::Linear8(texels) => Texels::Linear8(rows_reversed(texels, image).into()),
        Texels::Linear16(texels) => Texels::Linear16(rows_reversed(texels, image).into()),
        Texels::Float(texels) => Texels::Float(rows_reversed(texels, image).into()),
    };
    let mirrored = Image { texels, ..image.clone() };
    environment.image = Some(scene.images.len() as u32);
    scene.images.push(mirrored);
}

fn rows_reversed<T: Copy>(texels: &[T], image: &Image) -> Vec<T> {
    texels.chunks_exact(image.width as usize).flat_map(|row| row.iter().rev().copied()).collect()
}
