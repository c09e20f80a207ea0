// At each vertex of a light subpath: keep it for joins, roulette, the next direction.
// One invocation: one queued path. Reads: scene, paths, queues. Writes: paths, queues,
// light_vertices, light_paths. Leaves: in the queue's write half the paths that go on, and in the
// slots of those that ended the next of the batch.

#include "bindings/params.wgsl"
#include "bindings/workgroups.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/start_light.wgsl"
#include "bindings/linked_append.wgsl"
#include "bindings/light_tree.wgsl"
#include "bindings/light_step.wgsl"

@compute @workgroup_size(SHADE_WORKGROUP)
fn shade_light(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    let next = step_light(load_path(id), load_hit(id));
    if (contributes(next.throughput)) {
        store_path(id, next);
        push_path(id);
    } else {
        next_light_path(id);
    }
}
