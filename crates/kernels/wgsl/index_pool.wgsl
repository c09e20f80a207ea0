// Last step: the table of vertex slots in the order of (path, depth), so that draws from the pool
// do not depend on the order of appends.
// One invocation: one block of SCAN_BLOCK paths. Reads and writes: light_paths. Reads: light_vertices.

#include "bindings/params.wgsl"
#include "bindings/light_vertices.wgsl"

@compute @workgroup_size(64)
fn index_pool(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let block = invocation_index(invocation);
    if (block >= n_scan_blocks()) {
        return;
    }
    let end = min((block + 1u) * SCAN_BLOCK, params.n_light_paths);
    var place = pool_table_at() + light_paths[block_sums_at() + block];
    for (var path = block * SCAN_BLOCK; path < end; path += 1u) {
        let n = path_vertex_count(path);
        var slot = path_second_word(path);
        for (var i = n; i > 0u; i -= 1u) {
            light_paths[place + i - 1u] = slot;
            slot = load_light_vertex(slot).link;
        }
        place += n;
    }
}
