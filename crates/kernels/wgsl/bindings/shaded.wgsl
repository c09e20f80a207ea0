// Points on surfaces with their materials: textures, vertex colours and normal maps applied.

#include "bindings/material.wgsl"
#include "bindings/opacity.wgsl"

/// The cosine below which a normal map does not take the shading normal: a surface seen from its front
/// keeps a hemisphere to scatter into.
const LEAST_NORMAL_COSINE: f32 = 0.02;

/// A point on a surface and what it is made of there.
struct Shaded {
    surface: Surface,
    material: Material,
}

/// A point's record, with what varies over the surface.
struct RawPoint {
    surface: Surface,
    raw: RawMaterial,
}

/// The point at barycentric coordinates u and v of a triangle's second and third vertex.
fn load_raw_point(id: u32, u: f32, v: f32) -> RawPoint {
    var surface = load_surface(id, u, v);
    var raw = load_raw_material(surface.material);
    raw.color *= surface.color.xyz;
    if ((raw.flags & MATERIAL_TEXTURED) != 0u) {
        raw = add_textures(raw, surface);
    }
    if ((raw.flags & MATERIAL_NORMAL_MAP) != 0u) {
        surface = bend_normal(surface);
    }
    return RawPoint(surface, raw);
}

/// The same with all that scattering needs.
fn load_shaded(id: u32, u: f32, v: f32) -> Shaded {
    let point = load_raw_point(id, u, v);
    return Shaded(point.surface, finish_material(point.raw, load_albedos(point.raw)));
}

/// A record's values times its textures, in the ranges that the values have.
fn add_textures(plain: RawMaterial, surface: Surface) -> RawMaterial {
    let m = surface.material;
    let a = surface.uv0;
    let b = surface.uv1;
    var raw = plain;
    raw.color = saturate(raw.color * slot_rgba(m, SLOT_COLOR, a, b).xyz);
    raw.emission = max(raw.emission * slot_rgba(m, SLOT_EMISSION, a, b).xyz, vec3<f32>(0.0));
    if (raw.kind == SURFACE_DIFFUSE) {
        return raw;
    }
    raw.specular_color = max(raw.specular_color * slot_rgba(m, SLOT_SPECULAR_COLOR, a, b).xyz, vec3<f32>(0.0));
    raw.roughness = saturate(raw.roughness
        * vec2<f32>(slot_value(m, SLOT_ROUGHNESS, a, b), slot_value(m, SLOT_ROUGHNESS_ACROSS, a, b)));
    if (raw.kind != SURFACE_METALLIC_ROUGHNESS) {
        return raw;
    }
    raw.metallic = saturate(raw.metallic * slot_value(m, SLOT_METALLIC, a, b));
    raw.transmission = saturate(raw.transmission * slot_value(m, SLOT_TRANSMISSION, a, b));
    raw.specular = saturate(raw.specular * slot_value(m, SLOT_SPECULAR, a, b));
    raw.eta_or_sheen = saturate(raw.eta_or_sheen
        * vec4<f32>(slot_rgba(m, SLOT_SHEEN_COLOR, a, b).xyz, slot_value(m, SLOT_SHEEN_ROUGHNESS, a, b)));
    raw.k_or_coat = saturate(raw.k_or_coat * vec3<f32>(slot_value(m, SLOT_CLEARCOAT, a, b),
        slot_value(m, SLOT_CLEARCOAT_ROUGHNESS, a, b), slot_value(m, SLOT_ANISOTROPY, a, b)));
    raw.rotation = turned(raw.rotation, surface);
    return raw;
}

/// A record's rotation, (cos, sin), applied to the direction that its map has at a point.
fn turned(rotation: vec2<f32>, surface: Surface) -> vec2<f32> {
    let word = load_slot(surface.material, SLOT_ANISOTROPY_DIRECTION);
    if (word == NONE) {
        return rotation;
    }
    let texel = sample_texture(word >> 2u, surface.uv0, surface.uv1).xy * 2.0 - vec2<f32>(1.0);
    let along = texel * map_axes(word >> 2u);
    let size2 = dot(along, along);
    if (size2 < 1e-6) {
        return rotation;
    }
    let unit = along * inverseSqrt(size2);
    return vec2<f32>(rotation.x * unit.x - rotation.y * unit.y, rotation.y * unit.x + rotation.x * unit.y);
}

/// Signs of a map's axes, right and up, along the tangent and the bitangent: its axes are those of the
/// image, and where that lies mirrored on the surface, so do they.
fn map_axes(texture: u32) -> vec2<f32> {
    let map = load_texture(texture);
    return vec2<f32>(select(1.0, -1.0, map.row_u.x < 0.0), select(1.0, -1.0, map.row_v.y < 0.0));
}

/// The shading normal by the material's normal map, kept in ng's hemisphere.
fn bend_normal(plain: Surface) -> Surface {
    let texel = slot_rgba(plain.material, SLOT_NORMAL, plain.uv0, plain.uv1).xyz * 2.0 - vec3<f32>(1.0);
    let scale = load_slot_numbers(plain.material).x;
    let axes = scale * map_axes(load_slot(plain.material, SLOT_NORMAL) >> 2u);
    let bitangent = plain.bitangent_sign * cross(plain.ns, plain.tangent);
    let bent = texel.x * axes.x * plain.tangent + texel.y * axes.y * bitangent + texel.z * plain.ns;
    let size2 = dot(bent, bent);
    if (size2 < 1e-12) {
        return plain;
    }
    let unit = bent * inverseSqrt(size2);
    let missing = max(LEAST_NORMAL_COSINE - dot(unit, plain.ng), 0.0);
    var surface = plain;
    surface.ns = normalize(unit + missing * plain.ng); // not zero: its cosine to ng is LEAST_NORMAL_COSINE or more
    surface.tangent = tangent_along(surface.ns, plain.tangent);
    return surface;
}

/// A point of a light, its emission times how much of the surface is there: a point drawn on a hole emits
/// nothing. (A ray that hits a light has met what is there.)
fn load_emitter(id: u32, u: f32, v: f32) -> Shaded {
    var shaded = load_shaded(id, u, v);
    if ((shaded.material.flags & MATERIAL_CUTOUT) != 0u) {
        shaded.material.emission *= coverage(shaded.surface);
    }
    return shaded;
}
