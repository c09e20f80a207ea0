// Probe: bindings/slots.wgsl, a material's textures at points. In: two sets of coordinates; a material's index.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/slots.wgsl"
#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_texture(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let uv = probe_input(id.x, 0u);
    let index = u32(probe_input(id.x, 1u).x);
    probe_output(id.x, 0u, slot_rgba(index, SLOT_COLOR, uv.xy, uv.zw));
    probe_output(id.x, 1u, vec4<f32>(slot_value(index, SLOT_OPACITY, uv.xy, uv.zw), load_slot_numbers(index).xyz));
}
