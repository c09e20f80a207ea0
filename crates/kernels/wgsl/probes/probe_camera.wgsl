// Probe: lib/camera.wgsl, a ray through a film point and back, for each kind of camera. In: numbers.

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
    let radius = select(0.0, 0.3, (id.x & 1u) != 0u);
    let camera = Camera(vec3<f32>(1.0, 2.0, 3.0), 4.0 * half.x * half.y / (size.x * size.y), frame[0], half.x, frame[1], half.y,
        frame[2], size.x, size.y, radius, 0.4, (id.x >> 1u) & 1u);
    let film = u.xy * size;
    let lens = sample_lens(camera, u.zw);
    let ray = camera_ray(camera, film, lens);
    let behind = camera_project(camera, ray.origin - ray.direction, lens);
    probe_output(id.x, 0u, vec4<f32>(ray.direction, ray.pdf));
    probe_output(id.x, 1u, vec4<f32>(camera_project(camera, ray.origin + 2.5 * ray.direction, lens), behind.z));
    probe_output(id.x, 2u, vec4<f32>(ray.origin, camera_pdf_across(camera, 0.9, 4.0)));
    probe_output(id.x, 3u, vec4<f32>(camera_start(camera, film, lens), film_offset(camera, film).x));
}
