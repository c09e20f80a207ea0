// How images lie in the texel store, and what is between and beyond their texels. Nothing is read
// here: bindings/textures.wgsl does.

// Texture.encoding
/// Colour by the sRGB curve, a byte a channel; 2 x 2 texels in one of the store's.
const ENCODING_SRGB8: u32 = 0u;
/// Linear, laid out alike.
const ENCODING_LINEAR8: u32 = 1u;
/// Linear, 16 bits a channel; 2 x 1 texels in one of the store's.
const ENCODING_LINEAR16: u32 = 2u;
/// Floats.
const ENCODING_FLOAT: u32 = 3u;

// Texture.wrap_u, wrap_v
const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;
const WRAP_BLACK: u32 = 3u;

/// An image on a surface.
struct Texture {
    /// Its first texel in the store.
    at: u32,
    width: u32,
    height: u32,
    encoding: u32,
    wrap_u: u32,
    wrap_v: u32,
    /// 1: between texels' centres; 0: the nearest.
    bilinear: u32,
    /// Which texture coordinates, 0 or 1.
    uv_set: u32,
    /// Maps (u, v, 1) to the image, [0, 1]².
    row_u: vec3<f32>,
    row_v: vec3<f32>,
}

/// Where a texel lies: the store's texel, and the first of its words within.
struct TexelAddress {
    at: u32,
    word: u32,
}

/// The texels about a point along one axis: two, and how far it is from the first.
struct Span {
    first: u32,
    second: u32,
    blend: f32,
}

/// A coordinate in texels, brought near the image: what repeats is taken modulo its period first, so
/// that a coordinate of thousands keeps its fraction and none leaves the range of integers.
fn texel_coordinate(x: f32, size: u32, wrap: u32) -> f32 {
    var near = clamp(x, -1.0, 2.0);
    if (wrap == WRAP_REPEAT) {
        near = x - floor(x);
    } else if (wrap == WRAP_MIRROR) {
        near = x - 2.0 * floor(0.5 * x);
    }
    return near * f32(size);
}

/// The texel that the place i stands for, -size <= i <= 2 size; NONE where there is none.
fn wrap_texel(i: i32, size: u32, wrap: u32) -> u32 {
    let n = i32(size);
    if (i >= 0 && i < n) {
        return u32(i);
    }
    switch wrap {
        case WRAP_REPEAT: { return u32(select(i - n, i + n, i < 0)); }
        case WRAP_MIRROR: { return u32(clamp(select(2 * n - 1 - i, -1 - i, i < 0), 0, n - 1)); }
        case WRAP_CLAMP: { return u32(clamp(i, 0, n - 1)); }
        default: { return NONE; }
    }
}

/// The texels about a coordinate along one axis.
fn texel_span(x: f32, size: u32, wrap: u32, bilinear: bool) -> Span {
    let coordinate = texel_coordinate(x, size, wrap);
    if (!bilinear) {
        let nearest = wrap_texel(i32(floor(coordinate)), size, wrap);
        return Span(nearest, nearest, 0.0);
    }
    let low = floor(coordinate - 0.5);
    let first = i32(low);
    return Span(wrap_texel(first, size, wrap), wrap_texel(first + 1, size, wrap), coordinate - 0.5 - low);
}

/// Where a texel lies; of one that is not there, where the first of its row or column does.
fn texel_address(texture: Texture, x_or_none: u32, y_or_none: u32) -> TexelAddress {
    let x = select(x_or_none, 0u, x_or_none == NONE);
    let y = select(y_or_none, 0u, y_or_none == NONE);
    // A texel of the store's has 1, 2 x 1 or 2 x 2 of them.
    let halved = vec2<u32>(select(1u, 0u, texture.encoding == ENCODING_FLOAT),
        select(0u, 1u, texture.encoding == ENCODING_SRGB8 || texture.encoding == ENCODING_LINEAR8));
    let columns = (texture.width + halved.x) >> halved.x;
    let across = x & halved.x;
    let word = select(across * 2u, (y & 1u) * 2u + across, halved.y == 1u);
    return TexelAddress(texture.at + (y >> halved.y) * columns + (x >> halved.x), word);
}

/// What a place along an axis counts: nothing where there is no texel.
fn texel_share(place: u32) -> f32 {
    return select(1.0, 0.0, place == NONE);
}

/// A component that is known at run time alone; indexed so, a vector may be put into memory.
fn word_of(words: vec4<u32>, index: u32) -> u32 {
    let two = select(words.xy, words.zw, (index & 2u) != 0u);
    return select(two.x, two.y, (index & 1u) != 0u);
}
