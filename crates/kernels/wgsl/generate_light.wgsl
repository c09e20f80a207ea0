// Starts the first light subpaths of a batch, as many as there are slots; `shade_light` starts the
// others as slots come free.
// One invocation: one slot. Writes: paths, queues, light_vertices (y_0, where it can be an end),
// light_paths. Leaves: in the queue's write half (plan_queue turns it round) the slots with a ray to
// be traced.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/start_light.wgsl"
#include "bindings/linked_append.wgsl"

@compute @workgroup_size(64)
fn generate_light(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    if (start_light_path(id, id)) {
        push_started(id);
    } else {
        next_light_path(id);
    }
}
