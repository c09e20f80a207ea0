//! Running and timing kernels over rays.

use std::time::{Duration, Instant};

use midway_device::{Buffer, BufferUsage, Command, Device, DeviceKind};
use midway_kernels::constants as k;

use super::{Hierarchy, QUESTIONS, Question, RayReport, RaysOptions, Variant, batches::Batch, splits_name};
use crate::{
    RenderError,
    buffers::{BufferSet, Pipelines, dispatch},
};

/// A distance may differ by this much, relatively, between two variants.
const T_TOLERANCE: f32 = 1e-4;

/// A measured run lasts this long at least: the system counts CPU time a tick at a time, and a GPU
/// that is given a few milliseconds of work at a time is slow to raise its clocks.
const LEAST_RUN: Duration = Duration::from_millis(100);
/// Most dispatches of a run.
const MOST_DISPATCHES: f64 = 1e4;
/// Before rays are measured on a GPU all variants trace them in turn for this long, so that clocks and
/// caches are where they stay.
const GPU_WARM_UP: Duration = Duration::from_secs(1);

/// Rays and hierarchies on a device.
pub(super) struct Bench<'a> {
    device: &'a dyn Device,
    options: &'a RaysOptions,
    batches: Vec<OnDevice<'a>>,
    subjects: Vec<Subject>,
}

/// A variant over a hierarchy.
struct Subject {
    variant: &'static Variant,
    spatial_splits: bool,
    set: BufferSet,
    pipelines: Pipelines,
}

/// What a subject is measured by.
struct Trial<'s> {
    subject: &'s Subject,
    command: Command,
    /// Dispatches of a run.
    n_dispatches: usize,
    times: Vec<Duration>,
    cpu_times: Vec<Duration>,
}

struct OnDevice<'a> {
    batch: &'a Batch,
    rays: Buffer,
    hits: Buffer,
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
            Ok(OnDevice { batch, rays, hits })
        };
        let batches = batches.iter().map(upload).collect::<Result<_, _>>()?;
        Ok(Self { device, options, batches, subjects: Vec::new() })
    }

    /// Whether anything of a variant over a hierarchy is to be measured.
    pub fn wants_any(&self, variant: &str, spatial_splits: bool) -> bool {
        self.batches.iter().any(|batch| {
            QUESTIONS
                .into_iter()
                .any(|question| wants(&self.options.only, variant, spatial_splits, batch.batch, question))
        })
    }

    /// Copies a hierarchy to the device, to be traversed by variants.
    pub fn add(&mut self, hierarchy: &Hierarchy, variants: &[&'static Variant]) -> Result<(), RenderError> {
        let mut set = BufferSet::default();
        for (name, words) in [("nodes", &hierarchy.nodes), ("triangles", &hierarchy.slots)] {
            let bytes = size_of_val(words.as_slice()) as u64;
            let buffer = self.device.create_buffer(name, bytes, BufferUsage::Storage)?;
            self.device.write_buffer(&buffer, 0, bytemuck::cast_slice(words))?;
            set.insert(name, buffer);
        }
        let spatial_splits = hierarchy.report.spatial_splits;
        for &variant in variants {
            let pipelines = Pipelines::new(k::FEATURE_WIDE);
            self.subjects.push(Subject { variant, spatial_splits, set: set.clone(), pipelines });
        }
        Ok(())
    }

    /// Measures all that was added: of each kind of rays all variants in turn, again and again.
    pub fn measure(&self, tell: &mut impl FnMut(&RayReport)) -> Result<(), RenderError> {
        for batch in &self.batches {
            for question in QUESTIONS {
                let mut trials = self.trials(batch, question)?;
                self.warm_up(&mut trials)?;
                for _ in 0..self.options.rounds.max(1) {
                    trials.iter_mut().try_for_each(|trial| trial.run(self.device))?;
                }
                let mut expected = None;
                for trial in trials {
                    let answers = answers(self.device, batch, &trial)?;
                    let expected = expected.get_or_insert_with(|| answers.clone());
                    tell(&trial.report(batch, question, &answers, expected));
                }
            }
        }
        Ok(())
    }

    fn trials(&self, batch: &OnDevice<'_>, question: Question) -> Result<Vec<Trial<'_>>, RenderError> {
        let wanted = |subject: &&Subject| {
            wants(&self.options.only, subject.variant.name, subject.spatial_splits, batch.batch, question)
        };
        let trial = |subject: &'_ Subject| -> Result<Command, RenderError> {
            let mut set = subject.set.clone();
            set.insert("rays", batch.rays.clone());
            set.insert("hits", batch.hits.clone());
            let kernel = match question {
                Question::Closest => subject.variant.closest,
                Question::Any => subject.variant.any,
            };
            Ok(dispatch(&set.bind(self.device, &subject.pipelines, kernel)?, batch.n_rays()))
        };
        let all = self.subjects.iter().filter(wanted).map(|subject| {
            let command = trial(subject)?;
            Ok(Trial { subject, command, n_dispatches: 1, times: Vec::new(), cpu_times: Vec::new() })
        });
        all.collect()
    }

    /// Runs all in turn, and finds how many dispatches last long enough.
    fn warm_up(&self, trials: &mut [Trial<'_>]) -> Result<(), RenderError> {
        let length = match self.device.info().kind {
            DeviceKind::Gpu => GPU_WARM_UP,
            DeviceKind::Cpu | DeviceKind::SoftwareGpu => Duration::ZERO,
        };
        let start = Instant::now();
        loop {
            for trial in &mut *trials {
                let commands = vec![trial.command.clone(); trial.n_dispatches];
                let one = self.device.run(&commands, true)?.wall.as_secs_f64() / commands.len() as f64;
                let enough = (LEAST_RUN.as_secs_f64() / one.max(1e-9)).ceil();
                trial.n_dispatches = enough.clamp(1.0, MOST_DISPATCHES) as usize;
            }
            if trials.is_empty() || start.elapsed() >= length {
                return Ok(());
            }
        }
    }
}

impl Trial<'_> {
    /// A measured run.
    fn run(&mut self, device: &dyn Device) -> Result<(), RenderError> {
        let n = self.n_dispatches as u32;
        let commands = vec![self.command.clone(); self.n_dispatches];
        let before = process_time();
        let timing = device.run(&commands, true)?;
        self.times.push(timing.dispatches.iter().map(|&(_, time)| time).sum::<Duration>() / n);
        if let (Some(before), Some(after)) = (before, process_time()) {
            self.cpu_times.push(after.saturating_sub(before) / n);
        }
        Ok(())
    }

    fn report(
        mut self,
        batch: &OnDevice<'_>,
        question: Question,
        answers: &[[u32; 4]],
        expected: &[[u32; 4]],
    ) -> RayReport {
        self.times.sort_unstable();
        self.cpu_times.sort_unstable();
        let n_hits = answers.iter().filter(|hit| hit[3] != k::NONE).count();
        RayReport {
            variant: self.subject.variant.name,
            spatial_splits: self.subject.spatial_splits,
            rays: batch.batch.name.clone(),
            question,
            n_rays: batch.n_rays() as usize,
            cpu_time: self.cpu_times.get(self.cpu_times.len() / 2).copied(),
            hit_share: n_hits as f64 / answers.len().max(1) as f64,
            n_different: n_different(answers, expected),
            times: self.times,
        }
    }
}

