const T = array<f32, 4>(1.0, 2.0, 3.0, 4.0);
const PI: f32 = 3.0;
struct S { a: vec3<f32>, b: u32, c: array<vec2<f32>, 3> }
struct Head { n: atomic<u32>, items: array<S> }
@group(0) @binding(0) var<storage, read_write> head: Head;
var<private> seed: u32 = 3u;
fn h(p: ptr<function, vec3<f32>>, q: ptr<private, u32>) -> f32 { (*p).x = 2.0; *q += 1u; return (*p).y; }
fn pick(i: u32, s: S) -> f32 { var k = array<f32,3>(1.,2.,3.); let a = k; return T[i] * PI * s.c[i].x + a[i]; }
fn lg(a: bool, b: bool, x: f32) -> u32 {
  if (a && b || x > 2.0) { return 1u; }
  var s = 0u;
  for (var i = 0u; i < 10u; i++) { var z: array<u32, 4>; if (i == 3u) { continue; } z[i] = s; s += i; switch i { case 1, 2: { s += 2u; } case default { break; } case 7u: { s = 1u; if a { break; } s+= 4u; } } }
  loop { let q = s * 2u; s += 1u; continuing { s += q; break if s > 10u; } }
  return s;
}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  var s: S; var w: vec3<f32>; 
  _ = h(&w, &seed); _ = h(&s.a, &seed);
  let r = atomicCompareExchangeWeak(&head.n, 1u, 2u);
  if r.exchanged { s.b = r.old_value; }
  head.items[id.x] = s; head.items[id.x].c[1].y = mix(1.0, 2.0, s.a.x);
  let m = mix(w, vec3(1.0), 0.5); w.y += m[id.x]; let l = arrayLength(&head.items);
  let fr = frexp(w.x); let md = modf(w); let cl = clamp(w, vec3(0.), vec3(1.)); w = w * 2.0 + 1.0;
  let sel = select(w, m, w < m); let mm = mat3x3<f32>(w, m, cl) * w; let sh = vec2<u32>(1u,2u) << vec2(3u);
}
