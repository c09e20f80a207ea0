// Measures: any hit, compressed wide hierarchy, several rays an invocation.
// One invocation: 16 rays, or none. Reads: nodes, triangles, rays. Writes: hits.

#include "lib/all.wgsl"
#include "bindings/geometry_refilled.wgsl"
#include "bindings/bench_rays.wgsl"

@compute @workgroup_size(64)
fn bench_any_refilled(@builtin(global_invocation_id) id: vec3<u32>) {
    trace_refilled(ray_index(id), arrayLength(&hits), true);
}
