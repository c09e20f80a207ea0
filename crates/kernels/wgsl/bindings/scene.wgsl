// The packed scene: materials, lights, triangles' surfaces with their attributes, instances, pre-generated
// numbers, and what textures are looked up by, all as vec4 in one buffer (a stage has 8).

#include "bindings/surfaces.wgsl"

/// vec4 per entry.
const MATERIAL_STRIDE: u32 = 3u;
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

fn load_material(index: u32) -> Material {
    let at = index * MATERIAL_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    let c = scene[at + 2u];
    return Material(a.xyz, bitcast<u32>(a.w), b.xyz, b.w, c.xyz, bitcast<u32>(c.w));
}

fn load_light(index: u32) -> Light {
    let at = params.lights_at + index * LIGHT_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    return Light(bitcast<u32>(a.x), a.y, a.z, bitcast<u32>(a.w), b.x, bitcast<u32>(b.y));
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

/// What a medium lets through over a distance.
fn medium_transmittance(medium: u32, distance: f32) -> vec3<f32> {
    if (medium == NONE) {
        return vec3<f32>(1.0);
    }
    let sigma = load_material(medium).sigma_a;
    return vec3<f32>(exp_negative(-sigma.x * distance), exp_negative(-sigma.y * distance), exp_negative(-sigma.z * distance));
}
