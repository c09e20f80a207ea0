// Mixes what groups of lights add to the image: each by a factor for each channel.
// One invocation: one pixel. Reads: film, group_mix. Writes: image (xyz; w is 1).

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/film.wgsl"

@group(0) @binding(12) var<storage, read_write> image: array<vec4<f32>>;
/// A group's factors, xyz.
@group(0) @binding(25) var<storage, read> group_mix: array<vec4<f32>>;

@compute @workgroup_size(64)
fn mix_groups(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let pixel = invocation_index(invocation);
    if (pixel >= params.n_pixels) {
        return;
    }
    var mixed = vec3<f32>(0.0);
    for (var group = 0u; group < params.n_groups; group += 1u) {
        let at = (group * params.n_pixels + pixel) * FILM_STRIDE;
        mixed += group_mix[group].xyz * vec3<f32>(film_value(at), film_value(at + 2u), film_value(at + 4u));
    }
    image[pixel] = vec4<f32>(mixed / f32(max(params.first_sample, 1u)), 1.0); // first_sample: samples so far
}

fn film_value(word: u32) -> f32 {
    return from_fixed(atomicLoad(&film[word]), atomicLoad(&film[word + 1u]));
}
