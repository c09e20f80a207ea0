//! Triangles as traversal and as shading read them.

use std::iter::repeat_n;

use glam::{Vec2, Vec3, Vec4};
use midway_accel::{Hierarchy, TwoLevel};
use midway_kernels::constants as k;
use midway_scene::{Mesh, PlacedMesh, WorldTriangle};
use rayon::prelude::*;

use super::{Word4, is_solid, normals::oct_encode, word4};
use crate::{
    lights::{LightSource, Lights},
    world::World,
};

/// A corner of a triangle may differ from its geometric normal by this much, squared, and the
/// triangle still be stored as flat: half of what packing a normal may change.
const FLAT_TOLERANCE: f32 = 1e-10;
/// The largest half.
const LARGEST_HALF: f32 = 65504.0;

/// The slots of the hierarchies' leaves.
pub(super) fn pack_triangles(two_level: &TwoLevel, world: &World<'_>, positions: &[[Vec3; 3]]) -> Vec<Word4> {
    const STRIDE: usize = k::TRIANGLE_STRIDE as usize;
    let n_slots: usize = two_level.slots().map(|bvh| bvh.primitives().len()).sum();
    let mut words = vec![Word4::default(); n_slots * STRIDE];
    let kind_of = |mesh: &Mesh| {
        if is_solid(world.scene(), mesh.material) { k::SLOT_SOLID } else { k::SLOT_CUTOUT }
    };
    let baked = world.baked().flat_map(|mesh| repeat_n(kind_of(mesh.mesh()), mesh.n_triangles() as usize));
    let baked: Vec<u32> = baked.collect();
    let slot = |[a, b, c]: [Vec3; 3], primitive: u32, kind: u32| -> [Word4; STRIDE] {
        [word4(a, primitive), word4(b - a, kind), word4(c - a, 0)]
    };
    let of_world = |primitive: u32| match positions.get(primitive as usize) {
        Some(&triangle) => slot(triangle, primitive, baked[primitive as usize]),
        None => {
            let placement = primitive - positions.len() as u32;
            slot([Vec3::ZERO; 3], two_level.record(placement), k::SLOT_INSTANCE)
        }
    };
    let (own, mut rest) = words.split_at_mut(two_level.world.primitives().len() * STRIDE);
    fill(own, two_level.world.primitives(), of_world);
    for (bvh, &mesh) in two_level.meshes.iter().zip(&world.meshes) {
        let alone = world.scene().mesh_alone(mesh);
        let kind = kind_of(alone.mesh());
        let (own, others) = rest.split_at_mut(bvh.primitives().len() * STRIDE);
        fill(own, bvh.primitives(), |primitive| slot(alone.positions(primitive), primitive, kind));
        rest = others;
    }
    words
}

/// A slot for each primitive, by all cores.
fn fill<const N: usize>(words: &mut [Word4], primitives: &[u32], slot: impl Fn(u32) -> [Word4; N] + Sync) {
    let slots = words.par_chunks_exact_mut(N).zip(primitives);
    slots.for_each(|(words, &primitive)| words.copy_from_slice(&slot(primitive)));
}

/// Where things are among the words of `scene`.
pub(super) struct SurfacesAt {
    pub surfaces: u32,
    pub instances: u32,
}

/// Whether any triangle has attributes.
pub(super) fn has_attributes(world: &World<'_>) -> bool {
    world.baked().chain(meshes(world)).any(|placed| attribute_kinds(placed.mesh()).is_some())
}

/// What shading needs of each triangle: surfaces, their attributes, instances.
pub(super) fn pack_surfaces(world: &World<'_>, lights: &Lights, words: &mut Vec<Word4>) -> SurfacesAt {
    let n_placed: usize = meshes(world).map(|mesh| mesh.n_triangles() as usize).sum();
    let n_surfaces = world.n_baked as usize + n_placed;
    let surfaces = words.len();
    words.reserve(n_surfaces * k::SURFACE_STRIDE as usize);
    let mut packer =
        Packer { attributes_at: surfaces + n_surfaces * k::SURFACE_STRIDE as usize, attributes: Vec::new() };
    world.baked().chain(meshes(world)).for_each(|mesh| packer.mesh(&mesh, words));
    for (index, light) in (0u32..).zip(&lights.lights) {
        if let LightSource::Triangle(triangle) = light.source {
            words[surfaces + triangle as usize * k::SURFACE_STRIDE as usize + 1][3] = index;
        }
    }
    words.append(&mut packer.attributes);
    let instances = words.len();
    pack_instances(world, words);
    SurfacesAt { surfaces: surfaces as u32, instances: instances as u32 }
}

fn meshes<'a>(world: &World<'a>) -> impl Iterator<Item = PlacedMesh<'a>> {
    let scene = world.scene();
    world.meshes.clone().into_iter().map(move |mesh| scene.mesh_alone(mesh))
}

struct Packer {
    attributes_at: usize,
    attributes: Vec<Word4>,
}

impl Packer {
    fn mesh(&mut self, placed: &PlacedMesh<'_>, words: &mut Vec<Word4>) {
        let n_triangles = placed.n_triangles() as usize;
        let first = words.len();
        words.resize(first + n_triangles * k::SURFACE_STRIDE as usize, Word4::default());
        let surfaces = words[first..].par_chunks_exact_mut(k::SURFACE_STRIDE as usize);
        let triangles = (0..placed.n_triangles()).into_par_iter().map(|index| placed.triangle(index));
        let Some(kinds) = attribute_kinds(placed.mesh()) else {
            surfaces.zip(triangles).for_each(|(surface, triangle)| {
                surface.copy_from_slice(&pack_surface(&triangle, k::NONE));
            });
            return;
        };
        let (first, stride) = (self.attributes.len(), attributes_stride(kinds));
        let first_at = self.attributes_at + first;
        self.attributes.resize(first + n_triangles * stride, Word4::default());
        let attributes = self.attributes[first..].par_chunks_exact_mut(stride);
        surfaces.zip(attributes).zip(triangles).enumerate().for_each(
            |(index, ((surface, own), triangle))| {
                let attributes_at = (first_at + index * stride) as u32;
                surface.copy_from_slice(&pack_surface(&triangle, attributes_at));
                pack_attributes(&triangle, kinds, own);
            },
        );
    }
}

