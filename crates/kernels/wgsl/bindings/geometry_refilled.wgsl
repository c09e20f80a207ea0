// Traversal of the wide hierarchy by invocations that take another ray as soon as they have done with one, so
// that few of a group wait for its longest (Aila and Laine 2009 have a whole group fetch at once; here each
// goes on by itself, along a column of its group's block of rays). What it gains where rays have nothing in common
// it loses where neighbours do, as the renderer's own: they drift apart. For comparison (`midway bench rays`): one
// level, everything solid.

#include "bindings/geometry.wgsl"

/// Invocations that run together, and rays of each.
const REFILL_GROUP: u32 = 32u;
const REFILL_RAYS: u32 = 16u;

/// Traces an invocation's rays: the nearest hit of each, or any. Invocations beyond a 16th of the rays have none.
fn trace_refilled(invocation: u32, n_rays: u32, any: bool) {
    let group_first = (invocation / REFILL_GROUP) * REFILL_GROUP * REFILL_RAYS;
    var next = group_first + invocation % REFILL_GROUP;
    let end = min(group_first + REFILL_GROUP * REFILL_RAYS, n_rays);
    var index = NONE;
    var ray = world_ray(vec3<f32>(0.0), vec3<f32>(1.0));
    var hit = Hit(0.0, 0.0, 0.0, NONE);
    var stack: array<vec2<u32>, WIDE_STACK_SIZE>;
    var top = 0u;
    var group = vec2<u32>(0u);
    var leaves = vec2<u32>(0u);
    loop {
        while (leaves.y == 0u && group.y < FIRST_NODE_BIT) {
            if (top > 0u) {
                top -= 1u;
                group = stack[top];
                continue;
            }
            if (index != NONE) {
                store_refilled(index, hit, any);
            }
            if (next >= end) {
                return;
            }
            index = next;
            next += REFILL_GROUP;
            let fetched = load_bench_ray(index);
            ray = world_ray(fetched.origin, fetched.direction);
            hit = Hit(fetched.t_max, 0.0, 0.0, NONE);
            group = vec2<u32>(0u, ROOT_GROUP);
        }
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
        if (leaves.y != 0u) {
            let place = firstLeadingBit(leaves.y);
            leaves.y &= ~(1u << place);
            let at = (leaves.x + place) * TRIANGLE_STRIDE;
            let v0 = triangles[at];
            let tuv = intersect_triangle(v0.xyz, triangles[at + 1u].xyz, triangles[at + 2u].xyz, ray.origin, ray.direction);
            if (tuv.x > 0.0 && tuv.x < hit.t) {
                hit = Hit(tuv.x, tuv.y, tuv.z, bitcast<u32>(v0.w));
                if (any) {
                    top = 0u;
                    leaves.y = 0u;
                    group.y = 0u;
                }
            }
        }
    }
}

fn store_refilled(index: u32, hit: Hit, any: bool) {
    if (any) {
        store_any(index, hit.triangle != NONE);
    } else {
        store_closest(index, hit);
    }
}
