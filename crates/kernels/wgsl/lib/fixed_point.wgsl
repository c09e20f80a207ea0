// Film sums are integers, so that they do not depend on the order of addition: two words per
// channel, the low one in units of 2^-32, the high one in whole units with carry.

/// The largest value one addition may have.
const FIXED_MAX: f32 = 4294967040.0;

/// A finite value in [0, FIXED_MAX] as (low, high) words; exact for values of 2^-8 and more.
fn to_fixed(value: f32) -> vec2<u32> {
    let whole = u32(value); // truncates; its float is exact, as a value over 2^24 has no fraction
    return vec2<u32>(u32((value - f32(whole)) * 4294967296.0), whole);
}

/// The value of two words, to float rounding.
fn from_fixed(low: u32, high: u32) -> f32 {
    return f32(high) + f32(low) * (1.0 / 4294967296.0);
}
