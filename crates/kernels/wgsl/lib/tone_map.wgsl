// From scene-linear radiance to what a display shows: the tone maps of crates/film's tone_map.rs, which
// has their sources; a test holds the two to each other.

// Params.tone_map
const TONE_MAP_LINEAR: u32 = 0u;
const TONE_MAP_AGX: u32 = 1u;
const TONE_MAP_ACES: u32 = 2u;
const TONE_MAP_PBR_NEUTRAL: u32 = 3u;

/// The range of AgX's log2 encoding, in stops.
const AGX_MIN_EV: f32 = -12.47393;
const AGX_MAX_EV: f32 = 4.026069;

/// Where PBR Neutral begins to compress, and how it desaturates.
const NEUTRAL_START: f32 = 0.76;
const NEUTRAL_DESATURATION: f32 = 0.15;

/// IEC 61966-2-1's curve, for a value in [0, 1].
fn srgb_from_linear(value: f32) -> f32 {
    if (value <= 0.0031308) {
        return value * 12.92;
    }
    return 1.055 * pow(value, 1.0 / 2.4) - 0.055;
}

/// The sigmoid in AgX's log space, as a polynomial, of one channel.
fn agx_curve(value: f32) -> f32 {
    let log = clamp(log2(max(value, 1e-10)), AGX_MIN_EV, AGX_MAX_EV);
    let x = (log - AGX_MIN_EV) / (AGX_MAX_EV - AGX_MIN_EV);
    let x2 = x * x;
    let x4 = x2 * x2;
    return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

fn agx(c: vec3<f32>) -> vec3<f32> {
    let inset = vec3<f32>(
        dot(c, vec3<f32>(0.84247905, 0.0784336, 0.079223745)),
        dot(c, vec3<f32>(0.042328242, 0.87846864, 0.07916613)),
        dot(c, vec3<f32>(0.042375654, 0.0784336, 0.879143)),
    );
    let curved = vec3<f32>(agx_curve(inset.x), agx_curve(inset.y), agx_curve(inset.z));
    let r = dot(curved, vec3<f32>(1.196879, -0.09802088, -0.09902974));
    let g = dot(curved, vec3<f32>(-0.05289685, 1.1519031, -0.098961174));
    let b = dot(curved, vec3<f32>(-0.05297164, -0.098043450, 1.1510737));
    return vec3<f32>(pow(max(r, 0.0), 2.2), pow(max(g, 0.0), 2.2), pow(max(b, 0.0), 2.2));
}

/// The fit of one channel; its denominator is at least 0.238.
fn aces_curve(v: f32) -> f32 {
    return (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
}

fn aces(colour: vec3<f32>) -> vec3<f32> {
    // Beyond 1e6 the fit is at its limit of 1 and its squares would overflow.
    let c = min(colour, vec3<f32>(1e6));
    let r = aces_curve(dot(c, vec3<f32>(0.59719, 0.35458, 0.04823)));
    let g = aces_curve(dot(c, vec3<f32>(0.07600, 0.90834, 0.01566)));
    let b = aces_curve(dot(c, vec3<f32>(0.02840, 0.13383, 0.83777)));
    let curved = vec3<f32>(r, g, b);
    return vec3<f32>(
        dot(curved, vec3<f32>(1.60475, -0.53108, -0.07367)),
        dot(curved, vec3<f32>(-0.10208, 1.10813, -0.00605)),
        dot(curved, vec3<f32>(-0.00327, -0.07276, 1.07602)),
    );
}

fn pbr_neutral(colour: vec3<f32>) -> vec3<f32> {
    let least = min(colour.x, min(colour.y, colour.z));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let c = colour - vec3<f32>(offset);
    let peak = max(c.x, max(c.y, c.z));
    if (peak < NEUTRAL_START) {
        return c;
    }
    let d = 1.0 - NEUTRAL_START;
    let new_peak = 1.0 - d * d / (peak + d - NEUTRAL_START); // peak >= NEUTRAL_START
    let grey = 1.0 - 1.0 / (NEUTRAL_DESATURATION * (peak - new_peak) + 1.0);
    return c * (new_peak / peak) * (1.0 - grey) + vec3<f32>(new_peak * grey);
}

/// The sRGB-encoded colour in [0, 1] of radiance times `scale`; magenta where it is not finite.
fn encode_srgb(radiance: vec3<f32>, scale: f32, tone_map: u32) -> vec3<f32> {
    if (!is_finite(radiance.x) || !is_finite(radiance.y) || !is_finite(radiance.z)) {
        return vec3<f32>(1.0, 0.0, 1.0);
    }
    let exposed = clamp(radiance * scale, vec3<f32>(0.0), vec3<f32>(F32_MAX));
    var mapped = exposed;
    switch tone_map {
        case TONE_MAP_AGX: { mapped = agx(exposed); }
        case TONE_MAP_ACES: { mapped = aces(exposed); }
        case TONE_MAP_PBR_NEUTRAL: { mapped = pbr_neutral(exposed); }
        default: {}
    }
    let shown = clamp(mapped, vec3<f32>(0.0), vec3<f32>(1.0));
    return vec3<f32>(srgb_from_linear(shown.x), srgb_from_linear(shown.y), srgb_from_linear(shown.z));
}

/// Rounded to 8 bits: red in the lowest byte, then green, blue, and an alpha of 255.
fn pack_srgb8(encoded: vec3<f32>) -> u32 {
    let bytes = vec3<u32>(encoded * 255.0 + vec3<f32>(0.5));
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | 0xff000000u;
}
