// Traversal of the compressed wide hierarchy: eight children a node, boxes of a byte a plane (Ylitie,
// Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
// The children that a ray meets, and the triangles of a node's leaves, are bits of two words; children are
// visited in the order of the ray's octant. crates/accel/src/wide/node.rs has the layout.

#include "bindings/geometry.wgsl"

/// vec4 per node.
const WIDE_STRIDE: u32 = 5u;
/// Entries of two words; the builder keeps hierarchies shallower.
const WIDE_STACK_SIZE: u32 = 32u;
/// The bits of a group of nodes that say which are still to be visited; its lowest byte says which of
/// the children are nodes.
const WIDE_NODES_MASK: u32 = 0xff000000u;
/// Exits are widened by 8 units in the last place: planes are two roundings further from exact here than
/// in intersect_box. What cancels is within the slack that the grid leaves (node.rs).
const WIDE_FAR: f32 = 1.000001;

/// A ray as nodes need it.
struct WideRay {
    origin: vec3<f32>,
    inverse: vec3<f32>,
    /// Which coordinates decrease along it.
    negative: vec3<bool>,
    /// Seven less its octant, in each byte: x'or with a slot its order of visit.
    octant: u32,
}

fn wide_ray(origin: vec3<f32>, direction: vec3<f32>) -> WideRay {
    let inverse = safe_inverse(direction);
    let negative = inverse < vec3<f32>(0.0);
    let octant = select(0x04040404u, 0u, negative.x) | select(0x02020202u, 0u, negative.y) | select(0x01010101u, 0u, negative.z);
    return WideRay(origin, inverse, negative, octant);
}

/// Bytes of a word as numbers.
fn byte_floats(word: u32) -> vec4<f32> {
    return vec4<f32>(vec4<u32>(word, word >> 8u, word >> 16u, word >> 24u) & vec4<u32>(255u));
}

/// Which of four children a ray meets before t_max, as bits of the groups. near and far: the planes' bytes.
fn wide_hits(meta4: u32, near_x: u32, near_y: u32, near_z: u32, far_x: u32, far_y: u32, far_z: u32, scale: vec3<f32>,
    offset: vec3<f32>, octant: u32, t_max: f32) -> u32 {
    let x0 = byte_floats(near_x) * scale.x + offset.x;
    let y0 = byte_floats(near_y) * scale.y + offset.y;
    let z0 = byte_floats(near_z) * scale.z + offset.z;
    let x1 = byte_floats(far_x) * scale.x + offset.x;
    let y1 = byte_floats(far_y) * scale.y + offset.y;
    let z1 = byte_floats(far_z) * scale.z + offset.z;
    let enter = greater4(greater4(x0, y0), greater4(z0, vec4<f32>(0.0)));
    let leave = lesser4(lesser4(lesser4(x1, y1), z1) * WIDE_FAR, vec4<f32>(t_max));
    let is_hit = enter <= leave;
    // Nodes have 24 and their slot in their byte's low bits: both bits of 24 are set in no leaf's.
    let is_node = (meta4 & (meta4 << 1u)) & 0x10101010u;
    let place4 = (meta4 ^ (octant & ((is_node >> 4u) * 255u))) & 0x1f1f1f1fu;
    let bits4 = (meta4 >> 5u) & 0x07070707u;
    return select(0u, (bits4 & 255u) << (place4 & 31u), is_hit.x)
        | select(0u, ((bits4 >> 8u) & 255u) << ((place4 >> 8u) & 31u), is_hit.y)
        | select(0u, ((bits4 >> 16u) & 255u) << ((place4 >> 16u) & 31u), is_hit.z)
        | select(0u, (bits4 >> 24u) << (place4 >> 24u), is_hit.w);
}

fn lesser4(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a < b);
}

fn greater4(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a > b);
}

