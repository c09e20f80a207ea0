// Turns the queue round after a bounce: what was written is read next. Also hands the shadow rays
// pushed meanwhile to trace_shadow, and the light vertices appended to connect_camera, where they last
// one bounce only.
// One invocation in all. Writes: counters, dispatch_args.

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/dispatch_args.wgsl"

@compute @workgroup_size(64)
fn plan_queue(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if (invocation_index(invocation) != 0u) {
        return;
    }
    let front = atomicLoad(&counters[COUNT_OUT]);
    let length = front + atomicLoad(&counters[COUNT_STARTED]);
    atomicStore(&counters[COUNT_IN], length);
    atomicStore(&counters[COUNT_FRONT], front);
    atomicStore(&counters[COUNT_OUT], 0u);
    atomicStore(&counters[COUNT_STARTED], 0u);
    atomicStore(&counters[COUNT_JOINS], 0u);
    atomicStore(&counters[COUNT_PARITY], 1u - atomicLoad(&counters[COUNT_PARITY]));
    write_grid(ARGS_QUEUE, length, WORKGROUP);
    write_grid(ARGS_SHADE, length, SHADE_WORKGROUP);
    if (length > 0u) {
        atomicAdd(&counters[COUNT_BOUNCES], 1u);
    }
    count_rays(length - atomicLoad(&counters[COUNT_WAITING]));
    atomicStore(&counters[COUNT_WAITING], 0u);
    plan_shadow_rays();
    if (params.append_transient != 0u) {
        let n_vertices = atomicLoad(&counters[COUNT_VERTICES]);
        atomicStore(&counters[COUNT_SPLAT_FIRST], 0u);
        atomicStore(&counters[COUNT_SPLAT_END], n_vertices);
        atomicStore(&counters[COUNT_VERTICES], 0u);
        write_grid(ARGS_SPLAT, n_vertices, SHADE_WORKGROUP);
    }
}
