// Traversal of the wide hierarchy: eight children a node, whose boxes take a byte a plane (Ylitie, Karras
// and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017). What a
// ray meets of a node is two groups, each a base and bits: nodes, which are visited in the order of the
// ray's octant, and leaf slots. crates/accel/src/wide/node.rs has the layout.

/// vec4 per node.
const WIDE_STRIDE: u32 = 5u;
/// Groups that wait; the builder keeps both levels together shallower. A GPU clears all of it for each ray.
const WIDE_STACK_SIZE: u32 = 32u;
/// Bits of a group of nodes from here on say which are to be visited; its lowest byte says which children
/// are nodes. A group of leaf slots has lower bits only.
const FIRST_NODE_BIT: u32 = 0x01000000u;
/// A group whose only node is at its base.
const ROOT_GROUP: u32 = 0x80000000u;
/// On the stack: the ray leaves an instance. No group is without bits.
const LEAVE: vec2<u32> = vec2<u32>(0u, 0u);
/// Exits are widened by 8 units in the last place, for the roundings of a slab's plane (Ize, "Robust
/// BVH Ray Traversal", JCGT 2(2), 2013). What cancels is within the slack that a node's grid leaves.
const FAR_FACTOR: f32 = 1.000001;

/// Bytes of a word as numbers.
fn byte_floats(word: u32) -> vec4<f32> {
    return vec4<f32>(vec4<u32>(word, word >> 8u, word >> 16u, word >> 24u) & vec4<u32>(255u));
}

/// Which of four children a ray meets before t_max, as bits of the groups. near and far: the planes' bytes.
fn children_hit(meta4: u32, near_x: u32, near_y: u32, near_z: u32, far_x: u32, far_y: u32, far_z: u32, scale: vec3<f32>,
    offset: vec3<f32>, octant: u32, t_max: f32) -> u32 {
    let x0 = byte_floats(near_x) * scale.x + offset.x;
    let y0 = byte_floats(near_y) * scale.y + offset.y;
    let z0 = byte_floats(near_z) * scale.z + offset.z;
    let x1 = byte_floats(far_x) * scale.x + offset.x;
    let y1 = byte_floats(far_y) * scale.y + offset.y;
    let z1 = byte_floats(far_z) * scale.z + offset.z;
    let enter = greater4(greater4(x0, y0), greater4(z0, vec4<f32>(0.0)));
    let leave = lesser4(lesser4(lesser4(x1, y1), z1) * FAR_FACTOR, vec4<f32>(t_max));
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

/// min and max for slabs, which have no NaN (safe_inverse): a single instruction on a CPU, where
/// WGSL's own, which must prefer the other operand to a NaN, take five.
fn lesser4(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a < b);
}

fn greater4(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a > b);
}

/// What a ray meets of a node before t_max: a group of nodes and a group of leaf slots.
fn visit_node(node: u32, ray: LocalRay, t_max: f32) -> vec4<u32> {
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
    let negative = ray.inverse < vec3<f32>(0.0);
    let near_x = select(n2.xy, n3.zw, negative.x);
    let far_x = select(n3.zw, n2.xy, negative.x);
    let near_y = select(n2.zw, n4.xy, negative.y);
    let far_y = select(n4.xy, n2.zw, negative.y);
    let near_z = select(n3.xy, n4.zw, negative.z);
    let far_z = select(n4.zw, n3.xy, negative.z);
    let bits = children_hit(n1.z, near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, scale, offset, ray.octant, t_max)
        | children_hit(n1.w, near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, scale, offset, ray.octant, t_max);
    return vec4<u32>(n1.x, (bits & ~(FIRST_NODE_BIT - 1u)) | (n0.w >> 24u), n1.y, bits & (FIRST_NODE_BIT - 1u));
}

