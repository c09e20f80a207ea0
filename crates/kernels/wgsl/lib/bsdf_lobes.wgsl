// What conductors, dielectrics, plastic and metallic-roughness have in common: lobes at an interface
// of facets, evaluated and sampled in local directions (z the shading normal on wo's side, wo.z > 0;
// wi.z < 0 is transmitted). `front`: whether wo is on the front.

/// Chances of the lobes, their sum 1 or, where nothing scatters, 0. Each is a function of the side
/// and of the line along wo.xy and |cos wo| alone, so that a delta reflection is chosen in reverse by the
/// same chance; so is a delta transmission, but of a solid that has more lobes on one side than on the
/// other (the weights of MIS then leave the ratio out, on all strategies alike: they sum to 1 all the same).
struct Lobes {
    facets: f32,
    /// Cosine-distributed, on wo's side and on the other.
    reflected: f32,
    transmitted: f32,
    coat: f32,
}

/// What the interface does with light that meets a facet: no distribution, no masking.
struct Split {
    reflected: vec3<f32>,
    transmitted: vec3<f32>,
}

/// The index on the far side over that on wo's.
fn relative_index(material: Material, front: bool) -> f32 {
    let from_inside = !front && (material.flags & MATERIAL_INSIDE) != 0u;
    return select(material.ior, 1.0 / material.ior, from_inside);
}

/// Fresnel's factors with their colours; the same from both sides of a facet.
fn interface_split(material: Material, front: bool, cos_o: f32) -> Split {
    let cosine = clamp(cos_o, 0.0, 1.0);
    let eta = relative_index(material, front);
    if (is_kind(material.kind, SURFACE_CONDUCTOR, FEATURE_CONDUCTOR)) {
        return Split(conductor_fresnel(material, cosine), vec3<f32>(0.0));
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        return metallic_split(material, eta, cosine);
    }
    let exact = fresnel_dielectric(cosine, eta).x;
    let sheet = material.kind == SURFACE_DIELECTRIC && !bends(material);
    let f = select(exact, fresnel_sheet(exact), sheet);
    return Split(material.reflect * f, material.transmit * (1.0 - f));
}

fn conductor_fresnel(material: Material, cosine: f32) -> vec3<f32> {
    if ((material.flags & MATERIAL_COMPLEX) != 0u) {
        return material.reflect * fresnel_complex(material.f0, material.f90, cosine);
    }
    return fresnel_schlick(material.f0, cosine);
}

/// Schlick's approximation by the cosine on the rarer side; 1 at total internal reflection.
fn metallic_split(material: Material, eta: f32, cosine: f32) -> Split {
    var rare = cosine;
    if (bends(material) && eta < 1.0) {
        let sin2 = (1.0 - cosine * cosine) / (eta * eta);
        if (sin2 >= 1.0) {
            return Split(vec3<f32>(1.0), vec3<f32>(0.0));
        }
        rare = sqrt(1.0 - sin2);
    }
    let through = vec3<f32>(1.0) - fresnel_schlick_to(material.base_f0, vec3<f32>(material.base_f90), rare);
    return Split(fresnel_schlick_to(material.f0, material.f90, rare), material.transmit * through);
}

/// The chance of reflection at a facet.
fn reflection_chance(split: Split) -> f32 {
    let reflected = max3(split.reflected);
    let sum = reflected + max3(split.transmitted);
    return select(0.0, reflected / max(sum, 1e-30), sum > 0.0);
}

/// What single scattering loses, for a direction on a side.
fn loss_at(material: Material, front: bool, w: vec3<f32>) -> f32 {
    if (has_solid_losses(material.alpha, material.flags)) {
        return solid_loss(material, front == (material.ior < 1.0), w);
    }
    if (bends(material) && !front) {
        return curve_at(material.curves.b, w.z);
    }
    if (has_stretched_curves(material.alpha, material.flags)) {
        let place = stretched_cosine(material.alpha, w);
        let blend = stretched_blend(material.alpha, w, material.curves.stretch.x);
        return mix(curve_at(material.curves.a, place), curve_at(material.curves.across, place), blend);
    }
    return curve_at(material.curves.a, w.z);
}

