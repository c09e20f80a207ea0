// Starts the camera subpaths of a batch: one path a pixel sample, through a film point drawn by the
// pixel's filter and a point of the lens.
// One invocation: one path. Writes: paths, queues. Leaves: every path of the batch in the queue's
// write half (plan_queue turns it round), its ray ready to be traced, its MIS state as after the lens (lib/mis.wgsl).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/camera_sample.wgsl"

@compute @workgroup_size(64)
fn generate_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    let place = params.first_path + id;
    let pixel = film_pixel(place % params.n_pixels); // n_pixels > 0: an empty film is refused
    let sample = params.first_sample + place / params.n_pixels;
    let ray = camera_sample(pixel, sample);
    let state = mis_begin_camera(mis_config(), ray.pdf);
    store_path(id, Path(ray.origin, pixel, ray.direction, 0u, 0u, params.camera.parallel != 0u, vec3<f32>(1.0), sample, state,
        params.camera_medium));
    queues[(1u - atomicLoad(&counters[COUNT_PARITY])) * params.n_paths + id] = id;
}
