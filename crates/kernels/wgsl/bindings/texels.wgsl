// The texel store: images, 16 bytes at a time. A texture, so that it is no storage buffer and may be
// larger than one may be.

@group(0) @binding(15) var texels: texture_2d_array<u32>;

/// Texels in a row of the store, and rows in a layer.
const TEXEL_COLUMNS: u32 = 4096u;
const TEXEL_ROWS: u32 = 4096u;

fn load_texel(at: u32) -> vec4<u32> {
    let row = at / TEXEL_COLUMNS;
    return textureLoad(texels, vec2<u32>(at % TEXEL_COLUMNS, row % TEXEL_ROWS), row / TEXEL_ROWS, 0);
}
