// Starts the first camera subpaths of a batch, as many as there are slots; `shade_camera` starts the
// others as slots come free.
// One invocation: one slot. Writes: paths, queues. Leaves: every slot in the queue's write half
// (plan_queue turns it round), its ray ready to be traced.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/start_camera.wgsl"

@compute @workgroup_size(64)
fn generate_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    start_camera_path(id, id);
    queues[(1u - atomicLoad(&counters[COUNT_PARITY])) * params.n_paths + id] = id;
}