/// Each word asked for has to be in one of the names, so that words narrow down what is measured.
fn wants(only: &[String], variant: &str, splits: bool, batch: &Batch, question: Question) -> bool {
    let names = [variant, splits_name(splits), &batch.name, question.name()];
    batch.question.is_none_or(|asked| asked == question)
        && only.iter().all(|word| names.iter().any(|name| name.contains(word.as_str())))
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

/// What a trial answers: distance, barycentric coordinates and triangle of each ray.
fn answers(
    device: &dyn Device,
    batch: &OnDevice<'_>,
    trial: &Trial<'_>,
) -> Result<Vec<[u32; 4]>, RenderError> {
    // None of another trial's answers stands in for one that is missing.
    let none = vec![[k::NONE; 4]; batch.hits.bytes() as usize / 16];
    device.write_buffer(&batch.hits, 0, bytemuck::cast_slice(&none))?;
    device.run(std::slice::from_ref(&trial.command), false)?;
    let bytes = device.read_buffer(&batch.hits, 0, batch.hits.bytes())?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// How many answers are not those expected.
fn n_different(answers: &[[u32; 4]], expected: &[[u32; 4]]) -> usize {
    let differs = |(a, b): &(&[u32; 4], &[u32; 4])| {
        let [t, t0] = [f32::from_bits(a[0]), f32::from_bits(b[0])];
        (a[3] == k::NONE) != (b[3] == k::NONE) || (a[3] != k::NONE && !agrees(t, t0))
    };
    answers.iter().zip(expected).filter(differs).count()
}

/// Whether two distances are the same but for rounding; NaN agrees with nothing.
fn agrees(t: f32, t0: f32) -> bool {
    (t - t0).abs() <= T_TOLERANCE * t0.abs()
}
