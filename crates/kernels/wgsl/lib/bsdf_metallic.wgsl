// glTF 2.0's metallic-roughness model with KHR_materials_specular, _ior, _transmission, _volume,
// _clearcoat, _sheen and _anisotropy. From the top:
//
// Coat: index 1.5 (F0 0.04, Schlick), strength c, GGX of its own roughness, a delta lobe where smooth.
// Sheen: lib/sheen.wgsl. Interface: GGX, F from mix(F0, base colour, metallic) to mix(specular, 1,
// metallic), F0 = ((n - 1) / (n + 1))² specular colour, times specular; what it transmits,
// (1 - F) base colour, bends where solid and goes on as if mirrored where thin. Base: diffuse.
//
// glTF's own layering goes by wo alone; these are reciprocal:
//   diffuse: ρ T(wo) T(wi) / (π T_mean), T = what all layers let through (Ashikhmin and Shirley
//     2000, with albedos in place of Schlick's F): white loses nothing;
//   interface and its multiple bounces: times the lesser of S(wo) and S(wi), S = (1 - c E_coat)
//     (1 - max sheen E_sheen). Of mirrored light this is what layers let through; what it takes from light
//     that facets spread comes back of metals and of thin sheets, by a table, as a lobe of its own:
//     held_back(wo) held_back(wi).
// A coat with a normal of its own is a lobe about that, and covers what is below as seen by that normal
// from the camera (lib/bsdf_leaning.wgsl), as glTF has it.
// Limits: sheen and coat cover the front of a solid alone; a solid has no diffuse base from within, and as a metal no multiple bounces.

/// Curves: a the loss of a mirror, b its CURVE_GRAZING, or those of stretched facets; solid, a the loss at the front and b at the
/// back.
fn finish_metallic(raw: RawMaterial, plain: Material) -> Material {
    var material = plain;
    let rim = (raw.ior - 1.0) / (raw.ior + 1.0);
    let dielectric = 1.0 - raw.metallic;
    material.base_f0 = min(rim * rim * raw.specular_color, vec3<f32>(1.0)) * raw.specular;
    material.base_f90 = raw.specular;
    material.f0 = mix(material.base_f0, raw.color, vec3<f32>(raw.metallic));
    material.f90 = vec3<f32>(mix(raw.specular, 1.0, raw.metallic));
    material.transmit = raw.color * (raw.transmission * dielectric);
    material.coat = raw.k_or_coat.x;
    material.coat_alpha = coat_alpha(raw);
    material.sheen = raw.eta_or_sheen.xyz;
    material.sheen_alpha = sheen_alpha(raw);
    if (!is_smooth(material)) {
        material = metallic_bounces(raw, material);
    }
    let diffuse = raw.color * (dielectric * (1.0 - raw.transmission));
    material.reflectance = diffuse * INV_PI / max(metallic_through_mean(material), vec3<f32>(1e-4));
    if (holds_back(raw) && !is_smooth(material)) {
        let scale = INV_PI / held_mean(material.curves.held, material.alpha);
        // It has met the metal more than once.
        let metal = fresnel_schlick_mean(raw.color, vec3<f32>(1.0));
        material.held_back = metal * metal * (raw.metallic * scale);
        if (!bends(material)) {
            material.held_transmit = material.transmit * (vec3<f32>(1.0) - fresnel_schlick_mean(material.base_f0, vec3<f32>(material.base_f90))) * scale;
        }
    }
    material.albedo = max(max(max3(raw.color), max3(material.base_f0)), max(max3(material.sheen), 0.25));
    let has_density = max3(diffuse) > 0.0 || max3(material.sheen) > 0.0 || (material.coat > 0.0 && material.coat_alpha > 0.0);
    if (has_density) {
        material.flags |= MATERIAL_CONNECTIBLE;
    }
    return material;
}

