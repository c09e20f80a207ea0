// Metals: reflection by GGX facets, F by Schlick from F0 or by η + ik for each channel.
//
// f = F(wo·h) D(h) G₂ / (4 cos cos) + F_ms L(wo) L(wi) / (π L_mean), L = 1 - E what single bounces
// lose, F_ms the colour of those that bounce on (Kulla and Conty 2017): reciprocal, and a white
// metal reflects all, within 0.02; F_ms = 0 where a scene asks for single bounces. A smooth one is a delta
// lobe of weight F.

/// Curves: a the loss, of stretched facets with `across`.
fn finish_conductor(raw: RawMaterial, plain: Material) -> Material {
    var material = plain;
    var mean = fresnel_schlick_mean(raw.color, vec3<f32>(1.0));
    var normal = raw.color;
    material.f0 = raw.color;
    material.f90 = vec3<f32>(1.0);
    if ((raw.flags & MATERIAL_COMPLEX) != 0u) {
        material.f0 = raw.eta_or_sheen.xyz;
        material.f90 = raw.k_or_coat;
        material.reflect = raw.color;
        mean = raw.color * fresnel_complex_mean(material.f0, material.f90);
        normal = raw.color * fresnel_complex(material.f0, material.f90, 1.0);
    }
    material.albedo = max3(normal);
    if (bounces_on(material)) {
        let loss = loss_mean(material);
        material.ms_front = multiple_bounces(mean, loss) * (INV_PI / loss);
        material.ms_back = material.ms_front;
    }
    return material;
}

/// Mean over the hemisphere, weighted by the cosine, by Gauss and Legendre's rule in the square of
/// the cosine (3 points).
fn fresnel_complex_mean(eta: vec3<f32>, k: vec3<f32>) -> vec3<f32> {
    return (5.0 * fresnel_complex(eta, k, sqrt(0.112701665)) + 8.0 * fresnel_complex(eta, k, sqrt(0.5))
        + 5.0 * fresnel_complex(eta, k, sqrt(0.887298335))) / 18.0;
}
