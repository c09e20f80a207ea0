// Textures: images of the texel store by records in `scene`.

#include "bindings/texels.wgsl"

/// vec4 per entry: place, width, height, bits; then the two rows of the transform.
const TEXTURE_STRIDE: u32 = 3u;
/// vec4 of the table of the sRGB curve: 256 numbers.
const SRGB_TABLE_SIZE: u32 = 64u;

fn load_texture(index: u32) -> Texture {
    let at = params.textures_at + index * TEXTURE_STRIDE;
    let place = bitcast<vec4<u32>>(scene[at]);
    let bits = place.w;
    return Texture(place.x, place.y, place.z, bits & 3u, (bits >> 2u) & 3u, (bits >> 4u) & 3u, (bits >> 6u) & 1u,
        (bits >> 7u) & 1u, scene[at + 1u].xyz, scene[at + 2u].xyz);
}

/// A byte by the sRGB curve.
fn srgb_byte(byte: u32) -> f32 {
    return scene[params.srgb_at + (byte >> 2u)][byte & 3u];
}

/// One texel as linear RGBA; zero where x or y is NONE.
fn image_texel(texture: Texture, x: u32, y: u32) -> vec4<f32> {
    if (x == NONE || y == NONE) {
        return vec4<f32>(0.0);
    }
    let address = texel_address(texture, x, y);
    let words = load_texel(address.at);
    let word = words[address.word];
    switch texture.encoding {
        case ENCODING_SRGB8: {
            return vec4<f32>(srgb_byte(word & 255u), srgb_byte((word >> 8u) & 255u), srgb_byte((word >> 16u) & 255u),
                f32(word >> 24u) / 255.0);
        }
        case ENCODING_LINEAR8: { return unpack4x8unorm(word); }
        case ENCODING_LINEAR16: { return vec4<f32>(unpack2x16unorm(word), unpack2x16unorm(words[address.word + 1u])); }
        default: { return bitcast<vec4<f32>>(words); }
    }
}

/// A texture at a point of a surface, linear RGBA.
fn sample_texture(index: u32, uv0: vec2<f32>, uv1: vec2<f32>) -> vec4<f32> {
    let texture = load_texture(index);
    let uv = vec3<f32>(select(uv0, uv1, texture.uv_set == 1u), 1.0);
    let bilinear = texture.bilinear == 1u;
    let u = texel_span(dot(texture.row_u, uv), texture.width, texture.wrap_u, bilinear);
    let v = texel_span(dot(texture.row_v, uv), texture.height, texture.wrap_v, bilinear);
    if (!bilinear) {
        return image_texel(texture, u.first, v.first);
    }
    let top = mix(image_texel(texture, u.first, v.first), image_texel(texture, u.second, v.first), u.blend);
    let bottom = mix(image_texel(texture, u.first, v.second), image_texel(texture, u.second, v.second), u.blend);
    return mix(top, bottom, v.blend);
}
