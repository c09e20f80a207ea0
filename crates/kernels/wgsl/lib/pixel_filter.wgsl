// Pixel filters: separable, not negative, each axis' h integrates to 1 over its full width.
//
// Pixel j is ∫ h(f - c_j) C(f) df, with c_j its centre and C what arrives per film area. Camera
// subpaths draw f = c_j + an offset by the density h, so that each counts in its own pixel with
// weight 1 (filter importance sampling: Ernst, Stamminger and Greiner, "Filter importance sampling",
// 2006). A splat arrives at some f and belongs to every pixel with h(f - c_j) > 0: one of them is
// drawn in proportion to h, and the splat multiplied by their sum Σ_j h(f - c_j), which is 1 for a
// box one pixel wide only. Both are the same integral, pixel by pixel.
//
// Pixels beyond the film, or the crop, are drawn as others are and their share dropped; film points
// beyond the edge reach the pixels within it. So a pixel at an edge is filtered as any other.
//
// MIS weights take one film point a pixel's area for granted (`camera_pdf`), where pixel j really has
// h(f - c_j). Weights may be any function that all strategies share and that sums to 1 over those
// that can make a path. All strategies use the same constant, and for pixel j all can make a path
// wherever h(f - c_j) > 0; so nothing is biased, and no pixel's weight depends on where in its filter
// a path lies.

const FILTER_BOX: u32 = 0u;
const FILTER_BLACKMAN_HARRIS: u32 = 1u;
/// Pixels, full width.
const MAX_FILTER_WIDTH: f32 = 16.0;
/// Pixels along an axis that a filter of that width reaches, one more for rounding.
const MAX_FILTER_PIXELS: u32 = 18u;
/// Steps of Newton's method from below, on a concave function: after them an offset's error is
/// below 1e-6 of the width, in the last 1e-6 of the tails below 2e-4.
const NEWTON_STEPS: u32 = 12u;

/// Harris' window of four terms (1978, minimum sidelobes) over its mean 0.35875.
const HARRIS_1: f32 = 1.36108711;
const HARRIS_2: f32 = 0.393811847;
const HARRIS_3: f32 = 0.0325574913;

struct PixelFilter {
    kind: u32,
    /// Full width in pixels, in (0, MAX_FILTER_WIDTH].
    width: f32,
}

/// A pixel along one axis.
struct FilterPixel {
    /// Its left or upper edge, in pixels.
    place: f32,
    /// What a splat is multiplied by.
    weight: f32,
}

fn is_unit_box(pixel_filter: PixelFilter) -> bool {
    return pixel_filter.kind == FILTER_BOX && pixel_filter.width == 1.0;
}

/// (sin, cos) of 2π t, t in [0, 1/2], by doubling π t / 2 twice.
fn sin_cos_turn(t: f32) -> vec2<f32> {
    let quarter = 2.0 * PI_OVER_4 * t;
    let s1 = sin_quarter(quarter);
    let s2 = 2.0 * s1 * cos_quarter(quarter);
    let c2 = 1.0 - 2.0 * s1 * s1;
    return vec2<f32>(2.0 * s2 * c2, 1.0 - 2.0 * s2 * s2);
}

/// Blackman-Harris over a width of 1, by cos 2πt.
fn harris_window(c: f32) -> f32 {
    return 1.0 + c * HARRIS_1 + (2.0 * c * c - 1.0) * HARRIS_2 + c * (4.0 * c * c - 3.0) * HARRIS_3;
}

/// The share of the window within [-t, t], t in [0, 1/2], by (sin, cos) of 2πt.
fn harris_share(t: f32, turn: vec2<f32>) -> f32 {
    let c = turn.y;
    return 2.0 * t + turn.x * INV_PI * (HARRIS_1 + c * HARRIS_2 + (4.0 * c * c - 1.0) * (HARRIS_3 / 3.0));
}

/// h at a distance from the pixel's centre along one axis, per pixel.
fn filter_value(pixel_filter: PixelFilter, distance: f32) -> f32 {
    let t = abs(distance) / pixel_filter.width; // > 0
    if (!(t <= 0.5)) {
        return 0.0;
    }
    if (pixel_filter.kind == FILTER_BOX) {
        return 1.0 / pixel_filter.width;
    }
    return max(harris_window(sin_cos_turn(t).y), 0.0) / pixel_filter.width;
}

/// An offset from the pixel's centre along one axis, with density h.
fn sample_filter(pixel_filter: PixelFilter, u: f32) -> f32 {
    if (pixel_filter.kind == FILTER_BOX) {
        return (u - 0.5) * pixel_filter.width;
    }
    let share = abs(2.0 * u - 1.0);
    var t = share * (0.5 / (1.0 + HARRIS_1 + HARRIS_2 + HARRIS_3));
    for (var i = 0u; i < NEWTON_STEPS; i += 1u) {
        let turn = sin_cos_turn(t);
        // The window is 1.6e-4 at its ends, and positive between them.
        t = clamp(t - (harris_share(t, turn) - share) / (2.0 * max(harris_window(turn.y), 1e-4)), 0.0, 0.5);
    }
    return select(t, -t, u < 0.5) * pixel_filter.width;
}

/// The pixel that a splat at film coordinate x goes to along one axis, by u in [0, 1); its weight is
/// 0 between pixels that a narrow filter leaves apart.
fn pick_pixel(pixel_filter: PixelFilter, x: f32, u: f32) -> FilterPixel {
    if (is_unit_box(pixel_filter)) {
        return FilterPixel(floor(x), 1.0);
    }
    let first = ceil(x - 0.5 - 0.5 * pixel_filter.width);
    let n = min(u32(pixel_filter.width) + 2u, MAX_FILTER_PIXELS);
    var total = 0.0;
    for (var i = 0u; i < n; i += 1u) {
        total += filter_value(pixel_filter, first + f32(i) + 0.5 - x);
    }
    var left = u * total;
    var place = first;
    for (var i = 0u; i < n; i += 1u) {
        let value = filter_value(pixel_filter, first + f32(i) + 0.5 - x);
        if (left >= 0.0 && value > 0.0) {
            place = first + f32(i);
        }
        left -= value;
    }
    return FilterPixel(place, total);
}
