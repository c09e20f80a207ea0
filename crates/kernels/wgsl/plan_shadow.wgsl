// Hands the shadow rays pushed so far to trace_shadow.
// One invocation in all. Writes: counters, dispatch_args.

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/dispatch_args.wgsl"

@compute @workgroup_size(64)
fn plan_shadow(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if (invocation_index(invocation) != 0u) {
        return;
    }
    plan_shadow_rays();
}
