struct Params { count: u32, scale: vec3<f32>, weights: array<vec4<f32>, 2> }
struct Item { position: vec3<f32>, kind: u32, samples: array<f32, 5> }
struct Queue { length: atomic<u32>, peak: atomic<i32>, items: array<Item> }

@group(0) @binding(3) var<storage, read_write> queue: Queue;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(2) var<storage, read> not_used: array<u32>;
@group(0) @binding(4) var texels: texture_2d_array<u32>;
var<private> state: u32 = 1u;

fn not_called() -> u32 { return not_used[0]; }

fn texel(at: u32) -> vec4<u32> {
    return textureLoad(texels, vec2<u32>(at & 4095u, at >> 12u), 0, 0);
}

fn random() -> u32 {
    state = state * 747796405u + 2891336453u;
    return state;
}

fn push(item: Item) {
    let at = atomicAdd(&queue.length, 1u);
    if at < arrayLength(&queue.items) { queue.items[at] = item; }
    atomicMax(&queue.peak, i32(at));
}

@compute @workgroup_size(64)
fn kernel(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if id.x >= params.count { return; }
    state ^= id.x;
    var item: Item;
    item.position = params.scale * points[id.x].xyz + params.weights[lane % 2u].xyz;
    item.samples[random() % 5u] = points[2u * id.x + 1u].w;
    queue.items[id.x].position.y = item.samples[2];
    item.kind = texel(id.x).w;
    push(item);
}
