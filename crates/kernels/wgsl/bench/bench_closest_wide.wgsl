// Measures: closest hit, compressed wide hierarchy.
// One invocation: one ray. Reads: nodes, triangles, rays. Writes: hits.

#include "lib/all.wgsl"
#include "bindings/geometry.wgsl"
#include "bindings/bench_rays.wgsl"

@compute @workgroup_size(64)
fn bench_closest_wide(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = ray_index(id);
    if (index >= arrayLength(&hits)) {
        return;
    }
    let ray = load_bench_ray(index);
    store_closest(index, closest_hit(ray.origin, ray.direction, ray.t_max));
}
