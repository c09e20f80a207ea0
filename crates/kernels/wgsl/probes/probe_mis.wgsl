// Probe: lib/mis.wgsl. In: positive densities, distances and cosines.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_mis(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let a = 0.1 + abs(probe_input(id.x, 0u));
    let b = 0.1 + abs(probe_input(id.x, 1u));
    let config = MisConfig(id.x % 2u, (id.x / 2u) % 2u, (id.x / 4u) % 2u, 0.7, 300.0);
    let camera = mis_arrive(config, mis_begin_camera(config, a.x), a.y, min(a.z, 1.0));
    let light = mis_arrive(config, mis_begin_light(config, b.x, b.x, b.y, min(b.z, 1.0), 0.5), a.w, min(b.w, 1.0));
    let ending = ending_chance(config, 0.6);
    let scattered = mis_scatter(config, camera, camera_previous_factor(config, 2u, camera, ending), 0.5, a.x, b.x, ending);
    let light_sum = mis_earlier(config, light, light_previous_factor(config, 2u, light, ending), b.y);
    let camera_sum = mis_earlier(config, scattered, join_factor(config, scattered.ending, ending), a.y);
    probe_output(id.x, 0u, vec4<f32>(camera.dvcm, camera.dvc, light.dvcm, light.dvc));
    probe_output(id.x, 1u, vec4<f32>(scattered.dvcm, scattered.dvc, light_sum, camera_sum));
    probe_output(id.x, 2u, vec4<f32>(
        mis_weight_join(config, join_factor(config, ending, ending), a.x, light_sum, b.x, camera_sum),
        mis_weight_hit(config, scattered, 1.0, a.z, b.z),
        mis_weight_emitter(config, 1.0, a.x, b.x, b.x, a.y, camera_sum),
        mis_weight_splat(config, a.x, light_sum)));
    probe_output(id.x, 3u, vec4<f32>(mis_scatter_delta(config, camera, 0.5, ending).dvc, 0.0, 0.0, 0.0));
}
