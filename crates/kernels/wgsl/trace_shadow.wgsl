// Tests the contributions that wait for visibility and adds what is unoccluded to the film.
// One invocation: one shadow ray. Reads: scene, nodes, triangles, texels, shadow_rays. Writes: film.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/geometry.wgsl"
#include "bindings/opacity.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/film.wgsl"
#include "bindings/visibility.wgsl"

@compute @workgroup_size(64)
fn trace_shadow(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = invocation_index(invocation);
    if (index >= atomicLoad(&counters[COUNT_SHADOW_TRACE])) {
        return;
    }
    let at = index * SHADOW_STRIDE;
    let start = shadow_rays[at];
    let segment = shadow_rays[at + 1u];
    if (is_free(start.xyz, segment.xyz)) {
        film_add(bitcast<u32>(start.w), bitcast<u32>(segment.w), shadow_rays[at + 2u].xyz);
    }
}