/// The node that a bit of a group stands for.
fn group_node(group: vec2<u32>, bit: u32, octant: u32) -> u32 {
    let slot = (bit - 24u) ^ (octant & 7u);
    return group.x + countOneBits(group.y & ~(0xffffffffu << slot) & 255u);
}

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit_wide(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    var ray = world_ray(origin, direction);
    var hit = Hit(t_max, 0.0, 0.0, NONE);
    var stack: array<vec2<u32>, WIDE_STACK_SIZE>;
    var top = 0u;
    var group = vec2<u32>(0u, ROOT_GROUP);
    var leaves = vec2<u32>(0u);
    loop {
        if (leaves.y == 0u) {
            let bit = firstLeadingBit(group.y);
            let node = group_node(group, bit, ray.octant);
            group.y &= ~(1u << bit);
            if (group.y >= FIRST_NODE_BIT) {
                stack[top] = group;
                top += 1u;
            }
            let met = visit_node(node, ray, hit.t);
            group = met.xy;
            leaves = met.zw;
        }
        while (leaves.y != 0u) {
            let place = firstLeadingBit(leaves.y);
            leaves.y &= ~(1u << place);
            let at = (leaves.x + place) * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let kind = bitcast<u32>(e1.w);
            if (may_have(FEATURE_INSTANCES) && kind == SLOT_INSTANCE) {
                if (group.y >= FIRST_NODE_BIT) {
                    stack[top] = group;
                    top += 1u;
                }
                if (leaves.y != 0u) {
                    stack[top] = leaves;
                    top += 1u;
                }
                stack[top] = LEAVE;
                top += 1u;
                ray = instance_ray(bitcast<u32>(v0.w), origin, direction);
                group = vec2<u32>(ray.root, ROOT_GROUP);
                leaves.y = 0u;
                break;
            }
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < hit.t) {
                let id = ray.first_id + bitcast<u32>(v0.w);
                if (kind == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    hit = Hit(tuv.x, tuv.y, tuv.z, id);
                }
            }
        }
        while (leaves.y == 0u && group.y < FIRST_NODE_BIT) {
            if (top == 0u) {
                return hit;
            }
            top -= 1u;
            let waiting = stack[top];
            if (!may_have(FEATURE_INSTANCES) || waiting.y >= FIRST_NODE_BIT) {
                group = waiting;
            } else if (waiting.y != 0u) {
                leaves = waiting;
            } else {
                ray = world_ray(origin, direction);
            }
        }
    }
    return hit;
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit_wide(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    var ray = world_ray(origin, direction);
    var stack: array<vec2<u32>, WIDE_STACK_SIZE>;
    var top = 0u;
    var group = vec2<u32>(0u, ROOT_GROUP);
    var leaves = vec2<u32>(0u);
    loop {
        if (leaves.y == 0u) {
            let bit = firstLeadingBit(group.y);
            let node = group_node(group, bit, ray.octant);
            group.y &= ~(1u << bit);
            if (group.y >= FIRST_NODE_BIT) {
                stack[top] = group;
                top += 1u;
            }
            let met = visit_node(node, ray, t_max);
            group = met.xy;
            leaves = met.zw;
        }
        // One a round: rays beside this one that have none left go on meanwhile.
        if (leaves.y != 0u) {
            let place = firstLeadingBit(leaves.y);
            leaves.y &= ~(1u << place);
            let at = (leaves.x + place) * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let kind = bitcast<u32>(e1.w);
            if (may_have(FEATURE_INSTANCES) && kind == SLOT_INSTANCE) {
                if (group.y >= FIRST_NODE_BIT) {
                    stack[top] = group;
                    top += 1u;
                }
                if (leaves.y != 0u) {
                    stack[top] = leaves;
                    top += 1u;
                }
                stack[top] = LEAVE;
                top += 1u;
                ray = instance_ray(bitcast<u32>(v0.w), origin, direction);
                group = vec2<u32>(ray.root, ROOT_GROUP);
                leaves.y = 0u;
                continue;
            }
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < t_max) {
                let id = ray.first_id + bitcast<u32>(v0.w);
                if (kind == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    return true;
                }
            }
        }
        while (leaves.y == 0u && group.y < FIRST_NODE_BIT) {
            if (top == 0u) {
                return false;
            }
            top -= 1u;
            let waiting = stack[top];
            if (!may_have(FEATURE_INSTANCES) || waiting.y >= FIRST_NODE_BIT) {
                group = waiting;
            } else if (waiting.y != 0u) {
                leaves = waiting;
            } else {
                ray = world_ray(origin, direction);
            }
        }
    }
    return false;
}
