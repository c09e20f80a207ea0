// Contributions that wait for a visibility test.

/// vec4 per ray.
const SHADOW_STRIDE: u32 = 3u;
/// Joins of one camera vertex in one bounce at most, a power of two; a vertex with more waits for the next. Each
/// path has room for as many: the fewer, the more paths a GPU has in flight.
const CONNECTIONS_PER_BOUNCE: u32 = 4u;
/// The same where joins are made one after another (FEATURE_JOIN_RUNS): there it costs more to wait than to hold.
const CONNECTIONS_OF_RUNS: u32 = 8u;

fn connections_per_bounce() -> u32 {
    return select(CONNECTIONS_PER_BOUNCE, CONNECTIONS_OF_RUNS, may_have(FEATURE_JOIN_RUNS));
}

@group(0) @binding(7) var<storage, read_write> shadow_rays: array<vec4<f32>>;

/// A contribution to a pixel (by its number in the full film) from a light of a group that counts if nothing lies between two points, which are already
/// offset from their surfaces. Capacity is reserved: connections_per_bounce() + 1 a path and bounce.
fn push_shadow_ray(pixel: u32, group: u32, start: vec3<f32>, end: vec3<f32>, contribution: vec3<f32>) {
    let at = atomicAdd(&counters[COUNT_SHADOW], 1u) * SHADOW_STRIDE;
    shadow_rays[at] = vec4<f32>(start, bitcast<f32>(pixel));
    shadow_rays[at + 1u] = vec4<f32>(end - start, bitcast<f32>(group));
    shadow_rays[at + 2u] = vec4<f32>(contribution, 0.0);
}
