// Probe: lib/camera.wgsl, a direction through a film point and back. In: numbers in [0, 1).

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_camera(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let frame = frame_from_normal(probe_unit(probe_input(id.x, 1u).xyz));
    let half = vec2<f32>(0.8, 0.45);
    let size = vec2<f32>(640.0, 360.0);
    let camera = Camera(vec3<f32>(1.0, 2.0, 3.0), 4.0 * half.x * half.y / (size.x * size.y), frame[0], half.x, frame[1], half.y,
        frame[2], size.x, size.y);
    let direction = camera_direction(camera, u.xy * size);
    probe_output(id.x, 0u, vec4<f32>(direction, camera_pdf_sa(camera, dot(direction, camera.forward))));
    probe_output(id.x, 1u, vec4<f32>(camera_project(camera, direction), 0.0));
    probe_output(id.x, 2u, vec4<f32>(u.xy * size, camera_project(camera, -direction).z, 0.0));
}
