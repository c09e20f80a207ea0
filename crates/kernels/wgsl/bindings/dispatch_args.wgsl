// Grids for indirect dispatch, [x, y, z] each.

#include "bindings/workgroups.wgsl"

@group(0) @binding(11) var<storage, read_write> dispatch_args: array<u32>;

/// Word offsets of the grids.
const ARGS_QUEUE: u32 = 0u;
const ARGS_SHADOW: u32 = 3u;
const ARGS_SPLAT: u32 = 6u;
const ARGS_JOINS: u32 = 9u;
const ARGS_SHADE: u32 = 12u;
const N_ARGS: u32 = 15u;

/// Writes the grid of such workgroups that covers n invocations: rows of GRID_ROW (see invocation_index).
fn write_grid(at: u32, n: u32, workgroup: u32) {
    let row_groups = GRID_ROW / workgroup;
    let groups = (n + workgroup - 1u) / workgroup;
    dispatch_args[at] = min(groups, row_groups);
    dispatch_args[at + 1u] = (groups + row_groups - 1u) / row_groups;
    dispatch_args[at + 2u] = 1u;
}

/// Adds to the two-word count of rays.
fn count_rays(n: u32) {
    let before = atomicAdd(&counters[COUNT_RAYS_LOW], n);
    if (before + n < before) {
        atomicAdd(&counters[COUNT_RAYS_HIGH], 1u);
    }
}

/// Hands the shadow rays pushed so far to trace_shadow.
fn plan_shadow_rays() {
    let length = atomicLoad(&counters[COUNT_SHADOW]);
    atomicStore(&counters[COUNT_SHADOW_TRACE], length);
    atomicStore(&counters[COUNT_SHADOW], 0u);
    write_grid(ARGS_SHADOW, length, WORKGROUP);
    count_rays(length);
}
