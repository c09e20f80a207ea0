// The state of the subpaths under way, one slot each; camera and light subpaths use the same slots
// in turn.

/// vec4 per path.
const PATH_STRIDE: u32 = 5u;

/// Bits of the word of counts: 15 for the depth, one for parallel, 16 for the joins made.
const DEPTH_MASK: u32 = 0x7fffu;
const PARALLEL_BIT: u32 = 0x8000u;

/// Path.facing where lights shine on both sides, or no light was drawn. No vector is packed so.
const NO_FACING: u32 = 0x80008000u;

@group(0) @binding(4) var<storage, read_write> paths: array<vec4<f32>>;

struct Path {
    origin: vec3<f32>,
    /// Pixel in the full film, or the light path's index.
    index: u32,
    direction: vec3<f32>,
    /// Surface vertices so far.
    depth: u32,
    /// Joins of the vertex just hit that are already listed, where it has more than connections_per_bounce(); 0
    /// otherwise.
    joined: u32,
    /// The first segment of a subpath that starts with parallel rays, at an infinite light or a camera:
    /// the density of its end has no inverse square in it.
    parallel: bool,
    throughput: vec3<f32>,
    sample: u32,
    mis: MisState,
    /// The medium (material) the ray is in, or NONE.
    medium: u32,
    /// The side of the vertex that it left which lights were drawn for there (oct_encode), or NO_FACING.
    facing: u32,
}

/// Whether paths keep that side, in the place of MisState.ending, which is 1 where not single-step. There
/// lights are drawn for both sides.
fn keeps_facing() -> bool {
    return uses_light_tree() && params.join != JOIN_SINGLE_STEP;
}

fn load_path(id: u32) -> Path {
    let at = id * PATH_STRIDE;
    let a = paths[at];
    let b = paths[at + 1u];
    let c = paths[at + 2u];
    let d = paths[at + 3u];
    let counts = bitcast<u32>(b.w);
    return Path(a.xyz, bitcast<u32>(a.w), b.xyz, counts & DEPTH_MASK, counts >> 16u, (counts & PARALLEL_BIT) != 0u, c.xyz,
        bitcast<u32>(c.w), MisState(d.x, d.y, select(d.z, 1.0, keeps_facing())), bitcast<u32>(d.w),
        select(NO_FACING, bitcast<u32>(d.z), keeps_facing()));
}

fn store_path(id: u32, path: Path) {
    let at = id * PATH_STRIDE;
    let counts = path.depth | select(0u, PARALLEL_BIT, path.parallel) | (path.joined << 16u);
    paths[at] = vec4<f32>(path.origin, bitcast<f32>(path.index));
    paths[at + 1u] = vec4<f32>(path.direction, bitcast<f32>(counts));
    paths[at + 2u] = vec4<f32>(path.throughput, bitcast<f32>(path.sample));
    paths[at + 3u] = vec4<f32>(path.mis.dvcm, path.mis.dvc, select(path.mis.ending, bitcast<f32>(path.facing), keeps_facing()),
        bitcast<f32>(path.medium));
}

/// A path that goes no further: without throughput.
fn ended(path: Path) -> Path {
    var end = path;
    end.throughput = vec3<f32>(0.0);
    return end;
}

/// The place in the batch of a path that is a pixel sample's.
fn batch_place(path: Path) -> u32 {
    return (path.sample - params.first_sample) * params.n_pixels + window_pixel(path.index) - params.first_path;
}

fn load_hit(id: u32) -> Hit {
    let h = paths[id * PATH_STRIDE + 4u];
    return Hit(h.x, h.y, h.z, bitcast<u32>(h.w));
}

fn store_hit(id: u32, hit: Hit) {
    paths[id * PATH_STRIDE + 4u] = vec4<f32>(hit.t, hit.u, hit.v, bitcast<f32>(hit.triangle));
}
