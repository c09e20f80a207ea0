// Probe: the lights of a packed scene by the tree over them: one drawn for a place, and how another
// shines there. In: a place and a light's index; two numbers in [0, 1) for the draw, two for a point on
// that light; a direction for it at infinity; the side that is lit, or 0.

#include "bindings/probe.wgsl"
#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/shaded.wgsl"
#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/light_tree.wgsl"

@compute @workgroup_size(64)
fn probe_light_tree(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let a = probe_input(id.x, 0u);
    let u = probe_input(id.x, 1u);
    let place = LightPlace(a.xyz, probe_input(id.x, 3u).xyz);
    let drawn = draw_light(place, u.xy);
    var again = vec2<f32>(0.0);
    if (drawn.index != NONE) {
        let light = load_light(drawn.index);
        again = vec2<f32>(light_chance_ratio(drawn.index, light, place), light.pmf);
    }
    probe_output(id.x, 0u, vec4<f32>(select(f32(drawn.index), -1.0, drawn.index == NONE), drawn.ratio, again));
    let index = u32(a.w);
    let light = load_light(index);
    let ratio = light_chance_ratio(index, light, place);
    let point = light_point(light, sample_triangle(u.zw), probe_unit(probe_input(id.x, 2u).xyz));
    probe_output(id.x, 2u, vec4<f32>(oct_decode(oct_encode(probe_unit(probe_input(id.x, 2u).xyz))), 0.0));
    let seen = see_light(light, point, a.xyz, ratio);
    let cosine = select(1.0, max(dot(place.facing, seen.wi), 0.0), any(place.facing != vec3<f32>(0.0)));
    let arriving = cosine * max(seen.arriving.x, max(seen.arriving.y, seen.arriving.z));
    probe_output(id.x, 1u, vec4<f32>(ratio, light.pmf, arriving, select(0.0, seen.pdf / seen.pdf_position, ratio > 0.0)));
}
