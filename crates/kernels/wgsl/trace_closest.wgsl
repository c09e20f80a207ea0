// Finds what each queued path's ray hits first.
// One invocation: one queued path. Reads: scene, nodes, triangles, texels, queues. Writes: the hit of each path,
// but for paths that still have joins to make at the vertex they are at.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/geometry.wgsl"
#include "bindings/opacity.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"

@compute @workgroup_size(64)
fn trace_closest(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    let path = load_path(id);
    if (path.joined != 0u) {
        return;
    }
    store_hit(id, closest_hit(path.origin, path.direction, F32_MAX));
}
