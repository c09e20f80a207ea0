// Functions that are written by hand: with buffers and without.

struct Found {
    at: f32,
    which: u32,
}

@group(0) @binding(0) var<storage, read> tree: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4<f32>>;

fn weight(x: f32) -> f32 {
    return 2.0 * x;
}

fn search(origin: vec3<f32>, reach: f32) -> Found {
    return Found(reach, tree[u32(origin.x)].x);
}

@compute @workgroup_size(64)
fn native(@builtin(global_invocation_id) id: vec3<u32>) {
    let result = search(vec3<f32>(f32(id.x)), weight(3.0));
    found[id.x] = vec4<f32>(result.at, f32(result.which), 0.0, 0.0);
}
