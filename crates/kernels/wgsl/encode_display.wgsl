// Turns the resolved image into what a display shows: exposure, tone map, sRGB in 8 bits.
// One invocation: one pixel. Reads: image. Writes: display.

#include "bindings/params.wgsl"
#include "lib/tone_map.wgsl"

@group(0) @binding(12) var<storage, read_write> image: array<vec4<f32>>;
/// RGBA in 8 bits each, one word a pixel.
@group(0) @binding(22) var<storage, read_write> display: array<u32>;

@compute @workgroup_size(64)
fn encode_display(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let pixel = invocation_index(invocation);
    if (pixel >= params.n_pixels) {
        return;
    }
    display[pixel] = pack_srgb8(encode_srgb(image[pixel].xyz, params.exposure_scale, params.tone_map));
}
