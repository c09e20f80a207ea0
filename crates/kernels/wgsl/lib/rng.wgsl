// Counter-based random numbers: a hash of (pixel or path, sample, dimension, seed), so that the
// same sample draws the same numbers wherever and in whatever order it runs.
// pcg4d: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020.

// What a draw is for; with the vertex's depth it makes the dimension.
const DRAW_FILM: u32 = 0u;
const DRAW_SCATTER: u32 = 1u;
const DRAW_NEE: u32 = 2u;
const DRAW_EMIT_POINT: u32 = 3u;
const DRAW_EMIT_DIRECTION: u32 = 4u;
const DRAW_CHANNEL: u32 = 5u;
const DRAW_ENVIRONMENT: u32 = 0x10u;
const DRAW_RESERVOIR: u32 = 0x4000u;
const DRAW_JOIN: u32 = 0x8000u;
/// Added for draws of light paths.
const DRAW_LIGHT: u32 = 0x2000u;

fn pcg4d(key: vec4<u32>) -> vec4<u32> {
    var v = key * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4<u32>(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

/// A 32-bit mixer of low bias (Wellons' lowbias32, as improved by degski and TheIronBorn).
fn mix32(key: u32) -> u32 {
    var x = key;
    x ^= x >> 16u;
    x *= 0x21f0aaadu;
    x ^= x >> 15u;
    x *= 0xd35a2d97u;
    x ^= x >> 15u;
    return x;
}

/// The bits of a draw. The dimension is mixed first: pcg4d alone maps keys that differ in a high bit
/// only to correlated numbers (scatter draws of the two subpaths of a sample, by 45 standard errors).
fn draw_bits(path: u32, sample: u32, dim: u32, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(path, sample, mix32(dim), seed));
}

/// How many values a unit float can have: multiples of 1 / UNIT_STEPS, exact in a float.
const UNIT_STEPS: f32 = 16777216.0;

/// Uniform in [0, 1): 24 bits, so never 1.
fn unit_float(bits: vec4<u32>) -> vec4<f32> {
    return vec4<f32>(bits >> vec4<u32>(8u)) * (1.0 / UNIT_STEPS);
}

/// The dimension of a draw at a vertex.
fn dimension(purpose: u32, depth: u32) -> u32 {
    return (purpose << 16u) | (depth & 0xffffu);
}

/// Where in a table of pre-generated numbers (opt-in bias) a draw is found.
fn table_index(index: u32, sample: u32, dim: u32, seed: u32, n_entries: u32) -> u32 {
    let place = index * 0x9e3779b1u + sample * 0x85ebca77u + dim * 0xc2b2ae3du + seed * 0x27d4eb2fu;
    return (place ^ (place >> 15u)) % n_entries; // n_entries > 0: the table is in use
}

/// A uniform integer in [0, n) from u in [0, 1); n > 0.
fn uniform_index(u: f32, n: u32) -> u32 {
    return min(u32(u * f32(n)), n - 1u);
}

/// As uniform_index, from 32 random bits, for n too large for a float's 24.
fn uniform_index_bits(bits: u32, n: u32) -> u32 {
    // The high word of bits * n, by halves.
    let low_high = (bits & 0xffffu) * (n >> 16u) + (((bits & 0xffffu) * (n & 0xffffu)) >> 16u);
    let high = (bits >> 16u) * (n & 0xffffu);
    let mid = (low_high & 0xffffu) + (high & 0xffffu);
    return (bits >> 16u) * (n >> 16u) + (low_high >> 16u) + (high >> 16u) + (mid >> 16u);
}
