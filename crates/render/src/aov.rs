//! Layers besides the beauty: what camera rays hit first, how sure each pixel is, and of how many
//! samples. They are measured beside any integrator and change no sample of it.

use midway_device::{BoundKernel, Buffer, BufferUsage, Command, Device, MemoryPlan};
use midway_film::Channel;
use midway_kernels::{constants as k, layout::Params};
use rayon::prelude::*;

use crate::{
    RenderError, RenderSettings,
    batch::{LaneTotals, read_totals},
    buffers::{BufferSet, Pipelines, dispatch},
};

/// Samples of a pixel whose first hits are averaged: those after them would add little and cost a ray.
const FIRST_HIT_SAMPLES: u64 = 256;
/// Pixels of one dispatch, so that a desktop's watchdog never fires.
const PIXELS_PER_DISPATCH: u32 = 1 << 20;
/// Depth where no sample hits anything, as Cycles writes it.
const NO_DEPTH: f32 = 1e10;

/// A pixel's sums of first hits (`aov_sums` in WGSL).
type HitSums = [[f32; 4]; k::AOV_STRIDE as usize];
/// A pixel's words of `moments`; those that are floats are read.
type Moments = [f32; k::MOMENTS_STRIDE as usize];

/// A layer of an image's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// The share of light that the first surface gives back.
    Albedo,
    /// Its shading normal, in the world, on the camera's side.
    Normal,
    /// Its distance along the view direction; 10¹⁰ where there is nothing.
    Depth,
    /// Its place in the world; 0 where there is nothing.
    Position,
    /// Of each pixel of the beauty: the square of its standard error, by the spread between passes.
    Variance,
    /// Samples of each pixel.
    Samples,
}

impl Aov {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Albedo, Self::Normal, Self::Depth, Self::Position, Self::Variance, Self::Samples];

    /// The name of its layer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Variance => "variance",
            Self::Samples => "samples",
        }
    }

    /// The names of its channels.
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Variance => &["R", "G", "B"],
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Samples => &["Y"],
        }
    }

    fn is_of_first_hits(self) -> bool {
        matches!(self, Self::Albedo | Self::Normal | Self::Depth | Self::Position)
    }
}

/// A kernel and the buffer that it adds to.
struct Sums {
    kernel: BoundKernel,
    buffer: Buffer,
}

/// What measures the layers asked for.
pub struct Aovs {
    asked: Vec<Aov>,
    params: Buffer,
    counters: Buffer,
    first_hits: Option<Sums>,
    moments: Option<Sums>,
    n_passes: u64,
}

/// Whether the layers asked for need (first hits, moments).
fn needs(asked: &[Aov]) -> (bool, bool) {
    (asked.iter().any(|aov| aov.is_of_first_hits()), asked.contains(&Aov::Variance))
}

/// Adds the layers' sums to a plan.
pub fn plan(settings: &RenderSettings, n_pixels: u32, plan: &mut MemoryPlan) {
    let (first_hits, moments) = needs(&settings.aovs);
    if first_hits {
        plan.fixed("first hits", u64::from(n_pixels) * size_of::<HitSums>() as u64);
    }
    if moments {
        plan.fixed("moments", u64::from(n_pixels) * size_of::<Moments>() as u64);
    }
}

