//! Texel stores as textures: 16-byte texels in rows of [`TEXEL_COLUMNS`], layers of [`TEXEL_ROWS`] rows.

use wgsl_cpu::runtime::{TEXEL_BYTES, TEXEL_COLUMNS, TEXEL_ROWS};

/// A texel store's texture.
pub(super) struct Texels {
    texture: wgpu::Texture,
    pub(super) view: wgpu::TextureView,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// The largest store of an adapter, in bytes.
pub(super) fn max_bytes(limits: &wgpu::Limits) -> u64 {
    let columns_fit = limits.max_texture_dimension_2d >= TEXEL_COLUMNS.max(TEXEL_ROWS);
    let layer = u64::from(TEXEL_COLUMNS) * u64::from(TEXEL_ROWS) * u64::from(TEXEL_BYTES);
    if columns_fit { u64::from(limits.max_texture_array_layers) * layer } else { 0 }
}

impl Texels {
    /// Room for `bytes`, zeroed.
    pub(super) fn new(device: &wgpu::Device, label: &str, bytes: u64) -> Self {
        let n_texels = bytes.div_ceil(u64::from(TEXEL_BYTES));
        let n_rows = n_texels.div_ceil(u64::from(TEXEL_COLUMNS));
        let n_layers = n_rows.div_ceil(u64::from(TEXEL_ROWS));
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: TEXEL_COLUMNS,
                height: n_rows.min(u64::from(TEXEL_ROWS)) as u32,
                depth_or_array_layers: n_layers as u32,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { texture, view }
    }

    /// Hands whole texels to the queue, from byte `offset` up.
    pub(super) fn write(&self, queue: &wgpu::Queue, offset: u64, data: &[u8]) {
        let mut at = offset / u64::from(TEXEL_BYTES);
        let mut rest = data;
        while !rest.is_empty() {
            let block = Block::at(at, rest.len() as u64 / u64::from(TEXEL_BYTES));
            let (now, later) = rest.split_at(block.n_texels() as usize * TEXEL_BYTES as usize);
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.texture,
                    mip_level: 0,
                    origin: block.origin,
                    aspect: wgpu::TextureAspect::All,
                },
                now,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(block.size.width * TEXEL_BYTES),
                    rows_per_image: None,
                },
                block.size,
            );
            at += block.n_texels();
            rest = later;
        }
    }
}

/// A part of a run of texels that is a rectangle of one layer.
#[derive(Debug, PartialEq)]
struct Block {
    origin: wgpu::Origin3d,
    size: wgpu::Extent3d,
}

impl Block {
    /// The first rectangle of the `n` texels from `at` up: part of a row, or whole rows.
    fn at(at: u64, n: u64) -> Self {
        let columns = u64::from(TEXEL_COLUMNS);
        let rows = u64::from(TEXEL_ROWS);
        let (x, row) = (at % columns, at / columns);
        let (width, height) = if x > 0 || n < columns {
            (n.min(columns - x), 1)
        } else {
            (columns, (n / columns).min(rows - row % rows))
        };
        Self {
            origin: wgpu::Origin3d { x: x as u32, y: (row % rows) as u32, z: (row / rows) as u32 },
            size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
        }
    }

    fn n_texels(&self) -> u64 {
        u64::from(self.size.width) * u64::from(self.size.height)
    }
}

#[cfg(test)]
mod tests {
    use super::Block;

    /// Origins and sizes of the blocks of a run.
    fn blocks(mut at: u64, mut n: u64) -> Vec<([u32; 3], [u32; 2])> {
        let mut found = Vec::new();
        while n > 0 {
            let block = Block::at(at, n);
            let (origin, size) = (block.origin, block.size);
            found.push(([origin.x, origin.y, origin.z], [size.width, size.height]));
            at += block.n_texels();
            n -= block.n_texels();
        }
        found
    }

    #[test]
    fn runs_are_cut_at_rows_and_layers() {
        const LAYER: u64 = 4096 * 4096;
        assert_eq!(blocks(0, 5), [([0, 0, 0], [5, 1])]);
        assert_eq!(blocks(4090, 10), [([4090, 0, 0], [6, 1]), ([0, 1, 0], [4, 1])]);
        assert_eq!(blocks(8192, 3 * 4096), [([0, 2, 0], [4096, 3])]);
        let across = [([0, 4095, 0], [4096, 1]), ([0, 0, 1], [4096, 2]), ([0, 2, 1], [7, 1])];
        assert_eq!(blocks(LAYER - 4096, 3 * 4096 + 7), across);
    }
}
