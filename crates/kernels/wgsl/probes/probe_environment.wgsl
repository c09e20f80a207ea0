// Probe: the environment of a packed scene: a direction drawn by importance, what comes from it, and
// what comes from another. In: nothing but the invocation's index, and a direction.

#include "bindings/probe.wgsl"
#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/environment.wgsl"

@compute @workgroup_size(64)
fn probe_environment(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let environment = load_environment();
    let direction = draw_environment(environment, draw_bits(id.x, 0u, 0u, 2026u));
    let seen = environment_towards(environment, direction);
    probe_output(id.x, 0u, vec4<f32>(direction, seen.pdf));
    probe_output(id.x, 1u, vec4<f32>(seen.radiance, 0.0));
    let other = environment_towards(environment, probe_unit(probe_input(id.x, 0u).xyz));
    probe_output(id.x, 2u, vec4<f32>(other.radiance, other.pdf));
}
