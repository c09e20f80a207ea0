// The film: sums of contributions, six words a pixel (low and high of R, G, B). Where groups of lights
// are kept apart there is such a film for each, one behind the other; the image is their sum.

const FILM_STRIDE: u32 = 6u;

@group(0) @binding(8) var<storage, read_write> film: array<atomic<u32>>;

fn film_add_channel(word: u32, value: f32) {
    let fixed = to_fixed(value);
    let before = atomicAdd(&film[word], fixed.x);
    let carry = select(0u, 1u, before + fixed.x < before);
    let high = fixed.y + carry;
    if (high != 0u) {
        let high_before = atomicAdd(&film[word + 1u], high);
        if (high_before + high < high_before) {
            atomicAdd(&counters[COUNT_OVERFLOW], 1u);
        }
    }
}

/// Adds radiance that comes from a light of `group` to the sum of a pixel of the window, given by its
/// number in the full film. What is not a finite, non-negative number is counted instead.
fn film_add(pixel: u32, group: u32, contribution: vec3<f32>) {
    let largest = max3(contribution);
    let smallest = min(contribution.x, min(contribution.y, contribution.z));
    let finite = is_finite(contribution.x) && is_finite(contribution.y) && is_finite(contribution.z);
    if (!finite || smallest < 0.0 || largest > FIXED_MAX) {
        atomicAdd(&counters[COUNT_REJECTED], 1u);
        return;
    }
    let scale = select(1.0, params.clamp / largest, largest > params.clamp);
    let first = select(0u, group * params.n_pixels, keeps_groups());
    let word = (first + window_pixel(pixel)) * FILM_STRIDE;
    film_add_channel(word, contribution.x * scale);
    film_add_channel(word + 2u, contribution.y * scale);
    film_add_channel(word + 4u, contribution.z * scale);
}

/// The sum of a channel (0, 2 or 4: its word) of a pixel of the window over all groups, as (low, high):
/// the very integer that one film of them all would hold.
fn film_sum(pixel: u32, channel: u32) -> vec2<u32> {
    let word = pixel * FILM_STRIDE + channel;
    var sum = vec2<u32>(atomicLoad(&film[word]), atomicLoad(&film[word + 1u]));
    if (!keeps_groups()) {
        return sum;
    }
    for (var group = 1u; group < params.n_groups; group += 1u) {
        let at = word + group * params.n_pixels * FILM_STRIDE;
        let low = sum.x + atomicLoad(&film[at]);
        sum = vec2<u32>(low, sum.y + atomicLoad(&film[at + 1u]) + select(0u, 1u, low < sum.x));
    }
    return sum;
}