/// The same of a stretched solid, from the denser side or the rarer.
fn solid_loss(material: Material, dense: bool, w: vec3<f32>) -> f32 {
    let curves = material.curves;
    let root = sqrt(stretched_cosine(material.alpha, w));
    let azimuth = solid_azimuth(material.alpha, w, material.ior, dense);
    let x = azimuth.x;
    let x2 = x * x;
    if (!dense) {
        let factors = powers_at(curves.a, curves.b, curves.across, root);
        return saturate(dot(factors, vec4<f32>(1.0, x, x2, azimuth.y)));
    }
    let factors = powers_at(curves.dense_low, curves.dense_mid, curves.dense_high, root);
    let r2 = root * root;
    let across = dot(curves.dense_across, vec4<f32>(1.0, root, r2, r2 * root)) + r2 * r2 * (curves.stretch.x + root * curves.stretch.y);
    return saturate(dot(factors, vec4<f32>(1.0, x, x2, x * x2)) + across * azimuth.y);
}

/// Four polynomials of degree 5 at once.
fn powers_at(low: Curve, mid: Curve, high: Curve, s: f32) -> vec4<f32> {
    return low.low + s * (low.high + s * (mid.low + s * (mid.high + s * (high.low + s * high.high))));
}

/// Its mean over the hemisphere, weighted by the cosine; of what does not bend.
fn loss_mean(material: Material) -> f32 {
    if (has_stretched_curves(material.alpha, material.flags)) {
        return clamp(material.curves.stretch.z, 1e-6, 1.0);
    }
    return lost_mean(material.curves.a, material.alpha.x);
}

/// The cosine by which stretched facets meet light of a direction, for the albedo with Fresnel's factor
/// to be what they do not lose times that factor.
fn stretched_facing(material: Material, w: vec3<f32>) -> f32 {
    let mu = w.z;
    let powers = vec4<f32>(1.0, mu, mu * mu, mu * mu * mu);
    let blend = stretched_blend(material.alpha, w, material.curves.stretch.y);
    let square = mix(dot(material.curves.b.low, powers), dot(material.curves.b.high, powers), blend);
    return sqrt(clamp(square, 0.0, 1.0));
}

/// A direction of a rule over the hemisphere, weighted by the cosine: Gauss and Legendre's in the square
/// of the cosine (4 points), along the normal's plane alone or, of stretched facets, at 2 azimuths.
struct MeanPoint {
    w: vec3<f32>,
    weight: f32,
}

fn n_mean_points(material: Material) -> u32 {
    return select(4u, 8u, has_stretched_curves(material.alpha, material.flags));
}

fn mean_point(material: Material, i: u32) -> MeanPoint {
    let outer = (i & 3u) < 2u;
    let near = select(0.330009478, 0.0694318442, outer);
    let square = select(near, 1.0 - near, (i & 1u) != 0u);
    let weight = select(0.326072577, 0.173927423, outer);
    if (!has_stretched_curves(material.alpha, material.flags)) {
        return MeanPoint(vec3<f32>(0.0, 0.0, sqrt(square)), weight);
    }
    // An eighth and three eighths of the quarter turn from along to across.
    let azimuth = select(vec2<f32>(0.923879533, 0.382683432), vec2<f32>(0.382683432, 0.923879533), i > 3u);
    return MeanPoint(vec3<f32>(sqrt(1.0 - square) * azimuth, sqrt(square)), 0.5 * weight);
}

/// How a surface meets light of one direction.
struct Aspect {
    /// What single scattering loses.
    loss: f32,
    /// What the coat lets through; coat and sheen together.
    under_coat: f32,
    layers: f32,
    /// What they hold back of a white metal's light.
    held: f32,
    /// What the coat lets through by its own normal.
    under_own: f32,
    /// Albedo of a sheen of colour 1.
    sheen: f32,
    /// What reaches the base.
    through: vec3<f32>,
}

