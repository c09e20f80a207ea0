//! The node tree: what is where.

use std::sync::Arc;

use glam::{DMat3, DMat4, DQuat, DVec3};
use midway_scene::{Camera, Instance, Light};

use super::{cameras, instancing, json::Json, lights::Lights, meshes::Meshes, warn_of_extensions};
use crate::{
    ImportError,
    geometry::{MAX_INSTANCES, MAX_TRIANGLES},
    warning::{WarningKind, Warnings},
};

/// What the nodes of the scene place.
#[derive(Default)]
pub(super) struct Placed {
    pub cameras: Vec<Camera>,
    pub lights: Vec<Light>,
    pub instances: Vec<Instance>,
}

/// Walks the default scene, or the first, or all root nodes where the file has no scene.
pub(super) fn walk<'a>(
    root: &Json<'a>,
    meshes: &mut Meshes<'a>,
    warnings: &mut Warnings,
) -> Result<Placed, ImportError> {
    let nodes = root.items("nodes")?;
    let mut walk = Walk {
        cameras: root.items("cameras")?,
        lights: Lights::new(root, warnings)?,
        meshes,
        warnings,
        placed: Placed::default(),
        n_triangles: 0,
    };
    let mut visited = vec![false; nodes.len()];
    let mut stack: Vec<(usize, DMat4)> =
        roots(root, &nodes)?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = stack.pop() {
        let node = &nodes[index];
        // Nodes are trees: one reached twice has two parents or is its own ancestor.
        if std::mem::replace(&mut visited[index], true) {
            return Err(node.malformed("the node has two parents, or is its own ancestor"));
        }
        let world_from_node = world_from_parent * local_matrix(node)?;
        walk.visit(node, &world_from_node)?;
        for child in node.items("children")?.into_iter().rev() {
            stack.push((child.index("node", nodes.len())?, world_from_node));
        }
    }
    Ok(walk.placed)
}

fn roots(root: &Json, nodes: &[Json]) -> Result<Vec<usize>, ImportError> {
    let scenes = root.items("scenes")?;
    let chosen = match root.get("scene") {
        Some(scene) => Some(&scenes[scene.index("scene", scenes.len())?]),
        None => scenes.first(),
    };
    if let Some(scene) = chosen {
        return scene.items("nodes")?.iter().map(|n| n.index("node", nodes.len())).collect();
    }
    let mut is_child = vec![false; nodes.len()];
    for node in nodes {
        for child in node.items("children")? {
            is_child[child.index("node", nodes.len())?] = true;
        }
    }
    Ok((0..nodes.len()).filter(|&n| !is_child[n]).collect())
}

/// A node's own transform, by matrix or by translation, rotation and scale.
fn local_matrix(node: &Json) -> Result<DMat4, ImportError> {
    if node.get("matrix").is_some() {
        let columns = node.floats_or("matrix", [0.0; 16])?.map(f64::from);
        return Ok(DMat4::from_cols_array(&columns));
    }
    let vector = |key, default| -> Result<DVec3, ImportError> {
        Ok(DVec3::from_array(node.floats_or(key, [default; 3])?.map(f64::from)))
    };
    let rotation = DQuat::from_array(node.floats_or("rotation", [0.0, 0.0, 0.0, 1.0])?.map(f64::from));
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    let (scale, translation) = (vector("scale", 1.0)?, vector("translation", 0.0)?);
    Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
}

struct Walk<'w, 'a> {
    cameras: Vec<Json<'a>>,
    lights: Lights<'a>,
    meshes: &'w mut Meshes<'a>,
    warnings: &'w mut Warnings,
    placed: Placed,
    n_triangles: u64,
}

impl Walk<'_, '_> {
    fn visit(&mut self, node: &Json, world_from_node: &DMat4) -> Result<(), ImportError> {
        warn_of_extensions(node, self.warnings)?;
        if node.get("skin").is_some() {
            let message = "skins are not used: the mesh is rendered as modelled";
            self.warnings.add(WarningKind::Skin, node.pointer(), message);
        }
        if let Some(camera) = node.get("camera") {
            let camera = self.cameras[camera.index("camera", self.cameras.len())?].clone();
            self.placed.cameras.extend(cameras::read(&camera, node, world_from_node, self.warnings)?);
        }
        self.placed.lights.extend(self.lights.of(node, world_from_node, self.warnings)?);
        if let Some(mesh) = node.get("mesh") {
            self.mesh(&mesh, node, world_from_node)?;
        }
        Ok(())
    }

    /// A node's mesh, once or, with `EXT_mesh_gpu_instancing`, many times.
    fn mesh(&mut self, mesh: &Json, node: &Json, world_from_node: &DMat4) -> Result<(), ImportError> {
        let own = self.meshes.of(node, mesh, self.warnings)?;
        let group = light_group(node);
        let group = group.or(Some(node.name()).filter(|name| !name.is_empty()).map(Arc::from));
        match instancing::node_from_instances(node, self.meshes.accessors())? {
            Some(places) => places
                .iter()
                .try_for_each(|place| self.place(&own, node, &(*world_from_node * *place), group.as_ref())),
            None => self.place(&own, node, world_from_node, group.as_ref()),
        }
    }

    fn place(
        &mut self,
        own: &[u32],
        node: &Json,
        world_from_mesh: &DMat4,
        light_group: Option<&Arc<str>>,
    ) -> Result<(), ImportError> {
        let world_from_mesh = world_from_mesh.as_mat4();
        if !world_from_mesh.is_finite() || world_from_mesh.row(3) != glam::Vec4::W {
            return Err(node.malformed("the node's transform is not finite and affine"));
        }
        if DMat3::from_mat4(world_from_mesh.as_dmat4()).determinant() == 0.0 {
            let message = "meshes scaled to nothing are left out";
            self.warnings.add(WarningKind::Unused, node.pointer(), message);
            return Ok(());
        }
        let too_big = |what: &str, limit| {
            Err(ImportError::TooBig { place: node.place(), what: what.to_owned(), limit })
        };
        if (self.placed.instances.len() + own.len()) as u64 > MAX_INSTANCES {
            return too_big("the nodes place too many meshes", MAX_INSTANCES);
        }
        for &mesh in own {
            self.n_triangles += self.meshes.n_triangles(mesh);
            if self.n_triangles > MAX_TRIANGLES {
                return too_big("the nodes place too many triangles", MAX_TRIANGLES);
            }
            self.placed.instances.push(Instance { mesh, world_from_mesh, light_group: light_group.cloned() });
        }
        Ok(())
    }
}

/// The group of lights that a node is put into: its `lightgroup` among the extras, as exporters write an
/// object's own properties (Blender: a custom property of that name).
pub(super) fn light_group(node: &Json) -> Option<Arc<str>> {
    let extras = node.get("extras")?;
    let name = extras.get("lightgroup")?.string().ok()?;
    (!name.trim().is_empty()).then(|| Arc::from(name))
}