/// A surface without its light.
fn pack_surface(triangle: &WorldTriangle, attributes_at: u32) -> [Word4; k::SURFACE_STRIDE as usize] {
    let [a, b, c] = triangle.positions;
    let [n0, n1, n2] =
        smooth_normals(triangle).map_or([k::FLAT_NORMAL; 3], |normals| normals.map(oct_encode));
    [word4(a, triangle.material), word4(b - a, k::NONE), word4(c - a, 0), [n0, n1, n2, attributes_at]]
}

/// The normals at the vertices, where they are not all the triangle's own.
fn smooth_normals(triangle: &WorldTriangle) -> Option<[Vec3; 3]> {
    let normals = triangle.normals?;
    let is_flat = triangle
        .geometric_normal()
        .is_some_and(|flat| normals.iter().all(|normal| normal.distance_squared(flat) <= FLAT_TOLERANCE));
    (!is_flat).then_some(normals)
}

/// What a mesh has beside texture coordinates of set 0; none where it has not even these.
fn attribute_kinds(mesh: &Mesh) -> Option<u32> {
    let kinds = [
        (!mesh.uvs[1].is_empty(), k::ATTRIBUTE_UV1),
        (!mesh.colors.is_empty(), k::ATTRIBUTE_COLORS),
        (!mesh.tangents.is_empty(), k::ATTRIBUTE_TANGENTS),
    ];
    let kinds =
        kinds.into_iter().filter_map(|(has, kind)| has.then_some(kind)).fold(0, |all, kind| all | kind);
    (kinds != 0 || !mesh.uvs[0].is_empty()).then_some(kinds)
}

/// How many vec4 the attributes of a triangle take.
fn attributes_stride(kinds: u32) -> usize {
    let set = [(k::ATTRIBUTE_UV1, 2), (k::ATTRIBUTE_COLORS, 2), (k::ATTRIBUTE_TANGENTS, 1)];
    2 + set.iter().filter(|(kind, _)| kinds & kind != 0).map(|(_, n)| n).sum::<usize>()
}

/// Fills `words`, [`attributes_stride`] of them.
fn pack_attributes(triangle: &WorldTriangle, kinds: u32, words: &mut [Word4]) {
    let (first, mut rest) = words.split_at_mut(2);
    let [uvs, second_uvs] = triangle.uvs;
    first.copy_from_slice(&pack_uvs(uvs, kinds));
    let mut next = |own: &[Word4]| {
        let (place, others) = std::mem::take(&mut rest).split_at_mut(own.len());
        place.copy_from_slice(own);
        rest = others;
    };
    if kinds & k::ATTRIBUTE_UV1 != 0 {
        next(&pack_uvs(second_uvs, 0));
    }
    if kinds & k::ATTRIBUTE_COLORS != 0 {
        let [[a, b], [c, d], [e, f]] = triangle.colors.unwrap_or([Vec4::ONE; 3]).map(pack_color);
        next(&[[a, b, c, d], [e, f, 0, 0]]);
    }
    if kinds & k::ATTRIBUTE_TANGENTS != 0 {
        let tangents = triangle.tangents.unwrap_or([Vec4::X; 3]);
        let [a, b, c] = tangents.map(|t| oct_encode(t.truncate().normalize_or(Vec3::X)));
        // A triangle whose corners disagree is cut by a seam: no sign is right for all of it.
        next(&[[a, b, c, tangents[0].w.signum().to_bits()]]);
    }
}

fn pack_uvs([a, b, c]: [Vec2; 3], kinds: u32) -> [Word4; 2] {
    let [a, b, c] = [a, b, c].map(|uv| uv.to_array().map(f32::to_bits));
    [[a[0], a[1], b[0], b[1]], [c[0], c[1], kinds, 0]]
}

/// In halves: 11 bits, more than the 8 that files have as a rule.
fn pack_color(color: Vec4) -> [u32; 2] {
    let c = color.clamp(Vec4::splat(-LARGEST_HALF), Vec4::splat(LARGEST_HALF));
    [midway_kernels::native::pack_halves(c.x, c.y), midway_kernels::native::pack_halves(c.z, c.w)]
}

fn pack_instances(world: &World<'_>, words: &mut Vec<Word4>) {
    // For each placed mesh the place of its first surface.
    let firsts: Vec<u32> = meshes(world)
        .scan(world.n_baked, |next, mesh| Some(std::mem::replace(next, *next + mesh.n_triangles())))
        .collect();
    for part in world.placed() {
        let placed = world.scene().placed(part.instance);
        let mesh = world.scene().instances[part.instance as usize].mesh;
        let first_surface = firsts[world.meshes.partition_point(|&m| m < mesh)];
        let world_from_mesh = placed.world_from_mesh();
        let rows = world_from_mesh.matrix3.transpose();
        let largest = rows.to_cols_array().into_iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let front = if placed.is_mirrored() { -1.0f32 } else { 1.0 };
        let size = (1.0 / largest) as f32;
        words.push([part.first_id, first_surface, front.to_bits(), size.to_bits()]);
        let translation = world_from_mesh.translation.as_vec3();
        for (row, moved) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().zip(translation.to_array()) {
            words.push(word4(row.as_vec3(), moved.to_bits()));
        }
    }
}
