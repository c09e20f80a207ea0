//! The scene on its device, and what was measured there.

use std::{
    collections::BTreeSet,
    sync::{Arc, atomic::AtomicBool},
};

use midway_device::{Buffer, BufferUsage, Device, DeviceError, MemoryPlan};
use midway_film::Image;
use midway_kernels::{constants as k, layout::Params};
use midway_scene::Camera;

use crate::{
    Crop, LightPaths, PackedScene, RenderError, RenderSettings,
    batch::{Lane, LaneSize, LaneUses},
    buffers::{BufferSet, Pipelines, load_all},
    pack::Packing,
    params::{base_params, join_factor},
    pool::POOL_KERNELS,
    sizes::{PILOT_PATHS, Sizes, plan_scene, plan_shared},
};

/// The seed of the pilot that measures L: fixed, so that L is the same for every seed.
const PILOT_SEED: u32 = 0x9170_7001;

/// What a change of settings starts from: the scene on its device, its film, and what was measured.
#[derive(Clone)]
pub(super) struct Kept {
    /// Without what was copied to the device.
    pub packed: PackedScene,
    pub scene_plan: MemoryPlan,
    pub pipelines: Pipelines,
    /// The scene's buffers, the film and the image.
    pub shared: BufferSet,
    /// Pixels that these two have room for.
    pub n_pixels: u32,
    /// Groups of lights that the film has room for.
    pub n_groups: u32,
    pub camera: Camera,
    /// L by what it depends on, the bound of path lengths.
    pub light_vertices: Vec<(Option<u32>, f32)>,
    /// Set from outside: the pass under way is not worth its end.
    pub stop: Arc<AtomicBool>,
    /// Whether somebody may set it.
    pub is_watched: bool,
}

impl Kept {
    /// The constants of a whole render, and L, which is measured where it is needed first.
    pub fn base_params(
        &mut self,
        device: &dyn Device,
        settings: &RenderSettings,
    ) -> Result<(Params, f32), RenderError> {
        let mut base = base_params(settings, &self.camera, &self.packed, n_light_paths(settings));
        base.n_groups = self.groups_of(settings);
        if settings.integrator.joins().is_none() {
            return Ok((base, 0.0));
        }
        let bound = settings.max_path_length;
        let measured = self.light_vertices.iter().find(|(of, _)| *of == bound).map(|&(_, mean)| mean);
        let mean = match measured {
            Some(mean) => mean,
            None => measure_light_vertices(device, &self.pipelines, &self.shared, &base)?,
        };
        if measured.is_none() {
            self.light_vertices.push((bound, mean));
        }
        base.join_factor = join_factor(settings, mean);
        Ok((base, mean))
    }

    /// Compiles what other settings need.
    pub fn load_kernels(
        &mut self,
        device: &dyn Device,
        settings: &RenderSettings,
    ) -> Result<(), RenderError> {
        let n_light_groups = self.packed.light_groups.len() as u32;
        self.pipelines = load_kernels(device, self.packed.features, n_light_groups, settings, &[])?;
        Ok(())
    }

    /// Working buffers with so many places for a path in flight at most.
    pub fn sizes(
        &self,
        device: &dyn Device,
        settings: &RenderSettings,
        mean_light_vertices: f32,
        most_places: u32,
    ) -> Result<Sizes, RenderError> {
        let shared = plan_shared(&self.scene_plan, settings, self.n_pixels, self.n_groups);
        let n_lanes = device.lanes() as u32;
        let n_light_paths = n_light_paths(settings);
        let info = device.info();
        Sizes::fit(info, settings, mean_light_vertices, n_light_paths, n_lanes, &shared, most_places)
    }
}

pub(super) fn n_pixels(settings: &RenderSettings) -> u32 {
    let window = settings.window();
    window.width * window.height
}

/// Light paths of a pass that joins draw from.
pub(super) fn n_light_paths(settings: &RenderSettings) -> u32 {
    match settings.integrator.light_paths {
        LightPaths::Pool(Some(n)) if settings.integrator.uses_pool() => n,
        _ => n_pixels(settings),
    }
}

/// Packs a scene and puts it on the device, if `check` finds room for it there: what is left of it on the
/// host, its memory and its buffers.
pub(super) fn put_on_device(
    device: &dyn Device,
    packing: Packing<'_>,
    camera: &Camera,
    check: impl FnOnce(&MemoryPlan) -> Result<(), DeviceError>,
) -> Result<(PackedScene, MemoryPlan, BufferSet), RenderError> {
    let mut packed = packing.finish(camera)?;
    let bytes = |words: &[[u32; 4]]| size_of_val(words) as u64;
    let [nodes, triangles, words] = [&packed.nodes, &packed.triangles, &packed.scene].map(|w| bytes(w));
    let plan = plan_scene([nodes, triangles, words, packed.images.bytes()]);
    check(&plan)?;
    let set = upload(device, &mut packed)?;
    Ok((packed.without_copied(), plan, set))
}

