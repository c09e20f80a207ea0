// Traversal of the binary hierarchy: both children's boxes in a node, while-while (Aila and Laine,
// "Understanding the Efficiency of Ray Traversal on GPUs", 2009). crates/accel has the layout (`Bvh`).

/// vec4 per node: left min, left reference; left max, right reference; right min; right max.
const BINARY_STRIDE: u32 = 4u;
/// What waits; the builder keeps both levels together shallower.
const STACK_SIZE: u32 = 64u;
const LEAF_BIT: u32 = 0x80000000u;
const LEAF_COUNT_MASK: u32 = 15u;
/// Below the bottom of the stack, and where the ray leaves an instance: no leaf's references.
const STACK_BOTTOM: u32 = 0xffffffffu;
const STACK_LEAVE: u32 = 0xffffffefu;

/// min and max for slabs, which have no NaN (safe_inverse): a single instruction on a CPU, where
/// WGSL's own, which must prefer the other operand to a NaN, take five.
fn lesser(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, a < b);
}

fn greater(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, a > b);
}

fn lesser1(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn greater1(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

/// Entry and exit distance of the slabs; a miss has x > y. The exit is widened by 2 ulp, so that
/// rounding never loses a box (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
fn intersect_box(box_min: vec3<f32>, box_max: vec3<f32>, origin: vec3<f32>, inverse: vec3<f32>, t_max: f32) -> vec2<f32> {
    let a = (box_min - origin) * inverse;
    let b = (box_max - origin) * inverse;
    let low = lesser(a, b);
    let high = greater(a, b);
    let enter = greater1(greater1(low.x, low.y), greater1(low.z, 0.0));
    let leave = lesser1(lesser1(high.x, high.y), high.z) * 1.0000004;
    return vec2<f32>(enter, lesser1(leave, t_max));
}

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit_binary(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    var ray = world_ray(origin, direction);
    var hit = Hit(t_max, 0.0, 0.0, NONE);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * BINARY_STRIDE;
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
        if (node == STACK_BOTTOM) {
            break;
        }
        if (may_have(FEATURE_INSTANCES) && node == STACK_LEAVE) {
            ray = world_ray(origin, direction);
            top -= 1u;
            node = stack[top];
            continue;
        }
        let first = (node & ~LEAF_BIT) >> 4u;
        let end = first + (node & LEAF_COUNT_MASK);
        top -= 1u;
        node = stack[top];
        for (var slot = first; slot < end; slot += 1u) {
            let at = slot * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let kind = bitcast<u32>(e1.w);
            if (may_have(FEATURE_INSTANCES) && kind == SLOT_INSTANCE) {
                // What was on top stays; above it the rest of the leaf and the mark.
                stack[top + 1u] = LEAF_BIT | ((slot + 1u) << 4u) | (end - slot - 1u);
                stack[top + 2u] = STACK_LEAVE;
                top += 3u;
                ray = instance_ray(bitcast<u32>(v0.w), origin, direction);
                node = ray.root;
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
    }
    return hit;
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit_binary(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    var ray = world_ray(origin, direction);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * BINARY_STRIDE;
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
        if (node == STACK_BOTTOM) {
            break;
        }
        if (may_have(FEATURE_INSTANCES) && node == STACK_LEAVE) {
            ray = world_ray(origin, direction);
            top -= 1u;
            node = stack[top];
            continue;
        }
        let first = (node & ~LEAF_BIT) >> 4u;
        let end = first + (node & LEAF_COUNT_MASK);
        top -= 1u;
        node = stack[top];
        for (var slot = first; slot < end; slot += 1u) {
            let at = slot * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let e1 = triangles[at + 1u];
            let kind = bitcast<u32>(e1.w);
            if (may_have(FEATURE_INSTANCES) && kind == SLOT_INSTANCE) {
                // What was on top stays; above it the rest of the leaf and the mark.
                stack[top + 1u] = LEAF_BIT | ((slot + 1u) << 4u) | (end - slot - 1u);
                stack[top + 2u] = STACK_LEAVE;
                top += 3u;
                ray = instance_ray(bitcast<u32>(v0.w), origin, direction);
                node = ray.root;
                break;
            }
            let tuv = intersect_triangle(v0.xyz, e1.xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < t_max) {
                let id = ray.first_id + bitcast<u32>(v0.w);
                if (kind == SLOT_SOLID || !passes(id, tuv.y, tuv.z, origin, direction)) {
                    return true;
                }
            }
        }
    }
    return false;
}