/// The groups of nodes and of triangles to visit below a node: each its base and its bits.
fn wide_visit(node: u32, ray: WideRay, t_max: f32) -> vec4<u32> {
    let at = node * WIDE_STRIDE;
    let n0 = nodes[at];
    let n1 = nodes[at + 1u];
    let n2 = nodes[at + 2u];
    let n3 = nodes[at + 3u];
    let n4 = nodes[at + 4u];
    // Steps are powers of two: their exponents are all of them.
    let step = bitcast<vec3<f32>>(((vec3<u32>(n0.w) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u)) << vec3<u32>(23u));
    let scale = step * ray.inverse;
    let offset = (bitcast<vec3<f32>>(n0.xyz) - ray.origin) * ray.inverse;
    let near_x = select(n2.xy, n3.zw, ray.negative.x);
    let far_x = select(n3.zw, n2.xy, ray.negative.x);
    let near_y = select(n2.zw, n4.xy, ray.negative.y);
    let far_y = select(n4.xy, n2.zw, ray.negative.y);
    let near_z = select(n3.xy, n4.zw, ray.negative.z);
    let far_z = select(n4.zw, n3.xy, ray.negative.z);
    let bits = wide_hits(n1.z, near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, scale, offset, ray.octant, t_max)
        | wide_hits(n1.w, near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, scale, offset, ray.octant, t_max);
    return vec4<u32>(n1.x, (bits & WIDE_NODES_MASK) | (n0.w >> 24u), n1.y, bits & ~WIDE_NODES_MASK);
}

/// The node of a group's bit.
fn wide_child(first: u32, bits: u32, bit: u32, octant: u32) -> u32 {
    let slot = (bit - 24u) ^ (octant & 7u);
    return first + countOneBits(bits & ~(0xffffffffu << slot) & 255u);
}

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit_wide(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    let ray = wide_ray(origin, direction);
    var hit = Hit(t_max, 0.0, 0.0, NONE);
    var stack: array<vec2<u32>, WIDE_STACK_SIZE>;
    var top = 0u;
    // A group whose only node is the root.
    var group = vec2<u32>(0u, 0x80000000u);
    loop {
        let bit = firstLeadingBit(group.y);
        let node = wide_child(group.x, group.y, bit, ray.octant);
        group.y &= ~(1u << bit);
        if (group.y >= 0x01000000u) {
            stack[top] = group;
            top += 1u;
        }
        let found = wide_visit(node, ray, hit.t);
        group = found.xy;
        var leaves = found.w;
        while (leaves != 0u) {
            let place = firstLeadingBit(leaves);
            leaves &= ~(1u << place);
            let at = (found.z + place) * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, origin, direction);
            if (tuv.x > 0.0 && tuv.x < hit.t) {
                let id = bitcast<u32>(v0.w);
                if (bitcast<u32>(e1.w) == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    hit = Hit(tuv.x, tuv.y, tuv.z, id);
                }
            }
        }
        if (group.y < 0x01000000u) {
            if (top == 0u) {
                break;
            }
            top -= 1u;
            group = stack[top];
        }
    }
    return hit;
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit_wide(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    let ray = wide_ray(origin, direction);
    var stack: array<vec2<u32>, WIDE_STACK_SIZE>;
    var top = 0u;
    var group = vec2<u32>(0u, 0x80000000u);
    loop {
        let bit = firstLeadingBit(group.y);
        let node = wide_child(group.x, group.y, bit, ray.octant);
        group.y &= ~(1u << bit);
        if (group.y >= 0x01000000u) {
            stack[top] = group;
            top += 1u;
        }
        let found = wide_visit(node, ray, t_max);
        group = found.xy;
        var leaves = found.w;
        while (leaves != 0u) {
            let place = firstLeadingBit(leaves);
            leaves &= ~(1u << place);
            let at = (found.z + place) * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, origin, direction);
            if (tuv.x > 0.0 && tuv.x < t_max) {
                if (bitcast<u32>(e1.w) == SLOT_SOLID || !passes(bitcast<u32>(v0.w), tuv.y, tuv.z, origin, direction)) {
                    return true;
                }
            }
        }
        if (group.y < 0x01000000u) {
            if (top == 0u) {
                break;
            }
            top -= 1u;
            group = stack[top];
        }
    }
    return false;
}
