//! The image as a display shows it, tone-mapped on the device.

use midway_device::{BoundKernel, Buffer, BufferUsage};
use midway_film::{Display, ToneMap};
use midway_kernels::{constants as k, layout::Params};

use super::Renderer;
use crate::{RenderError, buffers::dispatch};

/// What encodes for a display; made when first asked for.
pub(super) struct Encoder {
    kernel: BoundKernel,
    pixels: Buffer,
}

impl Renderer {
    /// The image so far as [`Display::encode_u8`] shows it: four bytes a pixel, R, G, B and 255, row by
    /// row from the top left of the rendered window. With the mix of
    /// [`Renderer::set_mix`].
    ///
    /// # Errors
    /// If the device fails.
    pub fn display(&mut self, display: Display) -> Result<Vec<u8>, RenderError> {
        if self.encoder.is_none() {
            self.encoder = Some(self.make_encoder()?);
        }
        let Some(encoder) = &self.encoder else { return Ok(Vec::new()) };
        let params = Params {
            first_sample: self.samples as u32,
            exposure_scale: display.exposure.exp2(),
            tone_map: match display.tone_map {
                ToneMap::Linear => k::TONE_MAP_LINEAR,
                ToneMap::Agx => k::TONE_MAP_AGX,
                ToneMap::Aces => k::TONE_MAP_ACES,
                ToneMap::PbrNeutral => k::TONE_MAP_PBR_NEUTRAL,
            },
            ..self.base
        };
        self.device.write_buffer(&self.resolve_params, 0, bytemuck::bytes_of(&params))?;
        let n = params.n_pixels;
        let resolve = if self.pass.is_none() { Some(self.resolve_shown()?) } else { None };
        let commands: Vec<_> = resolve.into_iter().chain([dispatch(&encoder.kernel, n)]).collect();
        self.device.run(&commands, false)?;
        Ok(self.device.read_buffer(&encoder.pixels, 0, u64::from(n) * 4)?)
    }

    fn make_encoder(&mut self) -> Result<Encoder, RenderError> {
        let device = &*self.device;
        let bytes = u64::from(self.kept.n_pixels) * 4;
        let pixels = device.create_buffer("display", bytes, BufferUsage::Storage)?;
        let mut set = self.kept.shared.clone();
        set.insert("params", self.resolve_params.clone());
        set.insert("display", pixels.clone());
        Ok(Encoder { kernel: set.bind(device, &self.kept.pipelines, "encode_display")?, pixels })
    }
}
