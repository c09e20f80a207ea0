// After a pass: adds the squared deviation of its mean from the mean so far to each channel's sum.
// Passes are independent, splats and pools included; a sample's splats by themselves are not known.
// One invocation: one pixel of the window. Reads: film. Reads and writes: moments.
//
// With passes of n_b samples and means m_b, M the mean of all N samples, Σ n_b (m_b - M)² grows by
// n N (m - M)² / (N + n) with a pass of n samples (West, "Updating mean and variance estimates",
// 1979). Divided by the number of passes less 1 it is the variance of a sample, without bias
// whatever the n_b; by N again, that of the pixel.

#include "bindings/params.wgsl"
#include "bindings/queues.wgsl"
#include "bindings/film.wgsl"

/// Words per pixel: for each channel the film's sum after the pass before (low, high), and the
/// squared deviations (f32).
const MOMENTS_STRIDE: u32 = 9u;

@group(0) @binding(21) var<storage, read_write> moments: array<u32>;

@compute @workgroup_size(64)
fn measure_variance(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let pixel = invocation_index(invocation);
    if (pixel >= params.n_pixels) {
        return;
    }
    for (var channel = 0u; channel < 3u; channel += 1u) {
        add_pass(film_sum(pixel, 2u * channel), pixel * MOMENTS_STRIDE + 3u * channel);
    }
}

/// `sum`: the channel's on the film; `at`: its words in moments; first_sample samples were done before the pass.
fn add_pass(sum: vec2<u32>, at: u32) {
    let low = sum.x;
    let high = sum.y;
    let low_before = moments[at];
    let high_before = moments[at + 1u];
    moments[at] = low;
    moments[at + 1u] = high;
    if (params.first_sample == 0u) {
        return;
    }
    let borrow = select(0u, 1u, low < low_before);
    let n_before = f32(params.first_sample);
    let n = f32(params.pass_samples); // > 0
    let deviation = from_fixed(low - low_before, high - high_before - borrow) / n - from_fixed(low_before, high_before) / n_before;
    let squares = bitcast<f32>(moments[at + 2u]) + deviation * deviation * (n * n_before / (n + n_before));
    moments[at + 2u] = bitcast<u32>(squares);
}
