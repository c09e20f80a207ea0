// Projects light vertices onto the film (t = 1), each through a lens point of its own and into a
// pixel drawn by the filter.
// One invocation: one stored vertex of the range in the counters. Reads: scene, light_vertices.
// Writes: shadow_rays. Each vertex makes one ray at most.

#include "bindings/params.wgsl"
#include "bindings/workgroups.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/stored_vertex.wgsl"
#include "bindings/splat.wgsl"

@compute @workgroup_size(SHADE_WORKGROUP)
fn connect_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let index = atomicLoad(&counters[COUNT_SPLAT_FIRST]) + invocation_index(invocation);
    if (index >= atomicLoad(&counters[COUNT_SPLAT_END])) {
        return;
    }
    splat_light_vertex(load_light_vertex(params.append_at + index));
}
