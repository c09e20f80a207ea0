// The acceleration structure and its traversal, by one of two hierarchies: eight children a node
// (bindings/geometry_wide.wgsl) or two (bindings/geometry_binary.wgsl), which a scene was packed for
// (`hierarchy_of` in crates/render). On the CPU closest_hit and any_hit are those of
// crates/kernels/src/traversal, which know the wide one.
//
// Two levels: a leaf slot of the world's hierarchy may be an instance, a mesh with a hierarchy of its own
// in its own frame. There the ray goes on in that frame, its direction not normalised, so that t is
// the same in both; a mark on the stack says where it leaves.

#include "bindings/geometry_wide.wgsl"
#include "bindings/geometry_binary.wgsl"

/// vec4 per leaf slot.
const TRIANGLE_STRIDE: u32 = 3u;

/// Nodes, then a record for each instance: three rows of mesh_from_world, with what moves the mesh; the
/// mesh's root, and what is added to its triangles.
@group(0) @binding(2) var<storage, read> nodes: array<vec4<u32>>;
/// Leaf slot: first vertex and triangle index; an edge and SLOT_*; the other edge. Where a slot is not
/// solid, `passes` says whether a ray does (bindings/opacity.wgsl). Of an instance the index is the place
/// of its record.
@group(0) @binding(3) var<storage, read> triangles: array<vec4<f32>>;

const SLOT_SOLID: u32 = 0u;
const SLOT_CUTOUT: u32 = 1u;
const SLOT_INSTANCE: u32 = 2u;

/// A ray in the frame of the hierarchy that it is in.
struct LocalRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    /// Seven less its octant, in each byte: with a slot by exclusive or, its place in the order of visits.
    octant: u32,
    /// Added to a slot's triangle.
    first_id: u32,
    root: u32,
}

fn local_ray(origin: vec3<f32>, direction: vec3<f32>, first_id: u32, root: u32) -> LocalRay {
    let inverse = safe_inverse(direction);
    let octant = select(0x04040404u, 0u, inverse.x < 0.0) | select(0x02020202u, 0u, inverse.y < 0.0)
        | select(0x01010101u, 0u, inverse.z < 0.0);
    return LocalRay(origin, direction, inverse, octant, first_id, root);
}

fn world_ray(origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    return local_ray(origin, direction, 0u, 0u);
}

/// The ray in the frame of the mesh that a record places. The origin is taken relative to where
/// the mesh lies first, so that its rounding is that of the distance to the mesh.
fn instance_ray(at: u32, origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    let x = bitcast<vec4<f32>>(nodes[at]);
    let y = bitcast<vec4<f32>>(nodes[at + 1u]);
    let z = bitcast<vec4<f32>>(nodes[at + 2u]);
    let ids = nodes[at + 3u];
    let from_mesh = origin - vec3<f32>(x.w, y.w, z.w);
    return local_ray(vec3<f32>(dot(x.xyz, from_mesh), dot(y.xyz, from_mesh), dot(z.xyz, from_mesh)),
        vec3<f32>(dot(x.xyz, direction), dot(y.xyz, direction), dot(z.xyz, direction)), ids.y, ids.x);
}

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    if (may_have(FEATURE_WIDE)) {
        return closest_hit_wide(origin, direction, t_max);
    }
    return closest_hit_binary(origin, direction, t_max);
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    if (may_have(FEATURE_WIDE)) {
        return any_hit_wide(origin, direction, t_max);
    }
    return any_hit_binary(origin, direction, t_max);
}
