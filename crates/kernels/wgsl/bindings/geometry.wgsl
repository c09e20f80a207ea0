// The acceleration structure and its traversal: BVH2 with both children's boxes in a node,
// while-while (Aila and Laine, "Understanding the Efficiency of Ray Traversal on GPUs", 2009).
// Two levels: a leaf of the world's hierarchy may be an instance, a mesh with a hierarchy of its own
// in its own frame. There the ray goes on in that frame, its direction not normalised, so that t is
// the same in both; a mark on the stack says where it leaves.

/// vec4 per node and per triangle.
const NODE_STRIDE: u32 = 4u;
const TRIANGLE_STRIDE: u32 = 3u;
const LEAF_BIT: u32 = 0x80000000u;
const LEAF_COUNT_MASK: u32 = 15u;
/// In place of a leaf's count: an instance, or one of the marks.
const INSTANCE_COUNT: u32 = 15u;
/// Entries; the builder keeps both levels together shallower.
const STACK_SIZE: u32 = 64u;
/// Below the bottom of the stack, and where the ray leaves an instance: no instance's references.
const STACK_BOTTOM: u32 = 0xffffffffu;
const STACK_LEAVE: u32 = 0xffffffefu;

/// Node: left min, left reference; left max, right reference; right min; right max. Instance: three
/// rows of mesh_from_world, with what moves the mesh; the mesh's root, and what is added to its
/// triangles.
@group(0) @binding(2) var<storage, read> nodes: array<vec4<u32>>;
/// Leaf slot: first vertex and triangle index; an edge and SLOT_*; the other edge. Where a slot is not
/// solid, `passes` says whether a ray does (bindings/opacity.wgsl).
@group(0) @binding(3) var<storage, read> triangles: array<vec4<f32>>;

const SLOT_SOLID: u32 = 0u;
const SLOT_CUTOUT: u32 = 1u;

/// A ray in the frame of the hierarchy that it is in.
struct LocalRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    /// Added to a slot's triangle.
    first_id: u32,
    root: u32,
}

fn world_ray(origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    return LocalRay(origin, direction, safe_inverse(direction), 0u, 0u);
}

/// The ray in the frame of the mesh that a reference places. The origin is taken relative to where
/// the mesh lies first, so that its rounding is that of the distance to the mesh.
fn instance_ray(reference: u32, origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    let at = ((reference & ~LEAF_BIT) >> 4u) * NODE_STRIDE;
    let x = bitcast<vec4<f32>>(nodes[at]);
    let y = bitcast<vec4<f32>>(nodes[at + 1u]);
    let z = bitcast<vec4<f32>>(nodes[at + 2u]);
    let ids = nodes[at + 3u];
    let from_mesh = origin - vec3<f32>(x.w, y.w, z.w);
    let local = vec3<f32>(dot(x.xyz, direction), dot(y.xyz, direction), dot(z.xyz, direction));
    return LocalRay(vec3<f32>(dot(x.xyz, from_mesh), dot(y.xyz, from_mesh), dot(z.xyz, from_mesh)), local,
        safe_inverse(local), ids.y, ids.x);
}

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    var ray = world_ray(origin, direction);
    var hit = Hit(t_max, 0.0, 0.0, NONE);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * NODE_STRIDE;
            let a = nodes[at];
            let b = nodes[at + 1u];
            let c = nodes[at + 2u];
            let d = nodes[at + 3u];
            let left = intersect_box(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b.xyz), ray.origin, ray.inverse, hit.t);
            let right = intersect_box(bitcast<vec3<f32>>(c.xyz), bitcast<vec3<f32>>(d.xyz), ray.origin, ray.inverse, hit.t);
            let hits_left = left.x <= left.y;
            let hits_right = right.x <= right.y;
            if (hits_left && hits_right) {
                let left_first = left.x <= right.x;
                stack[top] = select(a.w, b.w, left_first);
                top += 1u;
                node = select(b.w, a.w, left_first);
            } else if (hits_left) {
                node = a.w;
            } else if (hits_right) {
                node = b.w;
            } else {
                top -= 1u;
                node = stack[top];
            }
        }
        if ((node & LEAF_COUNT_MASK) == INSTANCE_COUNT) {
            if (node == STACK_BOTTOM) {
                break;
            }
            if (node == STACK_LEAVE) {
                ray = world_ray(origin, direction);
                top -= 1u;
                node = stack[top];
            } else {
                ray = instance_ray(node, origin, direction);
                stack[top] = STACK_LEAVE;
                top += 1u;
                node = ray.root;
            }
            continue;
        }
        let first = (node & ~LEAF_BIT) >> 4u;
        let end = first + (node & LEAF_COUNT_MASK);
        for (var slot = first; slot < end; slot += 1u) {
            let at = slot * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < hit.t) {
                let id = ray.first_id + bitcast<u32>(v0.w);
                if (bitcast<u32>(e1.w) == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    hit = Hit(tuv.x, tuv.y, tuv.z, id);
                }
            }
        }
        top -= 1u;
        node = stack[top];
    }
    return hit;
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    var ray = world_ray(origin, direction);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * NODE_STRIDE;
            let a = nodes[at];
            let b = nodes[at + 1u];
            let c = nodes[at + 2u];
            let d = nodes[at + 3u];
            let left = intersect_box(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b.xyz), ray.origin, ray.inverse, t_max);
            let right = intersect_box(bitcast<vec3<f32>>(c.xyz), bitcast<vec3<f32>>(d.xyz), ray.origin, ray.inverse, t_max);
            let hits_left = left.x <= left.y;
            let hits_right = right.x <= right.y;
            if (hits_left && hits_right) {
                stack[top] = b.w;
                top += 1u;
                node = a.w;
            } else if (hits_left) {
                node = a.w;
            } else if (hits_right) {
                node = b.w;
            } else {
                top -= 1u;
                node = stack[top];
            }
        }
        if ((node & LEAF_COUNT_MASK) == INSTANCE_COUNT) {
            if (node == STACK_BOTTOM) {
                return false;
            }
            if (node == STACK_LEAVE) {
                ray = world_ray(origin, direction);
                top -= 1u;
                node = stack[top];
            } else {
                ray = instance_ray(node, origin, direction);
                stack[top] = STACK_LEAVE;
                top += 1u;
                node = ray.root;
            }
            continue;
        }
        let first = (node & ~LEAF_BIT) >> 4u;
        let end = first + (node & LEAF_COUNT_MASK);
        for (var slot = first; slot < end; slot += 1u) {
            let at = slot * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < t_max) {
                let id = ray.first_id + bitcast<u32>(v0.w);
                if (bitcast<u32>(e1.w) == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    return true;
                }
            }
        }
        top -= 1u;
        node = stack[top];
    }
    return false;
}
