// Turns the film's sums into radiance: the mean over samples.
// One invocation: one pixel. Reads: film. Writes: image (xyz; w is 1).

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/film.wgsl"

@group(0) @binding(12) var<storage, read_write> image: array<vec4<f32>>;

fn resolve_channel(pixel: u32, channel: u32, n_samples: f32) -> f32 {
    let sum = film_sum(pixel, channel);
    return from_fixed(sum.x, sum.y) / n_samples;
}

@compute @workgroup_size(64)
fn resolve(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let pixel = invocation_index(invocation);
    if (pixel >= params.n_pixels) {
        return;
    }
    let n_samples = f32(max(params.first_sample, 1u)); // samples so far
    image[pixel] = vec4<f32>(resolve_channel(pixel, 0u, n_samples), resolve_channel(pixel, 2u, n_samples), resolve_channel(pixel, 4u, n_samples), 1.0);
}
