//! From polygons to meshes.

use std::{collections::HashMap, path::Path};

use glam::{DVec3, Mat4, Vec3};
use midway_scene::{Instance, Mesh, Scene};

use super::{
    parse::{Corner, Face, Obj},
    text::place_of,
};
use crate::{
    ImportError, Place,
    geometry::{MAX_TRIANGLES, repair_normals, scaled_normal, triangulate},
    warning::{WarningKind, Warnings},
};

/// Faces that become one mesh: of a group and a material, flat or not, textured or not.
type MeshKey = (u32, u32, bool, bool);
/// What a smooth normal belongs to: a smoothing group and a position.
type SmoothKey = (u32, u32);

/// Which normal a corner has.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum NormalKey {
    Flat,
    Given(u32),
    Smooth(u32),
}

/// A face's triangles, as positions in its list of corners.
type Triangles = Vec<[usize; 3]>;

/// Adds the file's meshes, each placed once, to a scene. `materials` has the scene's index of each
/// of the file's.
pub(super) fn build(
    obj: &Obj,
    materials: &[u32],
    scene: &mut Scene,
    warnings: &mut Warnings,
    path: &Path,
) -> Result<(), ImportError> {
    let triangulated: Vec<Triangles> = obj.faces.iter().map(|f| faces(obj, f, path, warnings)).collect();
    let n_triangles = triangulated.iter().map(|t| t.len() as u64).sum::<u64>();
    if n_triangles > MAX_TRIANGLES {
        let (place, what) = (Place::new(path, ""), format!("it has {n_triangles} triangles"));
        return Err(ImportError::TooBig { place, what, limit: MAX_TRIANGLES });
    }
    let smooth = smooth_normals(obj, &triangulated);
    let mut indices: HashMap<MeshKey, usize> = HashMap::new();
    let mut builders: Vec<MeshBuilder> = Vec::new();
    for (face, triangles) in obj.faces.iter().zip(&triangulated) {
        let key = (face.group, face.material, is_flat(obj, face), has_texcoords(obj, face));
        let next = builders.len();
        let index = *indices.entry(key).or_insert(next);
        if index == next {
            let name = obj.groups[face.group as usize].clone();
            builders.push(MeshBuilder::new(name, materials[face.material as usize]));
        }
        builders[index].add(obj, face, triangles, &smooth);
    }
    for builder in builders {
        let mut mesh = builder.mesh;
        if repair_normals(&mesh.positions, &mesh.triangles, &mut mesh.normals) > 0 {
            let message = "normals of length 0 are replaced by those of their faces";
            warnings.add(WarningKind::Repaired, mesh.name.clone(), message);
        }
        let mesh_index = scene.meshes.len() as u32;
        scene.instances.push(Instance {
            mesh: mesh_index,
            world_from_mesh: Mat4::IDENTITY,
            light_group: None,
        });
        scene.meshes.push(mesh);
    }
    Ok(())
}

fn corners<'a>(obj: &'a Obj, face: &Face) -> &'a [Corner] {
    &obj.corners[face.first..face.first + face.count]
}

/// Flat unless the file gives normals or a smoothing group. Normals for some corners only do not
/// count.
fn is_flat(obj: &Obj, face: &Face) -> bool {
    face.smoothing == 0 && !has_normals(obj, face)
}

fn has_normals(obj: &Obj, face: &Face) -> bool {
    corners(obj, face).iter().all(|c| c.normal.is_some())
}

fn has_texcoords(obj: &Obj, face: &Face) -> bool {
    corners(obj, face).iter().all(|c| c.texcoord.is_some())
}

fn faces(obj: &Obj, face: &Face, path: &Path, warnings: &mut Warnings) -> Triangles {
    let outline: Vec<Vec3> = corners(obj, face).iter().map(|c| obj.positions[c.position as usize]).collect();
    let (triangles, exact) = triangulate(&outline);
    if !exact {
        let message =
            "polygons that cross themselves, or are concave with over 128 corners, may come out wrong";
        warnings.add(WarningKind::Approximation, place_of(path, face.line), message);
    }
    triangles
}

/// Normals of smoothing groups: the faces' around each position, weighted by area.
fn smooth_normals(obj: &Obj, triangulated: &[Triangles]) -> HashMap<SmoothKey, DVec3> {
    let mut sums: HashMap<SmoothKey, DVec3> = HashMap::new();
    for (face, triangles) in obj.faces.iter().zip(triangulated) {
        if face.smoothing == 0 || has_normals(obj, face) {
            continue;
        }
        let corners = corners(obj, face);
        for triangle in triangles {
            let positions = triangle.map(|c| corners[c].position);
            let normal = scaled_normal(&obj.positions, positions);
            for position in positions {
                *sums.entry((face.smoothing, position)).or_default() += normal;
            }
        }
    }
    sums
}

struct MeshBuilder {
    mesh: Mesh,
    vertices: HashMap<(u32, Option<u32>, NormalKey), u32>,
}

impl MeshBuilder {
    fn new(name: String, material: u32) -> Self {
        let mesh = Mesh { name, material, ..Mesh::default() };
        Self { mesh, vertices: HashMap::new() }
    }

    fn add(&mut self, obj: &Obj, face: &Face, triangles: &Triangles, smooth: &HashMap<SmoothKey, DVec3>) {
        let (given, textured) = (has_normals(obj, face), has_texcoords(obj, face));
        let vertices: Vec<u32> = corners(obj, face)
            .iter()
            .map(|corner| {
                let key = match corner.normal {
                    Some(normal) if given => NormalKey::Given(normal),
                    _ if face.smoothing > 0 => NormalKey::Smooth(face.smoothing),
                    _ => NormalKey::Flat,
                };
                let texcoord = corner.texcoord.filter(|_| textured);
                self.vertex(obj, (corner.position, texcoord, key), smooth)
            })
            .collect();
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(|corner| vertices[corner])));
    }

    fn vertex(
        &mut self,
        obj: &Obj,
        vertex: (u32, Option<u32>, NormalKey),
        smooth: &HashMap<SmoothKey, DVec3>,
    ) -> u32 {
        let next = self.mesh.positions.len() as u32;
        let index = *self.vertices.entry(vertex).or_insert(next);
        if index == next {
            let (position, texcoord, normal) = vertex;
            self.mesh.positions.push(obj.positions[position as usize]);
            self.mesh.uvs[0].extend(texcoord.map(|i| obj.texcoords[i as usize]));
            if !obj.colors.is_empty() {
                // Those after the last that has a colour have none.
                let color = obj.colors.get(position as usize).copied().unwrap_or(Vec3::ONE);
                self.mesh.colors.push(color.extend(1.0));
            }
            match normal {
                NormalKey::Flat => {}
                NormalKey::Given(normal) => self.mesh.normals.push(obj.normals[normal as usize]),
                NormalKey::Smooth(group) => {
                    let sum = smooth.get(&(group, position)).copied().unwrap_or(DVec3::ZERO);
                    self.mesh.normals.push(sum.normalize_or_zero().as_vec3());
                }
            }
        }
        index
    }
}
