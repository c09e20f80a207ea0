// Materials: what a record holds (RawMaterial), and what scattering needs of it at a point
// (Material). Whatever varies over a surface is multiplied into the raw values; only then
// `finish_material` derives the rest.

const SURFACE_DIFFUSE: u32 = 0u;
const SURFACE_CONDUCTOR: u32 = 1u;
const SURFACE_DIELECTRIC: u32 = 2u;
const SURFACE_PLASTIC: u32 = 3u;
const SURFACE_METALLIC_ROUGHNESS: u32 = 4u;
/// Light goes straight on.
const SURFACE_NULL: u32 = 5u;

// Material.flags
const MATERIAL_EMITS_BACK: u32 = 1u;
/// Light that meets the back is absorbed.
const MATERIAL_FRONT_ONLY: u32 = 2u;
/// Has an inside that light travels in: what is transmitted is bent. Else it is thin.
const MATERIAL_INSIDE: u32 = 4u;
/// α is the square of the roughness.
const MATERIAL_SQUARED: u32 = 8u;
/// A conductor by η + ik, not by F0.
const MATERIAL_COMPLEX: u32 = 16u;
/// Plastic: light reflected within takes on the base's colour again.
const MATERIAL_NONLINEAR: u32 = 32u;
/// Derived: some of it scatters into a density, not by delta lobes alone.
const MATERIAL_CONNECTIBLE: u32 = 64u;
/// Light that meets a second facet is lost.
const MATERIAL_SINGLE_BOUNCE: u32 = 128u;
/// Some of what it transmits may have a density.
const MATERIAL_TRANSMITS: u32 = 256u;
/// Its index of refraction differs by colour (lib/dispersion.wgsl).
const MATERIAL_DISPERSES: u32 = 512u;
/// Its coat has a normal of its own.
const MATERIAL_COAT_NORMAL: u32 = 1024u;
/// Nothing of it scatters into a density, whatever its textures say.
const MATERIAL_DELTA: u32 = 2048u;

/// A record: the scene's values, unchanged.
struct RawMaterial {
    kind: u32,
    flags: u32,
    /// Reflectance, F0, a conductor's tint, what tints transmission, or the base colour.
    color: vec3<f32>,
    /// Emitted radiance.
    emission: vec3<f32>,
    /// Inside over outside.
    ior: f32,
    /// What tints a dielectric's or a coat's reflection, or KHR_materials_specular's colour.
    specular_color: vec3<f32>,
    specular: f32,
    /// Along the tangent and across it; MATERIAL_SQUARED says whether α is their square.
    roughness: vec2<f32>,
    metallic: f32,
    transmission: f32,
    /// Complex: η. Metallic-roughness: the sheen's colour and roughness.
    eta_or_sheen: vec4<f32>,
    /// Complex: k. Metallic-roughness: clear coat, its roughness, anisotropy.
    k_or_coat: vec3<f32>,
    /// The direction of anisotropy in the tangent plane: (cos, sin) of its rotation.
    rotation: vec2<f32>,
}

/// The curves that a material needs, see `finish_material` of each kind.
struct Albedos {
    a: Curve,
    b: Curve,
    sheen: Curve,
    /// Albedo of a rough coat.
    coat: Curve,
    /// Of facets of two α (`has_stretched_curves`): what is lost across the larger, and q of losses, q of
    /// cosines, the mean loss. Of plastic of single bounces: what is lost from within.
    across: Curve,
    stretch: vec4<f32>,
    /// Of stretched solids (`has_solid_losses`), an entry of the fourth table in its order: a, b and
    /// `across` from the rarer side; these from the denser; `stretch` last.
    dense_low: Curve,
    dense_mid: Curve,
    dense_high: Curve,
    dense_across: vec4<f32>,
    /// What coat and sheen hold back (`holds_back`).
    held: HeldBack,
}

fn no_albedos() -> Albedos {
    return Albedos(no_curve(), no_curve(), no_curve(), no_curve(), no_curve(), vec4<f32>(0.0), no_curve(), no_curve(), no_curve(),
        vec4<f32>(0.0), HeldBack(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0)));
}

