// Second step: exclusive prefix sums of the blocks, and the pool's size.
// One invocation in all. Reads and writes: light_paths.

#include "bindings/params.wgsl"
#include "bindings/light_vertices.wgsl"

@compute @workgroup_size(64)
fn scan_sums(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if (invocation_index(invocation) != 0u) {
        return;
    }
    var sum = 0u;
    for (var block = 0u; block < n_scan_blocks(); block += 1u) {
        let n = light_paths[block_sums_at() + block];
        light_paths[block_sums_at() + block] = sum;
        sum += n;
    }
    light_paths[pool_size_at()] = sum;
}
