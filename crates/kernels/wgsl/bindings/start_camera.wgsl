// Starts camera subpaths, one a pixel sample: through a film point drawn by the pixel's filter and a
// point of the lens.

#include "bindings/camera_sample.wgsl"

/// The path of a place of the batch, ready to be traced: its MIS state as after the lens (lib/mis.wgsl).
fn camera_path(place: u32) -> Path {
    let in_pass = params.first_path + place;
    let pixel = film_pixel(in_pass % params.n_pixels); // n_pixels > 0: an empty film is refused
    let sample = params.first_sample + in_pass / params.n_pixels;
    let ray = camera_sample(pixel, sample);
    let state = mis_begin_camera(mis_config(), ray.pdf);
    return Path(ray.origin, pixel, ray.direction, 0u, 0u, params.camera.parallel != 0u, vec3<f32>(1.0), sample, state,
        params.camera_medium, NO_FACING);
}

/// That path, in a slot.
fn start_camera_path(id: u32, place: u32) {
    store_path(id, camera_path(place));
}
