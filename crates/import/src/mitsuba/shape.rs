//! Shapes: which mesh, of which material, where.

use glam::{Mat3, Mat4, Vec3};
use midway_scene::{ColorInput, Instance, Material, Mesh, Roughness, Sides, Surface};

use super::{
    Loader,
    document::Class,
    mesh::{self, Shading},
    node::Node,
    primitives, serialized,
    value::Quantity,
};
use crate::{
    ImportError,
    geometry::{MAX_INSTANCES, MAX_TRIANGLES},
    obj, ply,
    warning::WarningKind,
};

type Result<T> = std::result::Result<T, ImportError>;

/// What a shape looks like: its BSDF, its emitter and the medium inside, by their objects.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Look {
    bsdf: Option<usize>,
    emitter: Option<usize>,
    medium: Option<usize>,
}

/// What a mesh is made of: shapes that agree in all of it share it.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct MeshKey {
    plugin: String,
    file: String,
    index: i64,
    shading: Shading,
    material: u32,
}

impl Loader<'_> {
    /// Places a shape in the world, or in the group that is being read.
    pub(super) fn shape(&mut self, node: Node) -> Result<()> {
        match node.plugin() {
            "shapegroup" => self.shape_group(node),
            "instance" => self.instance(node),
            "merge" => node.all(Class::Shape)?.into_iter().try_for_each(|inner| match inner.plugin() {
                "merge" => Err(inner.malformed("a merge holds a merge")),
                _ => self.shape(inner),
            }),
            _ => self.placed(node),
        }
    }

    /// Keeps the meshes of a group for its instances.
    fn shape_group(&mut self, node: Node) -> Result<()> {
        if self.group.is_some() {
            return Err(node.malformed("a shape group is in another"));
        }
        self.group = Some(Vec::new());
        for inner in node.all(Class::Shape)? {
            if matches!(inner.plugin(), "shapegroup" | "instance") {
                return Err(inner.malformed("a shape group holds a group or an instance"));
            }
            self.shape(inner)?;
        }
        let members = self.group.take().unwrap_or_default();
        self.groups.insert(node.index, members);
        Ok(())
    }

    fn instance(&mut self, node: Node) -> Result<()> {
        let group = node.all(Class::Shape)?.into_iter().find(|shape| shape.plugin() == "shapegroup");
        let group = group.ok_or_else(|| node.malformed("it is an instance of no shape group"))?;
        if self.group.is_some() {
            return Err(node.malformed("an instance is in a shape group"));
        }
        if !self.groups.contains_key(&group.index) {
            self.shape_group(group)?;
        }
        let to_world = node.to_world()?;
        for (mesh, within) in self.groups[&group.index].clone() {
            self.place(node, mesh, to_world * within)?;
        }
        Ok(())
    }

    /// A shape that has triangles.
    fn placed(&mut self, node: Node) -> Result<()> {
        let mut to_world = node.to_world()?;
        let determinant = Mat3::from_mat4(to_world).determinant();
        let mut shading = self.shading(node)?;
        shading.is_mirrored = determinant < 0.0;
        let (mut file, mut index) = (String::new(), 0);
        match node.plugin() {
            "obj" | "ply" | "serialized" => {
                file = node.filename()?;
                index = node.integer("shape_index")?.unwrap_or(0);
            }
            "sphere" => to_world *= self.ball(node)?,
            "cylinder" => to_world *= tube(node)?,
            "rectangle" | "cube" | "disk" => {}
            other => {
                let message = format!("shapes of type {other:?} are not rendered");
                self.warn(WarningKind::Primitive, node, &message);
                return Ok(());
            }
        }
        let material = self.material(node)?;
        let key = MeshKey { plugin: node.plugin().to_owned(), file, index, shading, material };
        let mesh = match self.meshes.get(&key) {
            Some(&mesh) => mesh,
            None => {
                let mesh = self.mesh(node, &key)?;
                let index = self.scene.meshes.len() as u32;
                self.scene.meshes.push(mesh);
                self.meshes.insert(key, index);
                index
            }
        };
        self.place(node, mesh, to_world)
    }

    fn shading(&mut self, node: Node) -> Result<Shading> {
        if node.has("subdivide") {
            self.warn(WarningKind::Unused, node, "subdivision is not done");
        }
        node.disregard(&["load_materials", "srgb", "collapse", "subdivide", "sensitivity", "two_sided"]);
        let max_angle = node.float("max_smooth_angle")?;
        // OBJ files are read with v as it counts in images, which is what Mitsuba's default comes to.
        let is_obj = node.plugin() == "obj";
        Ok(Shading {
            flat: node.boolean_or("face_normals", false)?,
            flipped: node.boolean_or("flip_normals", false)?,
            flips_v: node.boolean_or("flip_tex_coords", is_obj)? != is_obj,
            max_angle: max_angle.map(f32::to_bits),
            is_mirrored: false,
        })
    }

    fn place(&mut self, node: Node, mesh: u32, world_from_mesh: Mat4) -> Result<()> {
        if let Some(group) = &mut self.group {
            group.push((mesh, world_from_mesh));
            return Ok(());
        }
        self.n_triangles += self.scene.meshes[mesh as usize].triangles.len() as u64;
        let too_big = |what: String, limit| ImportError::TooBig { place: node.place().clone(), what, limit };
        if self.n_triangles > MAX_TRIANGLES {
            return Err(too_big("the world has too many triangles".into(), MAX_TRIANGLES));
        }
        if self.scene.instances.len() as u64 >= MAX_INSTANCES {
            return Err(too_big("there are too many shapes".into(), MAX_INSTANCES));
        }
        if Mat3::from_mat4(world_from_mesh).determinant() == 0.0 {
            self.warn(WarningKind::Repaired, node, "shapes that are flattened to nothing are left out");
            return Ok(());
        }
        self.scene.instances.push(Instance { mesh, world_from_mesh, light_group: None });
        Ok(())
    }

    /// A sphere's place, as a transform of the unit sphere.
    fn ball(&mut self, node: Node) -> Result<Mat4> {
        let message = "spheres, disks and cylinders are rendered as fine meshes with their true normals";
        self.warnings.add_once(WarningKind::Approximation, node.place().short(), message);
        let centre = node.vector("center")?.unwrap_or(Vec3::ZERO);
        let radius = node.float_or("radius", 1.0)?;
        if radius > 0.0 {
            return Ok(Mat4::from_translation(centre) * Mat4::from_scale(Vec3::splat(radius)));
        }
        Err(node.malformed("its radius has to be above 0"))
    }

    fn mesh(&mut self, node: Node, key: &MeshKey) -> Result<Mesh> {
        let mut shading = key.shading;
        let mut read = match key.plugin.as_str() {
            "obj" => {
                let bytes = self.folder.read_bytes(&key.file, node.place())?;
                let path = self.folder.find(&key.file, node.place())?;
                obj::shape(&path, &bytes, self.warnings)?
            }
            "ply" => {
                let bytes = self.folder.read_bytes(&key.file, node.place())?;
                ply::read(&bytes, node.place(), self.warnings)?
            }
            "serialized" => {
                let bytes = self.folder.read_bytes(&key.file, node.place())?;
                let (mesh, is_flat) = serialized::read(&bytes, key.index, node.place())?;
                // Releases since 2 do not ask the file.
                shading.flat |= is_flat && self.is_old;
                mesh
            }
            "sphere" => primitives::sphere(),
            "cylinder" => primitives::cylinder(),
            "disk" => primitives::disk(),
            "cube" => primitives::cube(),
            _ => primitives::rectangle(),
        };
        if !read.colors.is_empty() {
            let message = "colours at vertices are not used";
            self.warn(WarningKind::VertexColour, node, message);
            read.colors.clear();
        }
        let material = &self.scene.materials[key.material as usize];
        let mut mesh = mesh::shaded(read, shading, key.plugin == "sphere");
        if needs_tangents(material) {
            mesh::add_tangents(&mut mesh, key.shading.is_mirrored);
        }
        mesh.name = node.id().to_owned();
        mesh.material = key.material;
        Ok(mesh)
    }

    /// The material of a shape: its BSDF's, emitting what its emitter does.
    fn material(&mut self, node: Node) -> Result<u32> {
        let bsdf = node.first(Class::Bsdf)?;
        let emitter = self.area_emitter(node)?;
        let medium = self.interior(node)?;
        let index = |node: Option<Node>| node.map(|node| node.index);
        let look = Look { bsdf: index(bsdf), emitter: index(emitter), medium: index(medium) };
        if let Some(&known) = self.materials.get(&look) {
            return Ok(known);
        }
        let mut material = match bsdf {
            Some(bsdf) => self.bsdf(bsdf, 0)?,
            // Lamps are black unless the file says more.
            None => {
                let reflectance = if emitter.is_some() { Vec3::ZERO } else { Vec3::splat(0.5) };
                Material { scatters: Sides::Front, ..Material::new(Surface::diffuse(reflectance)) }
            }
        };
        if let Some(medium) = medium {
            self.fill(medium, &mut material)?;
        }
        if let Some(emitter) = emitter {
            material.emission = self.radiance(emitter)?;
            material.emits = Sides::Front;
        }
        let index = self.scene.materials.len() as u32;
        self.scene.materials.push(material);
        self.materials.insert(look, index);
        Ok(index)
    }

    fn area_emitter<'a>(&mut self, node: Node<'a>) -> Result<Option<Node<'a>>> {
        let mut area = None;
        for emitter in node.all(Class::Emitter)? {
            match emitter.plugin() {
                "area" => area = Some(emitter),
                other => {
                    let message = format!("emitters of type {other:?} are not rendered");
                    self.warn(WarningKind::Light, emitter, &message);
                }
            }
        }
        Ok(area)
    }

    fn radiance(&mut self, emitter: Node) -> Result<ColorInput> {
        emitter.disregard(&["sampling_weight"]);
        // Release 0.2 says intensity.
        let name = if emitter.has("intensity") { "intensity" } else { "radiance" };
        self.warn_of_constant(emitter, name);
        self.color(emitter, name, Quantity::Unbounded, 1.0)
    }

    /// The medium inside; what is outside is not rendered.
    fn interior<'a>(&mut self, node: Node<'a>) -> Result<Option<Node<'a>>> {
        if let Some(medium) = node.child("exterior")? {
            self.warn(WarningKind::Unused, medium, "media outside of surfaces are not rendered");
        }
        if node.all(Class::Medium)?.iter().any(|medium| medium.plugin() == "dipole") {
            self.warn(WarningKind::Unused, node, "subsurface scattering is not rendered");
        }
        Ok(node.child("interior")?.filter(|medium| medium.class() == Class::Medium))
    }
}

