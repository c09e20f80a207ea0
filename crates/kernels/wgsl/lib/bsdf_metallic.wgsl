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
//   interface and its multiple bounces: times S(wo) S(wi) over what lies between the larger of them
//     and mean S (layers_between), S = (1 - c E_coat)(1 - max sheen E_sheen): a white metal under a
//     rough coat is white within 0.02, under a smooth one within 0.05.
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
    let through = metallic_through_mean(material);
    material.layers_mean = through.w;
    material.reflectance = diffuse * INV_PI / max(through.xyz, vec3<f32>(1e-4));
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

/// What the coat and the sheen let through to the interface between two directions, by what they let
/// through at each; symmetric. Between mirrored directions of narrow lobes min(S, S'), for lobes as wide
/// as the hemisphere S S' / mean S: each lets through S.
fn layers_between(material: Material, o: Met, i: Met) -> f32 {
    if (!may_have(FEATURE_LAYERS)) {
        return 1.0;
    }
    let width = saturate(1.5 * alpha_between(material.alpha, o.w.xy, i.w.xy));
    let at_o = o.aspect.layers;
    let at_i = i.aspect.layers;
    return at_o * at_i / max(mix(max(at_o, at_i), material.layers_mean, width), 1e-4);
}

/// α along two directions, the more the longer they are along the surface; symmetric. Stretched facets
/// seen across the larger reflect along a cone about it, where layers let through as little.
fn alpha_between(alpha: vec2<f32>, o: vec2<f32>, i: vec2<f32>) -> f32 {
    if (!may_have(FEATURE_ANISOTROPY) || alpha.x == alpha.y) {
        return alpha.x;
    }
    let squares = o * o + i * i;
    return sqrt(dot(alpha * alpha, squares) / max(squares.x + squares.y, 1e-20));
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
    if (material.coat_alpha > 0.0) {
        return 1.0 - material.coat * curve_at(material.curves.coat, mu);
    }
    return 1.0 - coat_fresnel(material, mu);
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

/// What reaches the base, on average over the hemisphere, weighted by the cosine, and of layers alone (w).
fn metallic_through_mean(material: Material) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < n_mean_points(material); i += 1u) {
        let point = mean_point(material, i);
        let met = aspect_at(material, true, point.w, point.w.z);
        sum += point.weight * vec4<f32>(met.through, met.layers);
    }
    return sum;
}
