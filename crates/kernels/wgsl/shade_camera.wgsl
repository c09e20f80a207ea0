// At each vertex of a camera subpath: light found by hitting it (s = 0), light sampled afresh
// (s = 1), roulette, and the next direction.
// One invocation: one queued path. Reads: scene, paths, queues. Writes: paths, queues, shadow_rays,
// film. Leaves: in the queue's write half the paths that go on, those that `list_joins` has not finished
// with, unchanged, and in the slots of those that ended the next of the batch.

#include "bindings/params.wgsl"
#include "bindings/workgroups.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/light_tree.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/shadow_rays.wgsl"
#include "bindings/film.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/light_join.wgsl"
#include "bindings/start_camera.wgsl"
#include "bindings/camera_step.wgsl"

@compute @workgroup_size(SHADE_WORKGROUP)
fn shade_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    let path = load_path(id);
    if (path.joined != 0u) {
        push_path(id);
        return;
    }
    let hit = load_hit(id);
    if (hit.triangle == NONE) {
        escape(path);
    } else {
        let next = step_camera(path, arrive(path, hit, 0u));
        if (contributes(next.throughput)) {
            store_path(id, next);
            push_path(id);
            return;
        }
    }
    let waiting = take_place();
    if (waiting != NONE) {
        start_camera_path(id, waiting);
        push_started(id);
    }
}
