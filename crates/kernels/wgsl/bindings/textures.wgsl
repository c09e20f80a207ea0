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

/// A texel of the store's as linear RGBA.
fn texel_rgba(encoding: u32, words: vec4<u32>, word: u32) -> vec4<f32> {
    if (encoding == ENCODING_FLOAT) {
        return bitcast<vec4<f32>>(words);
    }
    if (encoding == ENCODING_LINEAR16) {
        let both = select(words.xy, words.zw, word != 0u);
        return vec4<f32>(unpack2x16unorm(both.x), unpack2x16unorm(both.y));
    }
    let bytes = word_of(words, word);
    if (encoding == ENCODING_LINEAR8) {
        return unpack4x8unorm(bytes);
    }
    return vec4<f32>(srgb_byte(bytes & 255u), srgb_byte((bytes >> 8u) & 255u), srgb_byte((bytes >> 16u) & 255u),
        f32(bytes >> 24u) / 255.0);
}

/// A texture at a point of a surface, linear RGBA. Its four texels are asked for before any is looked at: none
/// waits for another.
fn sample_texture(index: u32, uv0: vec2<f32>, uv1: vec2<f32>) -> vec4<f32> {
    let texture = load_texture(index);
    let uv = vec3<f32>(select(uv0, uv1, texture.uv_set == 1u), 1.0);
    let bilinear = texture.bilinear == 1u;
    let u = texel_span(dot(texture.row_u, uv), texture.width, texture.wrap_u, bilinear);
    let v = texel_span(dot(texture.row_v, uv), texture.height, texture.wrap_v, bilinear);
    let a = texel_address(texture, u.first, v.first);
    let b = texel_address(texture, u.second, v.first);
    let c = texel_address(texture, u.first, v.second);
    let d = texel_address(texture, u.second, v.second);
    let words_a = load_texel(a.at);
    let words_b = load_texel(b.at);
    let words_c = load_texel(c.at);
    let words_d = load_texel(d.at);
    let first = texel_share(v.first) * mix(texel_share(u.first) * texel_rgba(texture.encoding, words_a, a.word),
        texel_share(u.second) * texel_rgba(texture.encoding, words_b, b.word), u.blend);
    let second = texel_share(v.second) * mix(texel_share(u.first) * texel_rgba(texture.encoding, words_c, c.word),
        texel_share(u.second) * texel_rgba(texture.encoding, words_d, d.word), u.blend);
    return mix(first, second, v.blend);
}