/// A surface at a point.
struct Material {
    /// Diffuse: albedo. Else the factor of the base under its layers, T(wo) T(wi) left out.
    reflectance: vec3<f32>,
    kind: u32,
    emission: vec3<f32>,
    ior: f32,
    flags: u32,
    /// Bound of the albedo: what roulette goes by.
    albedo: f32,
    /// GGX of the interface; 0 where smooth.
    alpha: vec2<f32>,
    /// F0 (or η), F90 (or k).
    f0: vec3<f32>,
    f90: vec3<f32>,
    /// Multiply what the interface reflects and transmits.
    reflect: vec3<f32>,
    transmit: vec3<f32>,
    /// Factors of loss(wo) loss(wi): reflection at the front and at the back, transmission.
    ms_front: vec3<f32>,
    ms_back: vec3<f32>,
    ms_transmit: vec3<f32>,
    /// F0, F90 and the colour of multiple bounces, of the dielectric over the base alone.
    base_f0: vec3<f32>,
    base_f90: f32,
    base_ms: vec3<f32>,
    coat: f32,
    coat_alpha: f32,
    sheen_alpha: f32,
    sheen: vec3<f32>,
    /// The factors of what coat and sheen hold back (wo) times what they hold back (wi), that comes back
    /// as reflected and as transmitted.
    held_back: vec3<f32>,
    held_transmit: vec3<f32>,
    rotation: vec2<f32>,
    curves: Albedos,
}

/// Where directions stand at a point: unit normals, geometric and shading (in ng's hemisphere), and
/// a direction along the surface that anisotropy follows, not parallel to ns.
struct Frame {
    ng: vec3<f32>,
    ns: vec3<f32>,
    tangent: vec3<f32>,
    /// The bitangent is bitangent_sign · cross(ns, tangent).
    bitangent_sign: f32,
    /// As ns, of a coat that has a normal of its own.
    coat_ns: vec3<f32>,
}

/// α of a roughness along and across; 0 and 0 for a smooth surface.
fn ggx_alpha(roughness: vec2<f32>, squared: bool) -> vec2<f32> {
    let alpha = min(select(roughness, roughness * roughness, squared), vec2<f32>(1.0));
    let smooth_surface = max(alpha.x, alpha.y) < MIN_ALPHA;
    return select(max(alpha, vec2<f32>(MIN_ALPHA)), vec2<f32>(0.0), smooth_surface);
}

/// α of the interface.
fn interface_alpha(raw: RawMaterial) -> vec2<f32> {
    let alpha = ggx_alpha(raw.roughness, (raw.flags & MATERIAL_SQUARED) != 0u);
    // KHR_materials_anisotropy: α along is mix(α, 1, anisotropy²).
    let stretched = vec2<f32>(mix(alpha.x, 1.0, raw.k_or_coat.z * raw.k_or_coat.z), max(alpha.y, MIN_ALPHA));
    let is_stretched = raw.kind == SURFACE_METALLIC_ROUGHNESS && raw.k_or_coat.z > 0.0;
    return select(alpha, stretched, is_stretched);
}

/// Whether a and b are of facets of two α (a: the loss along the larger; b: squares of Schlick's cosine
/// along and across). What bends has losses of its own, see `has_solid_losses`; of single bounces none is
/// given back.
fn has_stretched_curves(alpha: vec2<f32>, flags: u32) -> bool {
    return may_have(FEATURE_ANISOTROPY) && alpha.x != alpha.y && !has_inside(flags) && !is_single_bounce(flags);
}

/// Whether the losses are of facets of two α that bend what they transmit; of single bounces none is given
/// back.
fn has_solid_losses(alpha: vec2<f32>, flags: u32) -> bool {
    return may_have(FEATURE_STRETCHED_SOLIDS) && alpha.x != alpha.y && has_inside(flags) && !is_single_bounce(flags);
}

fn coat_alpha(raw: RawMaterial) -> f32 {
    return ggx_alpha(vec2<f32>(raw.k_or_coat.y), true).x;
}

fn sheen_alpha(raw: RawMaterial) -> f32 {
    return clamp(raw.eta_or_sheen.w * raw.eta_or_sheen.w, MIN_SHEEN_ALPHA, 1.0);
}

