// Probe: traversal. In: a ray's origin (w: the length of its shadow segment) and direction.

#include "bindings/probe.wgsl"
#include "bindings/geometry.wgsl"

/// Everything is solid here. (It looks at a buffer, as every `passes` does, for the CPU's own traversal.)
fn passes(id: u32, u: f32, v: f32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    return probe_count() == 0u;
}

@compute @workgroup_size(64)
fn probe_traversal(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let origin = probe_input(id.x, 0u);
    let direction = probe_input(id.x, 1u).xyz;
    let hit = closest_hit(origin.xyz, direction, F32_MAX);
    let blocked = any_hit(origin.xyz, direction, origin.w);
    probe_output(id.x, 0u, vec4<f32>(hit.t, hit.u, hit.v, bitcast<f32>(hit.triangle)));
    probe_output(id.x, 1u, vec4<f32>(f32(blocked), 0.0, 0.0, 0.0));
}
