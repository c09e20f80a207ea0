// Closest hit of each ray with the triangles of a BVH2: "while-while" (Aila and Laine 2009).
// One invocation is one ray.
//
// A node is four vec4s: the left child's bounds, the right child's bounds, and
// (left, right, -, -) as bits, where a child is an inner node's index or, with the top bit set,
// a leaf of one triangle.

struct Params { n_rays: u32 }

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> nodes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> hits: array<vec4<f32>>;

const LEAF = 0x80000000u;
const NONE = 0xffffffffu;
const MAX_DEPTH = 64u;

struct Hit { t: f32, u: f32, v: f32, triangle: u32 }

fn enter(low: vec3<f32>, high: vec3<f32>, origin: vec3<f32>, inverse: vec3<f32>, t_max: f32) -> f32 {
    let a = (low - origin) * inverse;
    let b = (high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let t_near = max(max(near.x, near.y), max(near.z, 0.0));
    let t_far = min(min(far.x, far.y), min(far.z, t_max));
    return select(1e30, t_near, t_near <= t_far);
}

fn intersect(triangle: u32, origin: vec3<f32>, direction: vec3<f32>, hit: ptr<function, Hit>) {
    let v0 = triangles[3u * triangle].xyz;
    let e1 = triangles[3u * triangle + 1u].xyz;
    let e2 = triangles[3u * triangle + 2u].xyz;
    let p = cross(direction, e2);
    let det = dot(e1, p);
    if det == 0.0 { return; }
    let inverse = 1.0 / det;
    let s = origin - v0;
    let u = dot(s, p) * inverse;
    let q = cross(s, e1);
    let v = dot(direction, q) * inverse;
    let t = dot(e2, q) * inverse;
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < (*hit).t {
        *hit = Hit(t, u, v, triangle);
    }
}

fn closest(origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit = Hit(1e30, 0.0, 0.0, NONE);
    let inverse = 1.0 / direction;
    var stack: array<u32, MAX_DEPTH>;
    var depth = 0u;
    var at = 0u;
    loop {
        while (at & LEAF) == 0u {
            let n0 = nodes[4u * at];
            let n1 = nodes[4u * at + 1u];
            let n2 = nodes[4u * at + 2u];
            let n3 = nodes[4u * at + 3u];
            let t_left = enter(n0.xyz, vec3(n0.w, n1.xy), origin, inverse, hit.t);
            let t_right = enter(vec3(n1.zw, n2.x), n2.yzw, origin, inverse, hit.t);
            let left = bitcast<u32>(n3.x);
            let right = bitcast<u32>(n3.y);
            let is_left_first = t_left <= t_right;
            if max(t_left, t_right) < 1e30 {
                stack[depth] = select(left, right, is_left_first);
                depth += 1u;
            }
            if min(t_left, t_right) < 1e30 {
                at = select(right, left, is_left_first);
            } else if depth == 0u {
                return hit;
            } else {
                depth -= 1u;
                at = stack[depth];
            }
        }
        intersect(at & ~LEAF, origin, direction, &hit);
        if depth == 0u { break; }
        depth -= 1u;
        at = stack[depth];
    }
    return hit;
}

@compute @workgroup_size(64)
fn traverse(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.n_rays { return; }
    let hit = closest(rays[2u * id.x].xyz, rays[2u * id.x + 1u].xyz);
    hits[id.x] = vec4(hit.t, hit.u, hit.v, bitcast<f32>(hit.triangle));
}
