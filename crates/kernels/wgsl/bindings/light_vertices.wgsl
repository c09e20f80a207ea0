// Vertices of light subpaths: 64 bytes each.

/// vec4 per vertex.
const VERTEX_STRIDE: u32 = 4u;

@group(0) @binding(9) var<storage, read_write> light_vertices: array<vec4<f32>>;
/// Per light path: n connectible vertices and the last one's slot (or, in k-step, the sum of
/// their importances, as bits); then, for a pool, block sums, the
/// number of vertices, and the table of their slots by (path, depth).
@group(0) @binding(10) var<storage, read_write> light_paths: array<u32>;

struct LightVertex {
    position: vec3<f32>,
    /// At y_0 of a light that is no triangle NONE.
    triangle: u32,
    /// Of the subpath up to and including arrival here; at y_0 the radiance over the position's
    /// density, its direction not chosen.
    throughput: vec3<f32>,
    dvcm: f32,
    /// Towards the vertex before; at y_0 LightPoint.normal.
    wo: vec3<f32>,
    dvc: f32,
    u: f32,
    v: f32,
    /// The slot of the vertex before (full, pool), or the chance of having ended there as bits
    /// (single-step); at y_0 the light's index.
    link: u32,
    /// Its number s, 1 on the light, at most 2^15 + 1; and the group of its path's light: 16 bits each.
    s: u32,
    group: u32,
}

fn load_light_vertex(slot: u32) -> LightVertex {
    let at = slot * VERTEX_STRIDE;
    let a = light_vertices[at];
    let b = light_vertices[at + 1u];
    let c = light_vertices[at + 2u];
    let d = light_vertices[at + 3u];
    let counts = bitcast<u32>(d.w);
    return LightVertex(a.xyz, bitcast<u32>(a.w), b.xyz, b.w, c.xyz, c.w, d.x, d.y, bitcast<u32>(d.z), counts & 0xffffu,
        counts >> 16u);
}

fn store_light_vertex(slot: u32, vertex: LightVertex) {
    let at = slot * VERTEX_STRIDE;
    light_vertices[at] = vec4<f32>(vertex.position, bitcast<f32>(vertex.triangle));
    light_vertices[at + 1u] = vec4<f32>(vertex.throughput, vertex.dvcm);
    light_vertices[at + 2u] = vec4<f32>(vertex.wo, vertex.dvc);
    light_vertices[at + 3u] = vec4<f32>(vertex.u, vertex.v, bitcast<f32>(vertex.link),
        bitcast<f32>(vertex.s | (vertex.group << 16u)));
}

/// The recursive quantities at a stored vertex.
fn light_vertex_mis(vertex: LightVertex) -> MisState {
    let ending = select(1.0, bitcast<f32>(vertex.link), params.join == JOIN_SINGLE_STEP);
    return MisState(vertex.dvcm, vertex.dvc, ending);
}

/// What chooses a vertex of a light path in importance-chosen joins; positive where it can light
/// anything.
fn vertex_importance(vertex: LightVertex) -> f32 {
    return max3(vertex.throughput);
}

// Per-path words of light_paths.
fn path_vertex_count(path: u32) -> u32 {
    return light_paths[path * 2u];
}

fn path_second_word(path: u32) -> u32 {
    return light_paths[path * 2u + 1u];
}

// Places in light_paths of a pool's parts.
const SCAN_BLOCK: u32 = 64u;

fn n_scan_blocks() -> u32 {
    return (params.n_light_paths + SCAN_BLOCK - 1u) / SCAN_BLOCK;
}

fn block_sums_at() -> u32 {
    return 2u * params.n_light_paths;
}

/// Vertices in the pool.
fn pool_size_at() -> u32 {
    return 2u * params.n_light_paths + n_scan_blocks();
}

fn pool_table_at() -> u32 {
    return pool_size_at() + 1u;
}
