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

/// A point on a surface with its record.
fn load_raw_point(surface: Surface) -> RawPoint {
    var raw = load_raw_material(surface.material);
    raw.color *= surface.color.xyz;
    let point = RawPoint(surface, raw);
    if (may_have(FEATURE_TEXTURES) && (raw.flags & MATERIAL_TEXTURED) != 0u) {
        return add_textures(point);
    }
    return point;
}

/// The same with all that scattering needs. throughput: of the subpath, on arrival.
fn shade_point(point: RawPoint, throughput: vec3<f32>) -> Shaded {
    let raw = in_one_channel(point.raw, point.surface.material, throughput);
    return Shaded(point.surface, finish_material(raw, load_albedos(raw)));
}

/// The same of a surface whose record is not loaded yet.
fn shade_surface(surface: Surface, throughput: vec3<f32>) -> Shaded {
    return shade_point(load_raw_point(surface), throughput);
}

/// A point's record times what its textures say there, and its normal bent by the map. One loop over the
/// textures that there are, so that a kernel holds the code of a lookup once.
fn add_textures(plain: RawPoint) -> RawPoint {
    var point = plain;
    let material = plain.surface.material;
    var slots = textured_slots(material);
    var texture = NONE;
    var rgba = vec4<f32>(0.0);
    while (slots != 0u) { // at most N_SLOTS times
        let slot = firstTrailingBit(slots);
        slots &= slots - 1u;
        let word = load_slot(material, slot);
        if ((word >> 2u) != texture) { // roughness and metallic are channels of one
            texture = word >> 2u;
            rgba = sample_texture(texture, plain.surface.uv0, plain.surface.uv1);
        }
        if (slot == SLOT_NORMAL) {
            point.surface = bend_normal(point.surface, rgba.xyz, texture);
        } else if (may_have(FEATURE_COAT_NORMALS) && slot == SLOT_CLEARCOAT_NORMAL) {
            point.surface.coat_ns = bent_normal(plain.surface, rgba.xyz, texture, scene[material_at(material) + 7u].y);
        } else if (may_have(FEATURE_ANISOTROPY) && slot == SLOT_ANISOTROPY_DIRECTION) {
            point.raw.rotation = turned(point.raw.rotation, rgba.xyz, texture);
        } else {
            point.raw = add_texture(point.raw, slot, rgba, rgba[word & 3u]);
        }
    }
    return point;
}

/// One value of a record times its texture, in the range that the value has.
fn add_texture(plain: RawMaterial, slot: u32, rgba: vec4<f32>, value: f32) -> RawMaterial {
    var raw = plain;
    switch slot {
        case SLOT_COLOR: { raw.color = saturate(raw.color * rgba.xyz); }
        case SLOT_EMISSION: { raw.emission = max(raw.emission * rgba.xyz, vec3<f32>(0.0)); }
        case SLOT_SPECULAR_COLOR: {
            // glTF's may exceed 1: what it reflects is cut off there.
            let most = select(1.0, 1e30, raw.kind == SURFACE_METALLIC_ROUGHNESS);
            raw.specular_color = clamp(raw.specular_color * rgba.xyz, vec3<f32>(0.0), vec3<f32>(most));
        }
        case SLOT_ROUGHNESS: { raw.roughness.x = saturate(raw.roughness.x * value); }
        case SLOT_ROUGHNESS_ACROSS: { raw.roughness.y = saturate(raw.roughness.y * value); }
        case SLOT_METALLIC: { raw.metallic = saturate(raw.metallic * value); }
        case SLOT_TRANSMISSION: { raw.transmission = saturate(raw.transmission * value); }
        case SLOT_SPECULAR: { raw.specular = saturate(raw.specular * value); }
        case SLOT_CLEARCOAT: { raw.k_or_coat.x = saturate(raw.k_or_coat.x * value); }
        case SLOT_CLEARCOAT_ROUGHNESS: { raw.k_or_coat.y = saturate(raw.k_or_coat.y * value); }
        case SLOT_ANISOTROPY: { raw.k_or_coat.z = saturate(raw.k_or_coat.z * value); }
        case SLOT_SHEEN_COLOR: { raw.eta_or_sheen = vec4<f32>(saturate(raw.eta_or_sheen.xyz * rgba.xyz), raw.eta_or_sheen.w); }
        case SLOT_SHEEN_ROUGHNESS: { raw.eta_or_sheen.w = saturate(raw.eta_or_sheen.w * value); }
        default: {}
    }
    return raw;
}

/// A record's rotation, (cos, sin), applied to the direction that a texel of its map has at a point.
fn turned(rotation: vec2<f32>, rgb: vec3<f32>, texture: u32) -> vec2<f32> {
    let along = (rgb.xy * 2.0 - vec2<f32>(1.0)) * map_axes(texture);
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

/// A surface's normal by a texel of a normal map, kept in ng's hemisphere.
fn bent_normal(plain: Surface, rgb: vec3<f32>, texture: u32, scale: f32) -> vec3<f32> {
    let texel = rgb * 2.0 - vec3<f32>(1.0);
    let axes = scale * map_axes(texture);
    let bitangent = plain.bitangent_sign * cross(plain.ns, plain.tangent);
    let bent = texel.x * axes.x * plain.tangent + texel.y * axes.y * bitangent + texel.z * plain.ns;
    let size2 = dot(bent, bent);
    if (size2 < 1e-12) {
        return plain.ns;
    }
    let unit = bent * inverseSqrt(size2);
    let missing = max(LEAST_NORMAL_COSINE - dot(unit, plain.ng), 0.0);
    return normalize(unit + missing * plain.ng); // not zero: its cosine to ng is LEAST_NORMAL_COSINE or more
}

/// The shading normal by a texel of the material's normal map.
fn bend_normal(plain: Surface, rgb: vec3<f32>, texture: u32) -> Surface {
    var surface = plain;
    surface.ns = bent_normal(plain, rgb, texture, load_slot_numbers(plain.material).x);
    surface.tangent = tangent_along(surface.ns, plain.tangent);
    return surface;
}

/// A point of a light that is a triangle.
struct Emitter {
    surface: Surface,
    /// Times how much of the surface is there: a point drawn on a hole emits nothing. (A ray that hits a
    /// light has met what is there.)
    emission: vec3<f32>,
    flags: u32,
}

fn load_emitter(id: u32, u: f32, v: f32) -> Emitter {
    let surface = load_surface(id, u, v);
    let at = material_at(surface.material);
    var emission = scene[at + 1u].xyz;
    let flags = bitcast<u32>(scene[at + 2u].w);
    if (may_have(FEATURE_TEXTURED_LIGHTS) && (flags & (MATERIAL_TEXTURED | MATERIAL_CUTOUT)) != 0u) {
        let rgba = slot_rgba(surface.material, SLOT_EMISSION, surface.uv0, surface.uv1);
        emission = max(emission * rgba.xyz, vec3<f32>(0.0)) * coverage(surface);
    }
    return Emitter(surface, emission, flags);
}
