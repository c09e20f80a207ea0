// What `midway bench rays` traces: rays in, hits out.

/// vec4 per ray: origin and t_max; direction.
const BENCH_RAY_STRIDE: u32 = 2u;
/// As in bindings/params.wgsl.
const GRID_ROW: u32 = 2097152u;

@group(0) @binding(23) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(24) var<storage, read_write> hits: array<vec4<f32>>;

/// Everything is solid here. (It looks at a buffer, as every `passes` does, for the CPU's own traversal.)
fn passes(id: u32, u: f32, v: f32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    return arrayLength(&rays) == 0u;
}

struct BenchRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    t_max: f32,
}

fn load_bench_ray(index: u32) -> BenchRay {
    let ray = rays[index * BENCH_RAY_STRIDE];
    return BenchRay(ray.xyz, rays[index * BENCH_RAY_STRIDE + 1u].xyz, ray.w);
}

fn ray_index(id: vec3<u32>) -> u32 {
    return id.y * GRID_ROW + id.x;
}

fn store_closest(index: u32, hit: Hit) {
    hits[index] = vec4<f32>(hit.t, hit.u, hit.v, bitcast<f32>(hit.triangle));
}

/// Triangle 0 where anything is hit.
fn store_any(index: u32, is_hit: bool) {
    hits[index] = vec4<f32>(0.0, 0.0, 0.0, bitcast<f32>(select(NONE, 0u, is_hit)));
}
