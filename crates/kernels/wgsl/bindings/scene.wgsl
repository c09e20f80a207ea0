// The packed scene: tables of albedos and materials (bindings/material.wgsl), then lights, the tree over
// them, the environment, triangles' surfaces with their attributes, instances, pre-generated numbers, and
// what textures are looked up by, all as vec4 in one buffer (a stage has 8).

#include "bindings/surfaces.wgsl"

@group(0) @binding(1) var<storage, read> scene: array<vec4<f32>>;

fn frame_of(surface: Surface) -> Frame {
    return Frame(surface.ng, surface.ns, surface.tangent, surface.bitangent_sign, surface.coat_ns);
}

/// 32 random bits four times for a draw of a path: by Sobol, by hash, or from the table, whose numbers
/// have 24.
fn random_bits(path: u32, sample: u32, dim: u32) -> vec4<u32> {
    if (may_have(FEATURE_RANDOM_TABLE) && params.n_random != 0u) {
        let entry = scene[params.random_at + table_index(path, sample, dim, params.seed, params.n_random)];
        return vec4<u32>(entry * 16777216.0) << vec4<u32>(8u);
    }
    if (has_flag(FLAG_SOBOL)) {
        return sobol_bits(path, sample, dim, params.seed);
    }
    return draw_bits(path, sample, dim, params.seed);
}

/// Four uniform numbers in [0, 1) for a draw of a path.
fn random(path: u32, sample: u32, dim: u32) -> vec4<f32> {
    return unit_float(random_bits(path, sample, dim));
}
