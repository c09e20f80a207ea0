//! Groups of lights: the parts of the image that come from each, and their mixtures.

use std::sync::Arc;

use midway_device::{BoundKernel, Buffer, BufferUsage, Command, Device};
use midway_film::{Channel, Image};

use super::{Renderer, kept::Kept};
use crate::{
    RenderError, RenderSettings,
    buffers::{BufferSet, Pipelines, dispatch},
};

/// Components of a group's layer.
const COMPONENTS: [&str; 3] = ["R", "G", "B"];

/// What mixes groups; there where they are kept apart.
pub(super) struct Mixer {
    kernel: BoundKernel,
    /// A vec4 for each group.
    factors: Buffer,
}

impl Mixer {
    /// `set` holds the film, the image, and what `resolve` needs.
    pub(super) fn new(
        device: &dyn Device,
        pipelines: &Pipelines,
        mut set: BufferSet,
        n_groups: u32,
    ) -> Result<Self, RenderError> {
        let factors = device.create_buffer("group_mix", u64::from(n_groups) * 16, BufferUsage::Storage)?;
        set.insert("group_mix", factors.clone());
        Ok(Self { kernel: set.bind(device, pipelines, "mix_groups")?, factors })
    }

    /// What puts into the image the groups multiplied by `mix`; those that it lacks count in full.
    pub(super) fn command(
        &self,
        device: &dyn Device,
        mix: &[[f32; 3]],
        n_pixels: u32,
    ) -> Result<Command, RenderError> {
        let n = self.factors.bytes() as usize / 16;
        let factor = |group: usize| mix.get(group).map_or([1.0; 4], |&[r, g, b]| [r, g, b, 0.0]);
        let factors: Vec<[f32; 4]> = (0..n).map(factor).collect();
        device.write_buffer(&self.factors, 0, bytemuck::cast_slice(&factors))?;
        Ok(dispatch(&self.kernel, n_pixels))
    }
}

impl Kept {
    /// Films that `settings` ask for: one for each group of lights, or one.
    pub(super) fn groups_of(&self, settings: &RenderSettings) -> u32 {
        if settings.light_groups { self.packed.light_groups.len() as u32 } else { 1 }
    }
}

impl Renderer {
    /// The names of the groups that are kept apart ([`RenderSettings::light_groups`]); else none.
    pub fn light_groups(&self) -> &[Arc<str>] {
        if self.mixer.is_some() { &self.kept.packed.light_groups } else { &[] }
    }

    /// What [`Renderer::display`] shows: the light of each group multiplied by a factor a channel; empty
    /// for the image itself.
    pub fn set_mix(&mut self, mix: &[[f32; 3]]) {
        self.shown_mix = mix.to_vec();
    }

    /// What puts the image into its buffer as it is to be shown.
    pub(super) fn resolve_shown(&self) -> Result<Command, RenderError> {
        match &self.mixer {
            Some(mixer) if !self.shown_mix.is_empty() => {
                mixer.command(&*self.device, &self.shown_mix, self.base.n_pixels)
            }
            _ => Ok(dispatch(&self.resolve, self.base.n_pixels)),
        }
    }

    /// The image so far with the light of each group multiplied by a factor a channel; groups that
    /// `mix` lacks count in full, all of them where they are not kept apart.
    ///
    /// # Errors
    /// If the device fails.
    pub fn mixed_image(&self, mix: &[[f32; 3]]) -> Result<Image, RenderError> {
        let Some(mixer) = self.mixer.as_ref().filter(|_| self.pass.is_none()) else { return self.image() };
        self.write_resolve_params()?;
        self.device.run(&[mixer.command(&*self.device, mix, self.base.n_pixels)?], false)?;
        self.read_image()
    }

    /// A layer for each group, named as Cycles names them: what its lights alone would show.
    ///
    /// # Errors
    /// If the device fails.
    pub fn group_channels(&self) -> Result<Vec<Channel>, RenderError> {
        let mut channels = Vec::new();
        let groups = self.light_groups();
        for (group, name) in groups.iter().enumerate() {
            let mix: Vec<[f32; 3]> = (0..groups.len()).map(|g| [f32::from(g == group); 3]).collect();
            let image = self.mixed_image(&mix)?;
            channels.extend(COMPONENTS.iter().enumerate().map(|(place, component)| Channel {
                name: format!("Combined_{name}.{component}"),
                samples: image.pixels.iter().map(|pixel| pixel[place]).collect(),
            }));
        }
        Ok(channels)
    }
}