/// Whether a coat or a sheen lies over a rough metal or a thin sheet whose light is given back in full.
fn holds_back(raw: RawMaterial) -> bool {
    let of_use = raw.metallic > 0.0 || (raw.transmission > 0.0 && !has_inside(raw.flags));
    return may_have(FEATURE_LAYERS) && raw.kind == SURFACE_METALLIC_ROUGHNESS && of_use && !is_single_bounce(raw.flags)
        && (raw.k_or_coat.x > 0.0 || max3(raw.eta_or_sheen.xyz) > 0.0);
}

/// Whether any curve is read.
fn needs_albedos(raw: RawMaterial) -> bool {
    return may_have(FEATURE_INTERFACES) && raw.kind != SURFACE_DIFFUSE && raw.kind != SURFACE_NULL;
}

/// Whether the curves of a solid of one α are (a: loss at the front, b: at the back), in place of
/// those of a mirror (a: loss; b: reflection of the coat for plastic, else CURVE_GRAZING).
fn needs_dielectric_losses(raw: RawMaterial) -> bool {
    return has_inside(raw.flags);
}

fn is_smooth(material: Material) -> bool {
    return !may_have(FEATURE_ROUGHNESS) || material.alpha.x == 0.0;
}

/// Whether light goes on from facet to facet.
fn bounces_on(material: Material) -> bool {
    return !is_smooth(material) && !is_single_bounce(material.flags);
}

fn is_single_bounce(flags: u32) -> bool {
    return (flags & MATERIAL_SINGLE_BOUNCE) != 0u;
}

fn has_inside(flags: u32) -> bool {
    return may_have(FEATURE_INSIDES) && (flags & MATERIAL_INSIDE) != 0u;
}

/// Whether the coat has a normal of its own.
fn coat_leans(material: Material) -> bool {
    return may_have(FEATURE_COAT_NORMALS) && (material.flags & MATERIAL_COAT_NORMAL) != 0u;
}

/// Whether what it transmits is bent, into an inside.
fn bends(material: Material) -> bool {
    return has_inside(material.flags);
}

/// A material with nothing but what all kinds have.
fn plain_material(raw: RawMaterial) -> Material {
    let zero = vec3<f32>(0.0);
    return Material(raw.color, raw.kind, raw.emission, raw.ior, raw.flags | MATERIAL_CONNECTIBLE, max3(raw.color), vec2<f32>(0.0),
        zero, zero, zero, zero, zero, zero, zero, zero, 0.0, zero, 0.0, 0.0, 0.0, zero, zero, zero, raw.rotation,
        no_albedos());
}

/// Everything that follows from a record, with the curves for its α and index.
fn finish_material(raw: RawMaterial, curves: Albedos) -> Material {
    var material = plain_material(raw);
    if (!may_have(FEATURE_INTERFACES) || raw.kind == SURFACE_DIFFUSE) {
        return material;
    }
    material.flags = raw.flags;
    material.alpha = interface_alpha(raw);
    material.curves = curves;
    material.reflect = vec3<f32>(1.0);
    if (!is_smooth(material)) {
        material.flags |= MATERIAL_CONNECTIBLE;
    }
    if (is_kind(raw.kind, SURFACE_CONDUCTOR, FEATURE_CONDUCTOR)) {
        return finish_conductor(raw, material);
    }
    if (is_kind(raw.kind, SURFACE_DIELECTRIC, FEATURE_DIELECTRIC)) {
        return finish_dielectric(raw, material);
    }
    if (is_kind(raw.kind, SURFACE_PLASTIC, FEATURE_PLASTIC)) {
        return finish_plastic(raw, material);
    }
    if (is_kind(raw.kind, SURFACE_METALLIC_ROUGHNESS, FEATURE_METALLIC_ROUGHNESS)) {
        return finish_metallic(raw, material);
    }
    return material;
}

/// Whether a surface is of a kind that the scene may have.
fn is_kind(kind: u32, wanted: u32, feature: u32) -> bool {
    return may_have(feature) && kind == wanted;
}