/// Hands the scene's words over to the device, and copies its images there.
fn upload(device: &dyn Device, packed: &mut PackedScene) -> Result<BufferSet, RenderError> {
    let mut set = BufferSet::default();
    let parts =
        [("nodes", &mut packed.nodes), ("triangles", &mut packed.triangles), ("scene", &mut packed.scene)];
    for (name, words) in parts {
        set.insert(name, upload_words(device, name, std::mem::take(words))?);
    }
    let texels = device.create_buffer("texels", packed.images.bytes(), BufferUsage::Texels)?;
    packed.images.upload(device, &texels)?;
    set.insert("texels", texels);
    Ok(set)
}

/// A buffer of a scene's words.
pub(super) fn upload_words(
    device: &dyn Device,
    name: &str,
    mut words: Vec<[u32; 4]>,
) -> Result<Buffer, RenderError> {
    if words.is_empty() {
        words.push([0; 4]); // a kernel's array has at least one element, even over an empty scene
    }
    Ok(device.create_buffer_of(name, words, BufferUsage::Storage)?)
}

/// Compiles what `settings` need, and what renders by `also` will, all at once, for a scene that has these
/// features and groups of lights. Those of `settings`.
pub(super) fn load_kernels(
    device: &dyn Device,
    features: u32,
    n_light_groups: u32,
    settings: &RenderSettings,
    also: &[RenderSettings],
) -> Result<Pipelines, RenderError> {
    let pipelines = |settings: &RenderSettings| {
        let apart = settings.light_groups && n_light_groups > 1;
        Pipelines::new(features | if apart { k::FEATURE_LIGHT_GROUPS } else { 0 })
    };
    let kernels = |settings: &RenderSettings| {
        let pool = settings.integrator.uses_pool().then_some(POOL_KERNELS).into_iter().flatten();
        LaneUses::of(settings).kernels().chain(pool).chain(["resolve"])
    };
    let all = also.iter().chain([settings]);
    let wanted: BTreeSet<_> =
        all.flat_map(|settings| kernels(settings).map(move |name| (pipelines(settings), name))).collect();
    load_all(device, &wanted)?;
    Ok(pipelines(settings))
}

/// Puts a film for each of `n_groups` and an image of `n_pixels` in place of those in the set.
pub(super) fn make_film(
    device: &dyn Device,
    set: &mut BufferSet,
    n_pixels: u32,
    n_groups: u32,
) -> Result<(), RenderError> {
    let film_bytes = u64::from(n_pixels) * u64::from(n_groups) * u64::from(k::FILM_STRIDE) * 4;
    let film = device.create_buffer("film", film_bytes, BufferUsage::Storage)?;
    set.insert("image", device.create_buffer("image", u64::from(n_pixels) * 16, BufferUsage::Storage)?);
    set.insert("film", film);
    Ok(())
}

/// The image of a window, from where `resolve` put it.
pub(super) fn read_image(device: &dyn Device, image: &Buffer, window: Crop) -> Result<Image, RenderError> {
    let bytes = device.read_buffer(image, 0, u64::from(window.width) * u64::from(window.height) * 16)?;
    let words: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
    Ok(Image {
        width: window.width as usize,
        height: window.height as usize,
        pixels: words.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
    })
}

/// L: the mean number of connectible vertices (s >= 2) of a light path, by a pilot of fixed seed.
fn measure_light_vertices(
    device: &dyn Device,
    pipelines: &Pipelines,
    shared: &BufferSet,
    base: &Params,
) -> Result<f32, RenderError> {
    let size = LaneSize {
        n_paths: PILOT_PATHS,
        n_places: PILOT_PATHS,
        n_shadow_rays: 1,
        append_at: 0,
        append_capacity: 0,
    };
    let lane = Lane::new(device, pipelines, shared, size, LaneUses::light_paths(), true)?;
    let params = Params {
        seed: PILOT_SEED,
        // Paths numbered from 0, whatever the film and its crop: L is then the same for all of them.
        crop_x: 0,
        crop_y: 0,
        crop_width: PILOT_PATHS,
        film_width: PILOT_PATHS,
        n_pixels: PILOT_PATHS,
        n_paths: PILOT_PATHS,
        n_places: PILOT_PATHS,
        n_light_paths: PILOT_PATHS,
        join: k::JOIN_FULL,
        flags: base.flags & !(k::FLAG_POOL | k::FLAG_SPLAT),
        emitter_survival: 1.0,
        ..*base
    };
    let n = lane.trace_light_paths(device, &params)?;
    // At least one vertex in the whole pilot, so that K / L stays finite.
    Ok(n.max(1) as f32 / PILOT_PATHS as f32)
}
