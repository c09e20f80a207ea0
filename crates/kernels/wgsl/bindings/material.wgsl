// Materials' records in `scene`, behind the tables of albedos (lib/albedo.wgsl) that it starts with.

/// vec4 of a record: colour, kind; emission, index of refraction; absorption, flags; specular colour,
/// specular; roughness along and across, metallic, transmission; η or sheen's colour and roughness;
/// k or coat, its roughness, anisotropy, and the sine of its rotation, which is within a quarter turn;
/// how far blue's index is above green's, the scale of the coat's normal map.
const MATERIAL_STRIDE: u32 = 8u;
/// Where records start, in vec4.
const MATERIALS_AT: u32 = ALBEDO_SIZE;

fn material_at(index: u32) -> u32 {
    return MATERIALS_AT + index * MATERIAL_STRIDE;
}

/// A record as the scene has it.
fn load_raw_material(index: u32) -> RawMaterial {
    let at = material_at(index);
    let a = scene[at];
    let b = scene[at + 1u];
    let flags = bitcast<u32>(scene[at + 2u].w);
    let kind = bitcast<u32>(a.w);
    if (!may_have(FEATURE_INTERFACES) || kind == SURFACE_DIFFUSE) {
        return RawMaterial(kind, flags, a.xyz, b.xyz, b.w, vec3<f32>(0.0), 0.0, vec2<f32>(0.0), 0.0, 0.0, vec4<f32>(0.0),
            vec3<f32>(0.0), vec2<f32>(1.0, 0.0));
    }
    let d = scene[at + 3u];
    let e = scene[at + 4u];
    var f = vec4<f32>(0.0);
    var g = vec4<f32>(0.0);
    if (may_have(FEATURE_LAYERS | FEATURE_ANISOTROPY | FEATURE_CONDUCTOR)) {
        f = scene[at + 5u];
        g = scene[at + 6u];
    }
    let rotation = vec2<f32>(sqrt(max(1.0 - g.w * g.w, 0.0)), g.w);
    return RawMaterial(kind, flags, a.xyz, b.xyz, b.w, d.xyz, d.w, e.xy, e.z, e.w, f, g.xyz, rotation);
}

/// A record as light of one colour meets it, which the subpath's throughput says.
fn in_one_channel(plain: RawMaterial, index: u32, throughput: vec3<f32>) -> RawMaterial {
    var raw = plain;
    if (disperses(plain.flags)) {
        raw.ior = channel_ior(plain.ior, scene[material_at(index) + 7u].x, channel_of(throughput));
    }
    return raw;
}

/// A record's flags: none of those that finish_material derives.
fn material_flags(index: u32) -> u32 {
    return bitcast<u32>(scene[material_at(index) + 2u].w);
}

/// Whether any of what it transmits has a density.
fn transmits_density(index: u32) -> bool {
    return (material_flags(index) & MATERIAL_TRANSMITS) != 0u;
}