/// A cylinder's place, as a transform of the unit tube along z.
fn tube(node: Node) -> Result<Mat4> {
    let from = node.vector("p0")?.unwrap_or(Vec3::ZERO);
    let to = node.vector("p1")?.unwrap_or(Vec3::Z);
    let radius = node.float_or("radius", 1.0)?;
    let axis = (to - from).try_normalize().filter(|_| radius > 0.0);
    let axis = axis.ok_or_else(|| node.malformed("a cylinder needs two ends and a radius above 0"))?;
    // Mitsuba's frame about an axis, which texture coordinates start from (Duff et al. 2017).
    let sign = 1f32.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let s = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let t = Vec3::new(b, sign + axis.y * axis.y * a, -axis.y);
    let along = to - from;
    let columns = [s * radius, t * radius, along].map(|column| column.extend(0.0));
    Ok(Mat4::from_cols(columns[0], columns[1], columns[2], from.extend(1.0)))
}

fn needs_tangents(material: &Material) -> bool {
    let directional = |roughness: &Roughness| roughness.along != roughness.across;
    material.normal_map.is_some()
        || match &material.surface {
            Surface::Conductor { roughness, .. }
            | Surface::Dielectric { roughness, .. }
            | Surface::Plastic { roughness, .. } => directional(roughness),
            Surface::MetallicRoughness(model) => model.anisotropy.value > 0.0,
            Surface::Diffuse { .. } | Surface::Null => false,
        }
}
