// Probe: surfaces. In: a triangle's id as bits, two barycentrics, and 1 for the attributes.

#include "bindings/params.wgsl"
#include "bindings/scene.wgsl"
#include "bindings/probe.wgsl"

@compute @workgroup_size(64)
fn probe_surface(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= probe_count()) {
        return;
    }
    let point = probe_input(id.x, 0u);
    let surface = load_surface(bitcast<u32>(point.x), point.y, point.z);
    if (point.w == 1.0) {
        probe_output(id.x, 0u, surface.color);
        probe_output(id.x, 1u, vec4<f32>(surface.uv0, surface.uv1));
        return;
    }
    probe_output(id.x, 0u, vec4<f32>(surface.position, bitcast<f32>(surface.material)));
    probe_output(id.x, 1u, vec4<f32>(surface.ng, surface.bitangent_sign));
    probe_output(id.x, 2u, vec4<f32>(surface.ns, bitcast<f32>(surface.light)));
    probe_output(id.x, 3u, vec4<f32>(surface.tangent, 0.0));
}