impl Aovs {
    /// Allocates what the layers in `asked` need. `shared` holds the scene and the film.
    pub fn new(
        device: &dyn Device,
        pipelines: &Pipelines,
        shared: &BufferSet,
        asked: &[Aov],
        n_pixels: u32,
    ) -> Result<Self, RenderError> {
        let mut set = shared.clone();
        let mut add = |name: &'static str, bytes: u64, usage| -> Result<Buffer, RenderError> {
            let buffer = device.create_buffer(name, bytes, usage)?;
            set.insert(name, buffer.clone());
            Ok(buffer)
        };
        let params = add("params", size_of::<Params>() as u64, BufferUsage::Uniform)?;
        let counters = add("counters", u64::from(k::N_COUNTERS) * 4, BufferUsage::Storage)?;
        let (first_hits, moments) = needs(asked);
        let mut sums = |needed: bool, name, bytes: usize| {
            needed.then(|| add(name, u64::from(n_pixels) * bytes as u64, BufferUsage::Storage)).transpose()
        };
        let hit_sums = sums(first_hits, "aov_sums", size_of::<HitSums>())?;
        let moment_sums = sums(moments, "moments", size_of::<Moments>())?;
        let bind = |buffer: Option<Buffer>, name| -> Result<Option<Sums>, RenderError> {
            buffer.map(|buffer| Ok(Sums { kernel: set.bind(device, pipelines, name)?, buffer })).transpose()
        };
        let first_hits = bind(hit_sums, "trace_aov")?;
        let moments = bind(moment_sums, "measure_variance")?;
        Ok(Self { asked: asked.to_vec(), params, counters, first_hits, moments, n_passes: 0 })
    }

    /// The largest pass after `samples`: where variance is measured, passes are many, and grow only
    /// as their number does.
    pub fn largest_pass(&self, samples: u64) -> u64 {
        if self.moments.is_some() { (samples / 8).max(1) } else { u64::MAX }
    }

    /// Measures a pass of `n_samples`, which is on the film; `params.first_sample` were done before.
    pub fn measure(
        &mut self,
        device: &dyn Device,
        params: &Params,
        n_samples: u32,
    ) -> Result<(), RenderError> {
        self.n_passes += 1;
        if let Some(moments) = &self.moments {
            let pass = Params { pass_samples: n_samples, ..*params };
            device.write_buffer(&self.params, 0, bytemuck::bytes_of(&pass))?;
            device.run(&[dispatch(&moments.kernel, params.n_pixels)], false)?;
        }
        let Some(first_hits) = &self.first_hits else { return Ok(()) };
        let end = u64::from(params.first_sample) + u64::from(n_samples);
        for sample in params.first_sample..end.min(FIRST_HIT_SAMPLES) as u32 {
            for first_path in (0..params.n_pixels).step_by(PIXELS_PER_DISPATCH as usize) {
                let n_paths = PIXELS_PER_DISPATCH.min(params.n_pixels - first_path);
                let part = Params { first_sample: sample, first_path, n_paths, ..*params };
                device.write_buffer(&self.params, 0, bytemuck::bytes_of(&part))?;
                device.run(&[dispatch(&first_hits.kernel, n_paths)], false)?;
            }
        }
        Ok(())
    }

    /// What its rays have counted.
    pub fn totals(&self, device: &dyn Device) -> Result<LaneTotals, RenderError> {
        read_totals(device, &self.counters)
    }

    /// Forgets all samples.
    pub fn restart(&mut self, device: &dyn Device) -> Result<(), RenderError> {
        self.n_passes = 0;
        for sums in [&self.first_hits, &self.moments].into_iter().flatten() {
            device.run(&[Command::Clear(sums.buffer.clone())], false)?;
        }
        Ok(())
    }

    /// The channels of the layers asked for, after `samples` of every pixel.
    pub fn channels(
        &self,
        device: &dyn Device,
        samples: u64,
        n_pixels: u32,
    ) -> Result<Vec<Channel>, RenderError> {
        let hits: Vec<HitSums> = read(device, self.first_hits.as_ref())?;
        let moments: Vec<Moments> = read(device, self.moments.as_ref())?;
        let channel = |(aov, place): (Aov, usize)| {
            let value = |pixel: usize| match aov {
                Aov::Samples => samples as f32,
                Aov::Variance => self.variance_of_mean(moments[pixel][3 * place + 2], samples),
                Aov::Albedo | Aov::Normal | Aov::Depth | Aov::Position => {
                    mean_of_hits(&hits[pixel], aov, place, samples.clamp(1, FIRST_HIT_SAMPLES))
                }
            };
            Channel {
                name: format!("{}.{}", aov.name(), aov.components()[place]),
                samples: (0..n_pixels as usize).into_par_iter().map(value).collect(),
            }
        };
        let of_layer = |&aov: &Aov| (0..aov.components().len()).map(move |place| (aov, place));
        Ok(self.asked.iter().flat_map(of_layer).map(channel).collect())
    }

    /// Of a pixel's mean, from its squared deviations; infinite after one pass, which has no spread.
    fn variance_of_mean(&self, squares: f32, samples: u64) -> f32 {
        if self.n_passes < 2 {
            return f32::INFINITY;
        }
        (f64::from(squares) / (self.n_passes - 1) as f64 / samples as f64) as f32
    }
}

fn read<T: bytemuck::Pod>(device: &dyn Device, sums: Option<&Sums>) -> Result<Vec<T>, RenderError> {
    let Some(Sums { buffer, .. }) = sums else { return Ok(Vec::new()) };
    Ok(bytemuck::pod_collect_to_vec(&device.read_buffer(buffer, 0, buffer.bytes())?))
}

/// A component of a layer, from the sums of `samples` samples. Depth and position are means over the
/// samples that hit something.
fn mean_of_hits([first, second, third]: &HitSums, aov: Aov, place: usize, samples: u64) -> f32 {
    let (samples, hits) = (samples as f32, first[3]);
    match aov {
        Aov::Albedo => first[place] / samples,
        Aov::Normal => second[place] / samples,
        Aov::Depth if hits > 0.0 => second[3] / hits,
        Aov::Depth => NO_DEPTH,
        _ => third[place] / hits.max(1.0),
    }
}