/// The curves that `finish_material` asks for.
fn load_albedos(raw: RawMaterial) -> Albedos {
    var albedos = no_albedos();
    if (!needs_albedos(raw)) {
        return albedos;
    }
    if (may_have(FEATURE_LAYERS) && raw.kind == SURFACE_METALLIC_ROUGHNESS && max3(raw.eta_or_sheen.xyz) > 0.0) {
        albedos.sheen = load_alpha_curve(CURVE_SHEEN, sheen_alpha(raw));
    }
    if (may_have(FEATURE_LAYERS) && raw.kind == SURFACE_METALLIC_ROUGHNESS && raw.k_or_coat.x > 0.0 && coat_alpha(raw) > 0.0) {
        let coat = coat_alpha(raw);
        albedos.coat = schlick_albedo(COAT_F0, load_alpha_curve(CURVE_LOSS, coat), load_alpha_curve(CURVE_GRAZING, coat));
    }
    let both = interface_alpha(raw);
    if (!may_have(FEATURE_ROUGHNESS) || both.x == 0.0) {
        return albedos;
    }
    if (holds_back(raw)) {
        albedos.held = load_held_back(both, held_at_nodes(raw, albedos));
    }
    if (has_solid_losses(both, raw.flags)) {
        return add_solid(albedos, both, raw.ior);
    }
    if (has_stretched_curves(both, raw.flags)) {
        return add_stretched(albedos, both);
    }
    let alpha = 0.5 * (both.x + both.y); // of two only where single bounces are wanted
    if (needs_dielectric_losses(raw)) {
        albedos.a = load_index_curve(select(CURVE_DENSE_LOSS, CURVE_RARE_LOSS, raw.ior > 1.0), alpha, raw.ior);
        albedos.b = load_index_curve(select(CURVE_RARE_LOSS, CURVE_DENSE_LOSS, raw.ior > 1.0), alpha, raw.ior);
        return albedos;
    }
    albedos.a = load_alpha_curve(CURVE_LOSS, alpha);
    if (is_kind(raw.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
        albedos.b = load_index_curve(CURVE_RARE_REFLECTED, alpha, raw.ior);
        if (is_single_bounce(raw.flags)) {
            albedos.a = load_index_curve(CURVE_RARE_LOSS, alpha, raw.ior);
            albedos.across = load_index_curve(CURVE_DENSE_LOSS, alpha, raw.ior);
        }
    } else {
        albedos.b = load_alpha_curve(CURVE_GRAZING, alpha);
    }
    return albedos;
}

fn load_curve(at: u32) -> Curve {
    return Curve(scene[at], scene[at + 1u]);
}

/// A curve of the first table, between its entries.
fn load_alpha_curve(curve: u32, alpha: f32) -> Curve {
    let place = alpha_place(alpha);
    let entry = min(u32(place), ALBEDO_ALPHAS - 2u);
    let at = (entry * N_ALPHA_CURVES + curve) * 2u;
    return blend_curves(load_curve(at), load_curve(at + N_ALPHA_CURVES * 2u), place - f32(entry));
}

/// A curve of the second.
fn load_index_curve(curve: u32, alpha: f32, ior: f32) -> Curve {
    let place = index_place(ior);
    let entry = min(u32(place), ALBEDO_INDICES - 2u);
    let row = ALBEDO_ALPHAS * N_INDEX_CURVES * 2u;
    let at = INDEX_CURVES_AT + entry * row;
    return blend_curves(load_index_row(at, curve, alpha), load_index_row(at + row, curve, alpha), place - f32(entry));
}

fn load_index_row(row_at: u32, curve: u32, alpha: f32) -> Curve {
    let place = alpha_place(alpha);
    let entry = min(u32(place), ALBEDO_ALPHAS - 2u);
    let at = row_at + (entry * N_INDEX_CURVES + curve) * 2u;
    return blend_curves(load_curve(at), load_curve(at + N_INDEX_CURVES * 2u), place - f32(entry));
}

/// The third table between its entries, added to what is 0 there.
fn add_stretched(plain: Albedos, alpha: vec2<f32>) -> Albedos {
    var albedos = plain;
    let place = stretched_place(alpha);
    let first = min(vec2<u32>(place), vec2<u32>(ALBEDO_ALPHAS - 2u, ALBEDO_RATIOS - 2u));
    let t = place - vec2<f32>(first);
    for (var corner = 0u; corner < 4u; corner += 1u) {
        let right = corner & 1u;
        let up = corner >> 1u;
        let weight = select(1.0 - t.x, t.x, right == 1u) * select(1.0 - t.y, t.y, up == 1u);
        let at = STRETCHED_AT + ((first.y + up) * ALBEDO_ALPHAS + first.x + right) * STRETCHED_STRIDE;
        albedos.a.low += weight * scene[at];
        albedos.a.high += weight * scene[at + 1u];
        albedos.across.low += weight * scene[at + 2u];
        albedos.across.high += weight * scene[at + 3u];
        albedos.b.low += weight * scene[at + 4u];
        albedos.b.high += weight * scene[at + 5u];
        albedos.stretch += weight * scene[at + 6u];
    }
    return albedos;
}

/// The fourth table the same.
fn add_solid(plain: Albedos, alpha: vec2<f32>, ior: f32) -> Albedos {
    var albedos = plain;
    let place = solid_place(alpha, ior);
    let first = min(vec3<u32>(place), vec3<u32>(SOLID_ALPHAS, SOLID_INDICES, SOLID_RATIOS) - 2u);
    let t = place - vec3<f32>(first);
    for (var corner = 0u; corner < 8u; corner += 1u) {
        let step = vec3<u32>(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let weights = select(vec3<f32>(1.0) - t, t, step == vec3<u32>(1u));
        let weight = weights.x * weights.y * weights.z;
        let entry = ((first.x + step.x) * SOLID_INDICES + first.y + step.y) * SOLID_RATIOS + first.z + step.z;
        let at = SOLID_AT + entry * SOLID_STRIDE;
        albedos.a = add_curve(albedos.a, weight, at);
        albedos.b = add_curve(albedos.b, weight, at + 2u);
        albedos.across = add_curve(albedos.across, weight, at + 4u);
        albedos.dense_low = add_curve(albedos.dense_low, weight, at + 6u);
        albedos.dense_mid = add_curve(albedos.dense_mid, weight, at + 8u);
        albedos.dense_high = add_curve(albedos.dense_high, weight, at + 10u);
        albedos.dense_across += weight * scene[at + 12u];
        albedos.stretch += weight * scene[at + 13u];
    }
    return albedos;
}

/// The fifth between its entries, by what layers hold back at its cosines.
fn load_held_back(alpha: vec2<f32>, at_nodes: vec4<f32>) -> HeldBack {
    let place = held_place(alpha);
    let first = min(vec2<u32>(place), vec2<u32>(HELD_ALPHAS, HELD_RATIOS) - 2u);
    let t = place - vec2<f32>(first);
    var held = HeldBack(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0));
    for (var corner = 0u; corner < 4u; corner += 1u) {
        let right = corner & 1u;
        let up = corner >> 1u;
        let by_nodes = at_nodes * (select(1.0 - t.x, t.x, right == 1u) * select(1.0 - t.y, t.y, up == 1u));
        let at = HELD_AT + ((first.x + right) * HELD_RATIOS + first.y + up) * HELD_STRIDE;
        held.all += held_powers(at, by_nodes);
        if (may_have(FEATURE_ANISOTROPY) && alpha.x != alpha.y) {
            held.across += held_powers(at + 1u, by_nodes);
            held.blended += held_powers(at + 2u, by_nodes);
        }
    }
    return held;
}

/// Coefficients of a function of the azimuth.
fn held_powers(at: u32, by_nodes: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(dot(scene[at], by_nodes), dot(scene[at + 3u], by_nodes), dot(scene[at + 6u], by_nodes), dot(scene[at + 9u], by_nodes));
}

fn add_curve(sum: Curve, weight: f32, at: u32) -> Curve {
    return Curve(sum.low + weight * scene[at], sum.high + weight * scene[at + 1u]);
}

/// What a medium lets through over a distance.
fn medium_transmittance(medium: u32, distance: f32) -> vec3<f32> {
    if (!may_have(FEATURE_INSIDES) || medium == NONE) {
        return vec3<f32>(1.0);
    }
    let sigma = scene[material_at(medium) + 2u].xyz;
    return vec3<f32>(exp_negative(-sigma.x * distance), exp_negative(-sigma.y * distance), exp_negative(-sigma.z * distance));
}

/// The medium of a segment that starts in one and ends at a surface, `towards_start` pointing back:
/// the surface's own where the segment arrives from its inside. flags: its material's.
fn medium_before(medium: u32, surface: Surface, flags: u32, towards_start: vec3<f32>) -> u32 {
    let from_inside = has_inside(flags) && dot(surface.ng, towards_start) < 0.0;
    return select(medium, surface.material, from_inside);
}

/// The medium that a direction leads into from a surface reached from wo through `medium`.
fn medium_towards(medium: u32, surface: Surface, material: Material, wo: vec3<f32>, wi: vec3<f32>) -> u32 {
    let cos_i = dot(surface.ng, wi);
    let crosses = bends(material) && cos_i * dot(surface.ng, wo) < 0.0;
    return select(medium, select(NONE, surface.material, cos_i < 0.0), crosses);
}