/// The factors of multiple bounces at a rough interface.
fn metallic_bounces(raw: RawMaterial, plain: Material) -> Material {
    var material = plain;
    let dielectric = 1.0 - raw.metallic;
    let transmits = dielectric * raw.transmission;
    if (bends(material)) {
        return solid_bounces(material, dielectric_mean(max(raw.ior, 1.0 / raw.ior)), transmits);
    }
    let loss = loss_mean(material);
    let mean = fresnel_schlick_mean(material.base_f0, vec3<f32>(material.base_f90));
    let metal = multiple_bounces(fresnel_schlick_mean(raw.color, vec3<f32>(1.0)), loss);
    material.base_ms = multiple_bounces(mean, loss);
    material.ms_front = (raw.metallic * metal + (dielectric - transmits) * material.base_ms) * (INV_PI / loss);
    return thin_bounces(material, mean, transmits);
}

/// What the coat and the sheen let through, by the coat's part and the albedo of a sheen of colour 1.
fn layers_through(material: Material, under_coat: f32, sheen: f32) -> f32 {
    return under_coat * (1.0 - max3(material.sheen) * sheen);
}

/// What the coat and the sheen let through to the interface between two directions; symmetric.
fn layers_between(o: Met, i: Met) -> f32 {
    return min(o.aspect.layers, i.aspect.layers);
}

/// What layers do not let through at the cosines of the fifth table.
fn held_at_nodes(raw: RawMaterial, albedos: Albedos) -> vec4<f32> {
    return vec4<f32>(held_at_node(raw, albedos, HELD_NODE_0), held_at_node(raw, albedos, HELD_NODE_1),
        held_at_node(raw, albedos, HELD_NODE_2), held_at_node(raw, albedos, HELD_NODE_3));
}

fn held_at_node(raw: RawMaterial, albedos: Albedos, mu: f32) -> f32 {
    let coat = raw.k_or_coat.x * coat_albedo(albedos.coat, coat_alpha(raw), mu);
    return 1.0 - (1.0 - coat) * (1.0 - max3(raw.eta_or_sheen.xyz) * curve_at(albedos.sheen, mu));
}

/// What a coat of strength 1 reflects.
fn coat_albedo(curve: Curve, alpha: f32, mu: f32) -> f32 {
    if (alpha > 0.0) {
        return curve_at(curve, mu);
    }
    return fresnel_schlick(vec3<f32>(COAT_F0), mu).x;
}

/// Index 1.5.
const COAT_F0: f32 = 0.04;

/// What a facet of the coat reflects.
fn coat_fresnel(material: Material, cosine: f32) -> f32 {
    return material.coat * fresnel_schlick(vec3<f32>(COAT_F0), cosine).x;
}

/// What the coat's facets do not reflect, at a cosine to the normal.
fn coat_through(material: Material, mu: f32) -> f32 {
    if (!may_have(FEATURE_LAYERS)) {
        return 1.0;
    }
    return 1.0 - material.coat * coat_albedo(material.curves.coat, material.coat_alpha, mu);
}

/// What the interface lets through to the base, for a direction with the loss there.
fn metallic_through(material: Material, w: vec3<f32>, loss: f32) -> vec3<f32> {
    let f90 = vec3<f32>(material.base_f90);
    var reflected = fresnel_schlick_to(material.base_f0, f90, w.z);
    if (!is_smooth(material) && !bends(material)) {
        let grazing = grazing_at(material, w, loss);
        reflected = material.base_f0 * (1.0 - loss - grazing) + f90 * grazing + material.base_ms * loss;
    }
    return max(vec3<f32>(1.0) - reflected, vec3<f32>(0.0));
}

/// The albedo of facets with the factor (1 - cos)⁵, for a direction with the loss there.
fn grazing_at(material: Material, w: vec3<f32>, loss: f32) -> f32 {
    if (!has_stretched_curves(material.alpha, material.flags)) {
        return curve_at(material.curves.b, w.z);
    }
    let away = 1.0 - stretched_facing(material, w);
    let square = away * away;
    return (1.0 - loss) * square * square * away;
}

/// What reaches the base, on average over the hemisphere, weighted by the cosine.
fn metallic_through_mean(material: Material) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < n_mean_points(material); i += 1u) {
        let point = mean_point(material, i);
        sum += point.weight * aspect_at(material, true, point.w, point.w.z).through;
    }
    return sum;
}