/// By the side, the direction, whose cosine to the normal (z) is not negative, and its cosine to the coat's.
fn aspect_at(material: Material, front: bool, w: vec3<f32>, coat_cosine: f32) -> Aspect {
    var aspect = Aspect(0.0, 1.0, 1.0, 0.0, 1.0, 0.0, vec3<f32>(0.0));
    if (!is_smooth(material)) {
        aspect.loss = loss_at(material, front, w);
    }
    if (is_kind(material.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
        aspect.through = plastic_through(material, w, aspect.loss);
    }
    if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        if (may_have(FEATURE_LAYERS)) {
            aspect.under_coat = coat_through(material, w.z);
            aspect.under_own = aspect.under_coat;
            if (coat_leans(material)) {
                aspect.under_own = coat_through(material, coat_cosine);
            }
            aspect.sheen = curve_at(material.curves.sheen, w.z);
            aspect.layers = layers_through(material, aspect.under_coat, aspect.sheen);
            aspect.held = held_at(material.curves.held, material.alpha, w);
        }
        aspect.through = aspect.layers * metallic_through(material, w, aspect.loss);
    }
    return aspect;
}

fn ms_at(material: Material, front: bool) -> vec3<f32> {
    if (!may_have(FEATURE_INSIDES)) {
        return material.ms_front; // what is thin is alike from both sides
    }
    return select(material.ms_back, material.ms_front, front);
}

/// What a smooth coat lets through along the surface is bounded by it where it divides.
const LEAST_THROUGH: f32 = 1e-6;

/// Whether the layers and the base of plastic and of metallic-roughness are met from this side.
fn has_layers(material: Material, front: bool) -> bool {
    return front || !bends(material);
}

/// Chances of the lobes, about in proportion to what they scatter, by the side, the cosine and what is
/// met there.
fn lobe_chances(material: Material, front: bool, mu: f32, met: Aspect) -> Lobes {
    var facets = 1.0;
    var reflected = 0.0;
    var transmitted = 0.0;
    var coat = 0.0;
    if (!is_smooth(material)) {
        let both = may_have(FEATURE_TRANSMISSION) && max3(material.ms_transmit) > 0.0;
        reflected = select(0.0, select(met.loss, 0.5 * met.loss, both), max3(ms_at(material, front)) > 0.0);
        transmitted = select(0.0, 0.5 * met.loss, both);
        facets = 1.0 - met.loss;
    }
    if (has_layers(material, front)) {
        if (is_kind(material.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
            facets *= max3(material.reflect) * (1.0 - met.through.x);
            reflected = reflected * max3(material.reflect) + PI * max3(material.reflectance) * met.through.x;
        }
        if (is_kind(material.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
            let f = fresnel_schlick_to(material.f0, material.f90, mu);
            facets *= met.layers * (max3(f) + 0.02 * max3(material.f90) + max3(material.transmit));
            let held = met.held / max(max3(material.held_back) + max3(material.held_transmit), 1e-30);
            reflected = met.layers * reflected + held * max3(material.held_back) + PI * max3(material.reflectance * met.through)
                + max3(material.sheen) * (0.05 + met.sheen);
            transmitted = met.layers * transmitted + held * max3(material.held_transmit);
            coat = 1.0 - met.under_own;
            if (coat_leans(material)) {
                let under = met.under_own / max(met.under_coat, LEAST_THROUGH);
                facets *= under;
                reflected *= under;
                transmitted *= under;
            }
        }
    }
    let sum = facets + reflected + transmitted + coat;
    let scale = select(0.0, 1.0 / max(sum, 1e-30), sum > 0.0);
    return Lobes(facets * scale, reflected * scale, transmitted * scale, coat * scale);
}

/// Whether a rough interface lets light through.
fn may_transmit(material: Material) -> bool {
    return may_have(FEATURE_TRANSMISSION) && !is_smooth(material) && max3(material.transmit) > 0.0;
}
