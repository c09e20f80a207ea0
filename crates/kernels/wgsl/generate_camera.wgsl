// Starts the camera subpaths of a batch: one path a pixel sample, through a point drawn uniformly
// in its pixel (box filter).
// One invocation: one path. Writes: paths, queues. Leaves: every path of the batch in the queue's
// write half (plan_queue turns it round), its ray ready to be traced, its MIS state as after the lens (lib/mis.wgsl).

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/paths.wgsl"
#include "bindings/queues.wgsl"

@compute @workgroup_size(64)
fn generate_camera(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation_index(invocation);
    if (id >= params.n_paths) {
        return;
    }
    let place = params.first_path + id;
    let pixel = place % params.n_pixels; // n_pixels > 0: an empty film is refused
    let sample = params.first_sample + place / params.n_pixels;
    let jitter = random(pixel, sample, dimension(DRAW_FILM, 0u)).xy;
    let corner = vec2<f32>(vec2<u32>(params.crop_x + pixel % params.crop_width, params.crop_y + pixel / params.crop_width));
    let direction = camera_direction(params.camera, corner + jitter);
    let pdf = camera_pdf_sa(params.camera, dot(direction, params.camera.forward));
    let state = mis_begin_camera(mis_config(), pdf);
    store_path(id, Path(params.camera.origin, pixel, direction, 0u, 0u, false, vec3<f32>(1.0), sample, state, params.camera_medium));
    queues[(1u - atomicLoad(&counters[COUNT_PARITY])) * params.n_paths + id] = id;
}
