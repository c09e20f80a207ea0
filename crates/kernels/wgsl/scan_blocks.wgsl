// First step of addressing a pool by (path, depth): the number of vertices in each block of paths.
// One invocation: one block of SCAN_BLOCK paths. Reads and writes: light_paths.

#include "bindings/params.wgsl"
#include "bindings/light_vertices.wgsl"

@compute @workgroup_size(64)
fn scan_blocks(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let block = invocation_index(invocation);
    if (block >= n_scan_blocks()) {
        return;
    }
    let end = min((block + 1u) * SCAN_BLOCK, params.n_light_paths);
    var sum = 0u;
    for (var path = block * SCAN_BLOCK; path < end; path += 1u) {
        sum += path_vertex_count(path);
    }
    light_paths[block_sums_at() + block] = sum;
}
