// Traversal of the binary hierarchy, speculative while-while (Aila and Laine 2009): a ray that meets a
// leaf keeps it and goes on to the next, so that fewer rays of a group wait while others still
// descend. What is kept is tested later than it could be, at the price of nodes that it would have
// culled. For comparison (`midway bench rays`): one level, everything solid.

#include "bindings/geometry.wgsl"

/// The nearest triangle with 0 < t < t_max; its `triangle` is NONE if there is none.
fn closest_hit_speculative(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> Hit {
    let inverse = safe_inverse(direction);
    var hit = Hit(t_max, 0.0, 0.0, NONE);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    var kept = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * BINARY_STRIDE;
            let a = nodes[at];
            let b = nodes[at + 1u];
            let c = nodes[at + 2u];
            let d = nodes[at + 3u];
            let left = intersect_box(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b.xyz), origin, inverse, hit.t);
            let right = intersect_box(bitcast<vec3<f32>>(c.xyz), bitcast<vec3<f32>>(d.xyz), origin, inverse, hit.t);
            let hits_left = left.x <= left.y;
            let hits_right = right.x <= right.y;
            if (hits_left || hits_right) {
                let left_first = hits_left && (!hits_right || left.x <= right.x);
                node = select(b.w, a.w, left_first);
                if (hits_left && hits_right) {
                    stack[top] = select(a.w, b.w, left_first);
                    top += 1u;
                }
            } else {
                top -= 1u;
                node = stack[top];
            }
            if ((node & LEAF_BIT) != 0u && kept == 0u && node != STACK_BOTTOM) {
                kept = node;
                top -= 1u;
                node = stack[top];
            }
        }
        // The kept leaf, then the one that ended the descent.
        var leaf = select(node, kept, kept != 0u);
        loop {
            let first = (leaf & ~LEAF_BIT) >> 4u;
            let end = select(first + (leaf & LEAF_COUNT_MASK), first, leaf == STACK_BOTTOM);
            for (var slot = first; slot < end; slot += 1u) {
                let at = slot * TRIANGLE_STRIDE;
                let v0 = triangles[at];
                let tuv = intersect_triangle(v0.xyz, triangles[at + 1u].xyz, triangles[at + 2u].xyz, origin, direction);
                if (tuv.x > 0.0 && tuv.x < hit.t) {
                    hit = Hit(tuv.x, tuv.y, tuv.z, bitcast<u32>(v0.w));
                }
            }
            if (leaf == node) {
                break;
            }
            leaf = node;
        }
        kept = 0u;
        if (node == STACK_BOTTOM) {
            break;
        }
        top -= 1u;
        node = stack[top];
    }
    return hit;
}

/// Whether any triangle lies at 0 < t < t_max.
fn any_hit_speculative(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    let inverse = safe_inverse(direction);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = STACK_BOTTOM;
    var top = 1u;
    var node = 0u;
    var kept = 0u;
    loop {
        while ((node & LEAF_BIT) == 0u) {
            let at = node * BINARY_STRIDE;
            let a = nodes[at];
            let b = nodes[at + 1u];
            let c = nodes[at + 2u];
            let d = nodes[at + 3u];
            let left = intersect_box(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b.xyz), origin, inverse, t_max);
            let right = intersect_box(bitcast<vec3<f32>>(c.xyz), bitcast<vec3<f32>>(d.xyz), origin, inverse, t_max);
            let hits_left = left.x <= left.y;
            let hits_right = right.x <= right.y;
            if (hits_left || hits_right) {
                node = select(b.w, a.w, hits_left);
                if (hits_left && hits_right) {
                    stack[top] = b.w;
                    top += 1u;
                }
            } else {
                top -= 1u;
                node = stack[top];
            }
            if ((node & LEAF_BIT) != 0u && kept == 0u && node != STACK_BOTTOM) {
                kept = node;
                top -= 1u;
                node = stack[top];
            }
        }
        var leaf = select(node, kept, kept != 0u);
        loop {
            let first = (leaf & ~LEAF_BIT) >> 4u;
            let end = select(first + (leaf & LEAF_COUNT_MASK), first, leaf == STACK_BOTTOM);
            for (var slot = first; slot < end; slot += 1u) {
                let at = slot * TRIANGLE_STRIDE;
                let tuv = intersect_triangle(triangles[at].xyz, triangles[at + 1u].xyz, triangles[at + 2u].xyz, origin, direction);
                if (tuv.x > 0.0 && tuv.x < t_max) {
                    return true;
                }
            }
            if (leaf == node) {
                break;
            }
            leaf = node;
        }
        kept = 0u;
        if (node == STACK_BOTTOM) {
            break;
        }
        top -= 1u;
        node = stack[top];
    }
    return false;
}
