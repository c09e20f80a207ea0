// At each vertex of a light subpath: keep it for joins, roulette, the next direction.
// One invocation: one queued path. Reads: scene, paths, queues. Writes: paths, queues,
// light_vertices, light_paths. Leaves: in the queue's write half the paths that go on, and in the
// slots of those that ended the next of the batch.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/vertex.wgsl"
#include "bindings/start_light.wgsl"
#include "bindings/light_tree.wgsl"

@compute @workgroup_size(64)
fn shade_light(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let place = invocation_index(invocation);
    if (place >= queue_length()) {
        return;
    }
    let id = queued_path(place);
    if (shade(id, load_path(id))) {
        push_path(id);
    } else {
        next_light_path(id);
    }
}

/// Whether the path goes on.
fn shade(id: u32, path: Path) -> bool {
    let hit = load_hit(id);
    if (hit.triangle == NONE || !any(path.throughput != vec3<f32>(0.0))) {
        return false;
    }
    var vertex = arrive(path, hit, DRAW_LIGHT);
    let s = path.depth + 2u; // with y_0 and this vertex
    if (!length_allowed(s, 1u)) {
        return false;
    }
    if (s == 2u && uses_light_tree()) {
        // (2) has the chance by power at y_0, which the path began by; s = 1 here draws by the tree.
        let light = light_of_path(path);
        let ratio = light_chance_ratio(light, load_light(light), light_place(vertex));
        vertex.mis.dvcm *= mis_power(mis_config(), ratio);
    }
    let connectible = is_connectible(vertex.material);
    let stored = LightVertex(vertex.surface.position, hit.triangle, vertex.throughput, vertex.mis.dvcm,
        vertex.wo, vertex.mis.dvc, hit.u, hit.v, bitcast<u32>(vertex.mis.ending), s, light_path_group(path));
    if (connectible) {
        keep_light_vertex(path, stored);
    }
    let u = scatter_numbers(path, DRAW_LIGHT);
    if (u.w >= vertex.survival) {
        if (connectible) {
            end_light_path(light_path_slot(path), stored);
        }
        return false;
    }
    let factor = light_previous_factor(mis_config(), s, vertex.mis, vertex.ending);
    let next = scatter(path, vertex, factor, u.xyz, TRANSPORT_IMPORTANCE);
    if (!any(next.throughput != vec3<f32>(0.0))) {
        return false;
    }
    store_path(id, next);
    return true;
}
