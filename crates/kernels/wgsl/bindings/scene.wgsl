// The packed scene: tables of albedos and materials (bindings/material.wgsl), then lights, triangles'
// surfaces with their attributes, instances, pre-generated numbers, and what textures are looked up by,
// all as vec4 in one buffer (a stage has 8).

#include "bindings/surfaces.wgsl"

/// vec4 per entry.
const LIGHT_STRIDE: u32 = 2u;

@group(0) @binding(1) var<storage, read> scene: array<vec4<f32>>;

/// One emissive triangle.
struct Light {
    triangle: u32,
    /// Chance of being chosen.
    pmf: f32,
    /// Alias table.
    threshold: f32,
    alias_entry: u32,
    area: f32,
    /// The medium (material) around it, or NONE.
    medium: u32,
}

fn load_light(index: u32) -> Light {
    let at = params.lights_at + index * LIGHT_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    return Light(bitcast<u32>(a.x), a.y, a.z, bitcast<u32>(a.w), b.x, bitcast<u32>(b.y));
}

fn frame_of(surface: Surface) -> Frame {
    return Frame(surface.ng, surface.ns, surface.tangent, surface.bitangent_sign);
}

/// 32 random bits four times for a draw of a path: by hash, or from the table, whose numbers have 24.
fn random_bits(path: u32, sample: u32, dim: u32) -> vec4<u32> {
    if (params.n_random != 0u) {
        let entry = scene[params.random_at + table_index(path, sample, dim, params.seed, params.n_random)];
        return vec4<u32>(entry * 16777216.0) << vec4<u32>(8u);
    }
    return draw_bits(path, sample, dim, params.seed);
}

/// Four uniform numbers in [0, 1) for a draw of a path.
fn random(path: u32, sample: u32, dim: u32) -> vec4<f32> {
    return unit_float(random_bits(path, sample, dim));
}

/// A light for u in [0, 1); n_lights > 0.
fn pick_light(u: f32) -> u32 {
    let scaled = u * f32(params.n_lights);
    let cell = min(u32(scaled), params.n_lights - 1u);
    let light = load_light(cell);
    return alias_pick(cell, scaled - f32(cell), light.threshold, light.alias_entry);
}
