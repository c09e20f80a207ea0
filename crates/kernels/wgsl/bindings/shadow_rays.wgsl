// Contributions that wait for a visibility test.

/// vec4 per ray.
const SHADOW_STRIDE: u32 = 3u;
/// Joins of one camera vertex in one bounce at most, a power of two up to 8; a vertex with more waits for the
/// next.
const CONNECTIONS_PER_BOUNCE: u32 = 8u;

@group(0) @binding(7) var<storage, read_write> shadow_rays: array<vec4<f32>>;

/// A contribution to a pixel (by its number in the full film) from a light of a group that counts if nothing lies
/// between two points, which are already offset from their surfaces. Capacity is reserved: for the joins that can
/// be listed in a bounce, and one a path.
fn push_shadow_ray(pixel: u32, group: u32, start: vec3<f32>, end: vec3<f32>, contribution: vec3<f32>) {
    let at = atomicAdd(&counters[COUNT_SHADOW], 1u) * SHADOW_STRIDE;
    shadow_rays[at] = vec4<f32>(start, bitcast<f32>(pixel));
    shadow_rays[at + 1u] = vec4<f32>(end - start, bitcast<f32>(group));
    shadow_rays[at + 2u] = vec4<f32>(contribution, 0.0);
}
