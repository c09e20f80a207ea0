//! Renderers of a scene that has changed, made on another thread while one of the scene as it was goes on.

use std::{mem::take, sync::Arc};

use midway_device::{Buffer, BufferUsage, Command, Device};
use midway_scene::{Scene, Surround};

use super::{
    Renderer,
    kept::{Kept, upload_words},
    live::check_fixed,
};
use crate::{
    RenderError, RenderSettings,
    sizes::{SCENE_BUFFERS, plan_scene},
};

/// Bytes that are copied on the device at once: it may keep those waiting who render meanwhile.
const COPIED_AT_ONCE: usize = 32 << 20;

/// What a renderer has on its device that others, of the same geometry, can share.
pub struct Basis {
    device: Arc<dyn Device>,
    kept: Kept,
    settings: RenderSettings,
}

impl Renderer {
    /// What renderers of the same geometry are made from, for a thread of its own: this renderer goes on
    /// meanwhile. They look through its camera, and are stopped as it is ([`Renderer::stop_when`]).
    pub fn basis(&self) -> Basis {
        Basis { device: Arc::clone(&self.device), kept: self.kept.clone(), settings: self.settings.clone() }
    }
}

impl Basis {
    /// A renderer of the scene with something else around it. Hierarchies, images and all words but those of
    /// what shines stay; so do compiled kernels, unless there was no environment or is none now, or lights
    /// are so many now that they are drawn by a tree. `scene` is the one that the basis' renderer was made
    /// with, whatever is around it by now.
    ///
    /// # Errors
    /// If `surround` or the settings are invalid, these ask for what [`Renderer::set_settings`] cannot
    /// change, or the device fails or is too small.
    pub fn surrounded(
        mut self,
        scene: &Scene,
        surround: &Surround,
        settings: RenderSettings,
    ) -> Result<Renderer, RenderError> {
        self.check(&settings)?;
        let mut packed = self.kept.packed.clone().surrounded(scene, surround, &settings)?;
        let (before, words) = (self.kept.shared.get("scene"), take(&mut packed.scene));
        let words = with_tail(&*self.device, before, packed.lights_at, &words)?;
        self.kept.shared.insert("scene", words);
        self.kept.packed = packed;
        self.build(settings)
    }

    /// A renderer of the scene with other materials on its meshes. Hierarchies and images stay, unless with
    /// the materials other triangles are opaque, or emit and were placed: then all is packed anew. `before`
    /// is the scene that the basis' renderer was made with, `scene` differs from it in
    /// [`midway_scene::Mesh::material`] alone, and has around it what that renderer has.
    ///
    /// # Errors
    /// As [`Basis::surrounded`].
    pub fn dressed(
        mut self,
        before: &Scene,
        scene: &Scene,
        settings: RenderSettings,
    ) -> Result<Renderer, RenderError> {
        self.check(&settings)?;
        let Some(mut packed) = self.kept.packed.dressed(before, scene, &self.kept.camera, &settings)? else {
            let mut renderer = Renderer::new(self.device, scene, &self.kept.camera, settings)?;
            renderer.stop_when(self.kept.stop);
            return Ok(renderer);
        };
        let words = take(&mut packed.scene);
        self.kept.shared.insert("scene", upload_words(&*self.device, "scene", words)?);
        self.kept.packed = packed.without_copied();
        self.build(settings)
    }

    fn check(&self, settings: &RenderSettings) -> Result<(), RenderError> {
        settings.validate()?;
        check_fixed(&self.settings, settings)
    }

    fn build(mut self, settings: RenderSettings) -> Result<Renderer, RenderError> {
        self.kept.scene_plan = plan_scene(SCENE_BUFFERS.map(|name| self.kept.shared.get(name).bytes()));
        self.kept.light_vertices.clear();
        Renderer::with_film(self.device, self.kept, settings)
    }
}

/// The words of a buffer up to the place `at`, and others behind them.
fn with_tail(
    device: &dyn Device,
    before: &Buffer,
    at: u32,
    tail: &[[u32; 4]],
) -> Result<Buffer, RenderError> {
    let (head, tail) = (u64::from(at) * 16, bytemuck::cast_slice::<_, u8>(tail));
    let buffer = device.create_buffer("scene", head + tail.len() as u64, BufferUsage::Storage)?;
    for offset in (0..head).step_by(COPIED_AT_ONCE) {
        let (from, to) = (before.clone(), buffer.clone());
        let bytes = (head - offset).min(COPIED_AT_ONCE as u64);
        let copy = Command::Copy { from, from_offset: offset, to, to_offset: offset, bytes };
        device.run(&[copy], false)?;
    }
    for (part, bytes) in (0..).zip(tail.chunks(COPIED_AT_ONCE)) {
        device.write_buffer(&buffer, head + part * COPIED_AT_ONCE as u64, bytes)?;
    }
    Ok(buffer)
}
