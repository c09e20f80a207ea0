// Probe: what lib/light.wgsl and lib/environment.wgsl have for lights without surfaces, and the maths
// they need. In: numbers in [0, 1), an axis, a direction, any numbers.

#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_light(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let u = fract(abs(probe_input(id.x, 0u)));
    let axis = probe_unit(probe_input(id.x, 1u).xyz);
    let direction = probe_unit(probe_input(id.x, 2u).xyz);
    let any = probe_input(id.x, 3u);
    let cone = Cone(axis, id.x % 4u, 0.2, 1.7);
    probe_output(id.x, 0u, vec4<f32>(sample_cone(axis, 2.0 * u.z, u.xy), cone_falloff(cone, direction)));
    probe_output(id.x, 1u, vec4<f32>(unit_circle(any.x), angle_of(any.y, any.z), sample_linear(u.x, u.y, u.z)));
    let size = vec2<u32>(1u + id.x % 9u, 1u + id.x % 7u);
    let cell = vec2<u32>(uniform_index(u.x, size.x), uniform_index(u.y, size.y + 1u));
    let drawn = environment_direction(cell, size, abs(any), u.zw);
    probe_output(id.x, 2u, vec4<f32>(drawn, environment_density_ratio(drawn, cell.y, size.y)));
    let place = environment_place(direction, size);
    probe_output(id.x, 3u, vec4<f32>(vec2<f32>(place.cell), place.within));
}
