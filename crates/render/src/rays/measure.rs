//! Running and timing kernels over rays.

use std::time::Duration;

use midway_device::{Buffer, BufferUsage, Command, Device, DeviceKind};
use midway_kernels::constants as k;

use super::{Hierarchy, Question, RayReport, RaysOptions, Variant, batches::Batch};
use crate::{
    RenderError,
    buffers::{BufferSet, Pipelines, dispatch},
};

/// A distance may differ by this much, relatively, between two variants.
const T_TOLERANCE: f32 = 1e-4;

/// A measured run on the CPU lasts this long at least.
const CPU_RUN: Duration = Duration::from_millis(200);

/// The rays on a device, and what the first variant said of them.
pub(super) struct Bench<'a> {
    device: &'a dyn Device,
    options: &'a RaysOptions,
    batches: Vec<OnDevice<'a>>,
}

struct OnDevice<'a> {
    batch: &'a Batch,
    rays: Buffer,
    hits: Buffer,
    /// Distance and triangle of each ray by the first variant: closest, any.
    expected: [Option<Vec<[u32; 4]>>; 2],
}

impl OnDevice<'_> {
    fn n_rays(&self) -> u32 {
        self.batch.rays.len() as u32 / k::BENCH_RAY_STRIDE
    }
}

impl<'a> Bench<'a> {
    pub fn new(
        device: &'a dyn Device,
        batches: &'a [Batch],
        options: &'a RaysOptions,
    ) -> Result<Self, RenderError> {
        let upload = |batch: &'a Batch| -> Result<OnDevice<'a>, RenderError> {
            let rays = device.create_buffer(
                "rays",
                size_of_val(batch.rays.as_slice()) as u64,
                BufferUsage::Storage,
            )?;
            device.write_buffer(&rays, 0, bytemuck::cast_slice(&batch.rays))?;
            let bytes = batch.rays.len() as u64 / u64::from(k::BENCH_RAY_STRIDE) * 16;
            let hits = device.create_buffer("hits", bytes, BufferUsage::Storage)?;
            Ok(OnDevice { batch, rays, hits, expected: [None, None] })
        };
        let batches = batches.iter().map(upload).collect::<Result<_, _>>()?;
        Ok(Self { device, options, batches })
    }

    /// Whether anything of a variant over a hierarchy is to be measured.
    pub fn wants_any(&self, variant: &str, splits: &str) -> bool {
        self.batches.iter().any(|batch| {
            [Question::Closest, Question::Any]
                .into_iter()
                .any(|question| wants(&self.options.only, variant, splits, batch.batch, question))
        })
    }

    /// Measures variants over a hierarchy.
    pub fn measure(
        &mut self,
        hierarchy: &Hierarchy,
        variants: &[&Variant],
        tell: &mut impl FnMut(&RayReport),
    ) -> Result<(), RenderError> {
        let device = self.device;
        let mut set = BufferSet::default();
        for (name, words) in [("nodes", &hierarchy.nodes), ("triangles", &hierarchy.slots)] {
            let buffer =
                device.create_buffer(name, size_of_val(words.as_slice()) as u64, BufferUsage::Storage)?;
            device.write_buffer(&buffer, 0, bytemuck::cast_slice(words))?;
            set.insert(name, buffer);
        }
        let spatial_splits = hierarchy.report.spatial_splits;
        let splits = if spatial_splits { "splits" } else { "plain" };
        for variant in variants {
            let pipelines = Pipelines::load(device, u32::MAX, &[variant.closest, variant.any])?;
            for batch in &mut self.batches {
                set.insert("rays", batch.rays.clone());
                set.insert("hits", batch.hits.clone());
                for (kernel, question) in [(variant.closest, Question::Closest), (variant.any, Question::Any)]
                {
                    if !wants(&self.options.only, variant.name, splits, batch.batch, question) {
                        continue;
                    }
                    let command = dispatch(&set.bind(device, &pipelines, kernel)?, batch.n_rays());
                    let (time, cpu_time) = time(device, &command, self.options.repeats)?;
                    let (hit_share, n_different) = compare(device, batch, question)?;
                    tell(&RayReport {
                        variant: variant.name,
                        spatial_splits,
                        rays: batch.batch.name.clone(),
                        question,
                        n_rays: batch.n_rays() as usize,
                        time,
                        cpu_time,
                        hit_share,
                        n_different,
                    });
                }
            }
        }
        Ok(())
    }
}

/// Each word asked for has to be in one of the names, so that words narrow down what is measured.
fn wants(only: &[String], variant: &str, splits: &str, batch: &Batch, question: Question) -> bool {
    let names = [variant, splits, &batch.name, question.name()];
    batch.question.is_none_or(|asked| asked == question)
        && only.iter().all(|word| names.iter().any(|name| name.contains(word.as_str())))
}

/// The median of several runs after one to warm up, by the device's clock and by CPU time.
fn time(
    device: &dyn Device,
    command: &Command,
    repeats: u32,
) -> Result<(Duration, Option<Duration>), RenderError> {
    let first = device.run(std::slice::from_ref(command), true)?;
    // The system counts CPU time a tick at a time.
    let n_runs = match device.info().kind {
        DeviceKind::Cpu => {
            (CPU_RUN.as_secs_f64() / first.wall.as_secs_f64().max(1e-6)).ceil().min(1e4) as u32
        }
        DeviceKind::Gpu | DeviceKind::SoftwareGpu => 1,
    };
    let commands = vec![command.clone(); n_runs as usize];
    let (mut times, mut cpu_times) = (Vec::new(), Vec::new());
    for _ in 0..repeats.max(1) {
        let before = process_time();
        let timing = device.run(&commands, true)?;
        times.push(timing.dispatches.iter().map(|&(_, time)| time).sum::<Duration>() / n_runs);
        if let (Some(before), Some(after)) = (before, process_time()) {
            cpu_times.push(after.saturating_sub(before) / n_runs);
        }
    }
    Ok((median(times).unwrap_or_default(), median(cpu_times)))
}

fn median(mut times: Vec<Duration>) -> Option<Duration> {
    times.sort_unstable();
    times.get(times.len() / 2).copied()
}

/// CPU time of this process so far, user and system, where the system says (Linux).
fn process_time() -> Option<Duration> {
    // Nanoseconds that each thread has run, first on its line.
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let nanoseconds = tasks.map_while(Result::ok).filter_map(|task| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    });
    Some(Duration::from_nanos(nanoseconds.sum())).filter(|time| !time.is_zero())
}

/// The share of rays that hit, and how many answers are not the first variant's.
fn compare(
    device: &dyn Device,
    batch: &mut OnDevice<'_>,
    question: Question,
) -> Result<(f64, usize), RenderError> {
    let bytes = device.read_buffer(&batch.hits, 0, batch.hits.bytes())?;
    let hits: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
    let n_hits = hits.iter().filter(|hit| hit[3] != k::NONE).count();
    let expected = batch.expected[question as usize].get_or_insert_with(|| hits.clone());
    let differs = |(a, b): &(&[u32; 4], &[u32; 4])| {
        let [t, t0] = [f32::from_bits(a[0]), f32::from_bits(b[0])];
        (a[3] == k::NONE) != (b[3] == k::NONE) || (a[3] != k::NONE && !agrees(t, t0))
    };
    let n_different = hits.iter().zip(expected.iter()).filter(differs).count();
    Ok((n_hits as f64 / hits.len().max(1) as f64, n_different))
}

/// Whether two distances are the same but for rounding; NaN agrees with nothing.
fn agrees(t: f32, t0: f32) -> bool {
    (t - t0).abs() <= T_TOLERANCE * t0.abs()
}
