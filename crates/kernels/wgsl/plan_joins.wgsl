// Hands the joins listed in a bounce to connect.
// One invocation in all. Writes: dispatch_args.

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/dispatch_args.wgsl"
#include "bindings/join_list.wgsl"

@compute @workgroup_size(64)
fn plan_joins(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if (invocation_index(invocation) != 0u) {
        return;
    }
    let run = joins_per_invocation(); // > 0
    write_grid(ARGS_JOINS, (atomicLoad(&counters[COUNT_JOINS]) + run - 1u) / run, SHADE_WORKGROUP);
}
