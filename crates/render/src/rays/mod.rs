//! How many rays a second each traversal kernel traces over each hierarchy: `midway bench rays`.
//!
//! One level, everything solid: instances are laid out as copies, and what cut-outs cost is not
//! part of it. Every variant is given the same rays, in turn with the others after a warm-up, and its
//! hits are compared with the first one's.

mod batches;
mod generated;
mod measure;

use std::{sync::Arc, time::Duration};

use glam::Vec3;
use midway_accel::{BuildOptions, Hierarchy as _, Level, Width};
use midway_device::{Device, DeviceKind};
use midway_kernels::constants as k;
use midway_scene::Scene;

use crate::{BounceRays, RenderError, world::hierarchy_of};

pub use generated::{add_lamps, add_point_lights, generated_scene};
use measure::Bench;

/// Rays of each kind on a GPU, unless said: those of the yardstick that goals are in.
const GPU_RAYS: u32 = 1 << 24;
/// And on the CPU or a software GPU.
const CPU_RAYS: u32 = 1 << 18;
/// Measured runs of a replay; the median counts.
const REPLAY_ROUNDS: u32 = 3;

/// What to measure.
#[derive(Clone, Debug)]
pub struct RaysOptions {
    /// Rays of each kind; by the device where none.
    pub n_rays: Option<u32>,
    /// Measured runs of each variant, all of them in turn, after a warm-up; the median counts. At least 1.
    pub rounds: u32,
    /// Only those whose variant, hierarchy, question or kind of rays contains one of these; all if empty.
    pub only: Vec<String>,
}

/// A kernel over a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name for people.
    pub name: &'static str,
    closest: &'static str,
    any: &'static str,
    width: Width,
}

/// Every variant; the first is what others are compared with.
const VARIANTS: [Variant; 4] = [
    Variant {
        name: "while-while",
        closest: "bench_closest_binary",
        any: "bench_any_binary",
        width: Width::Binary,
    },
    Variant {
        name: "speculative",
        closest: "bench_closest_speculative",
        any: "bench_any_speculative",
        width: Width::Binary,
    },
    Variant { name: "wide", closest: "bench_closest_wide", any: "bench_any_wide", width: Width::Wide },
    Variant {
        name: "refilled",
        closest: "bench_closest_refilled",
        any: "bench_any_refilled",
        width: Width::Wide,
    },
];

/// What a ray asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The nearest hit.
    Closest,
    /// Whether there is any.
    Any,
}

const QUESTIONS: [Question; 2] = [Question::Closest, Question::Any];

impl Question {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closest => "closest",
            Self::Any => "any",
        }
    }
}

/// A hierarchy that was measured.
#[derive(Clone, Debug)]
pub struct HierarchyReport {
    /// `binary` or `wide`.
    pub name: &'static str,
    /// Whether large triangles were split.
    pub spatial_splits: bool,
    /// How long it took to build.
    pub build_time: Duration,
    /// Its nodes and leaf slots, without triangles.
    pub bytes: usize,
    /// Nodes.
    pub nodes: usize,
    /// Leaf slots over triangles.
    pub slots_per_triangle: f64,
    /// Expected cost of a ray that meets the root's box, in its own nodes and triangles.
    pub sah_cost: f32,
    /// Levels.
    pub depth: usize,
}

/// One measurement.
#[derive(Clone, Debug)]
pub struct RayReport {
    /// The kernel.
    pub variant: &'static str,
    /// Whether its hierarchy's large triangles were split.
    pub spatial_splits: bool,
    /// Which rays.
    pub rays: String,
    /// What was asked.
    pub question: Question,
    /// How many.
    pub n_rays: usize,
    /// The device's own time of each run, the shortest first; at least one.
    pub times: Vec<Duration>,
    /// Time of all threads together, the median, where the system says.
    pub cpu_time: Option<Duration>,
    /// Share of the rays that hit something.
    pub hit_share: f64,
    /// Rays whose answer is not the first variant's: another hit or none, or a distance that differs by over 10⁻⁴.
    pub n_different: usize,
}

impl RayReport {
    /// Millions of rays a second, the median.
    pub fn mrays_per_second(&self) -> f64 {
        self.rate(self.times[self.times.len() / 2])
    }

    /// The slowest and the fastest run's.
    pub fn mrays_per_second_range(&self) -> [f64; 2] {
        [self.times[self.times.len() - 1], self.times[0]].map(|time| self.rate(time))
    }

    fn rate(&self, time: Duration) -> f64 {
        self.n_rays as f64 / time.as_secs_f64().max(1e-9) * 1e-6
    }

    /// Millions of rays a second of one thread's CPU time.
    pub fn mrays_per_cpu_second(&self) -> Option<f64> {
        self.cpu_time.map(|time| self.rate(time))
    }
}

/// Measures a scene on a device. `tell_hierarchy` and `tell` hear of each result as it comes.
///
/// # Errors
/// If the scene is invalid or empty, or the device fails.
pub fn bench_rays(
    device: &Arc<dyn Device>,
    scene: &Scene,
    options: &RaysOptions,
    mut tell_hierarchy: impl FnMut(&HierarchyReport),
    mut tell: impl FnMut(&RayReport),
) -> Result<(), RenderError> {
    scene.validate()?;
    let triangles = world_triangles(scene);
    if triangles.is_empty() {
        return Err(RenderError::Settings("the scene has no triangles to trace".to_owned()));
    }
    let n_rays = options.n_rays.unwrap_or(match device.info().kind {
        DeviceKind::Gpu => GPU_RAYS,
        DeviceKind::Cpu | DeviceKind::SoftwareGpu => CPU_RAYS,
    });
    let batches = batches::all(device, scene, n_rays)?;
    let mut bench = Bench::new(&**device, &batches, options)?;
    for spatial_splits in [false, true] {
        let build_options = BuildOptions { spatial_splits, ..BuildOptions::default() };
        for width in [Width::Binary, Width::Wide] {
            let is_wanted = |v: &&Variant| v.width == width && bench.wants_any(v.name, spatial_splits);
            let variants: Vec<&Variant> = VARIANTS.iter().filter(is_wanted).collect();
            if !variants.is_empty() {
                let hierarchy = Hierarchy::build(&triangles, &build_options, width)?;
                tell_hierarchy(&hierarchy.report);
                bench.add(&hierarchy, &variants)?;
            }
        }
    }
    bench.measure(&mut tell)
}

/// Rays of a render and how long it takes to trace them bare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Replay {
    /// How many there are, closest and shadow.
    pub n_rays: u64,
    /// The device's own time to trace them, each question's in one dispatch.
    pub time: Duration,
}

/// Traces rays that were recorded ([`crate::Renderer::record_rays`]) by nothing but the traversal that the
/// device renders by, over a hierarchy as it renders by; everything is solid and laid out.
///
/// # Errors
/// If the device fails, or has no room for them.
pub fn replay(
    device: &dyn Device,
    scene: &Scene,
    recorded: Vec<Vec<BounceRays>>,
) -> Result<Replay, RenderError> {
    let width = hierarchy_of(device.info().kind, scene);
    let options = RaysOptions { n_rays: None, rounds: REPLAY_ROUNDS, only: Vec::new() };
    let batches = batches::replayed(recorded);
    let hierarchy = Hierarchy::build(&world_triangles(scene), &BuildOptions::default(), width)?;
    let variant = VARIANTS.iter().find(|variant| variant.width == width).unwrap_or(&VARIANTS[0]);
    let mut bench = Bench::new(device, &batches, &options)?;
    bench.add(&hierarchy, &[variant])?;
    let mut sum = Replay { n_rays: 0, time: Duration::ZERO };
    bench.measure(&mut |report| {
        sum.n_rays += report.n_rays as u64;
        sum.time += report.times[report.times.len() / 2];
    })?;
    Ok(sum)
}

fn splits_name(spatial_splits: bool) -> &'static str {
    if spatial_splits { "splits" } else { "plain" }
}

/// A hierarchy as kernels read it.
struct Hierarchy {
    nodes: Vec<[u32; 4]>,
    slots: Vec<[u32; 4]>,
    report: HierarchyReport,
}

impl Hierarchy {
    fn build(triangles: &[[Vec3; 3]], options: &BuildOptions, width: Width) -> Result<Self, RenderError> {
        let level = Level::build(width, triangles, &[], options)?;
        let mut nodes = Vec::new();
        level.append_nodes(0, 0, &mut nodes);
        let statistics = level.statistics();
        let report = HierarchyReport {
            name: if width == Width::Wide { "wide" } else { "binary" },
            spatial_splits: options.spatial_splits,
            build_time: statistics.build_time,
            bytes: level.memory_bytes(),
            nodes: level.n_nodes(),
            slots_per_triangle: level.primitives().len() as f64 / triangles.len() as f64,
            sah_cost: statistics.sah_cost,
            depth: level.max_depth(),
        };
        Ok(Self { nodes, slots: pack_slots(triangles, level.primitives()), report })
    }
}

fn pack_slots(triangles: &[[Vec3; 3]], primitives: &[u32]) -> Vec<[u32; 4]> {
    let word4 = |v: Vec3, w: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w];
    let slot = |&index: &u32| {
        let [a, b, c] = triangles[index as usize];
        [word4(a, index), word4(b - a, k::SLOT_SOLID), word4(c - a, 0)]
    };
    primitives.iter().flat_map(slot).collect()
}

/// Every triangle in the world, instances laid out.
fn world_triangles(scene: &Scene) -> Vec<[Vec3; 3]> {
    let instances = 0..scene.instances.len() as u32;
    let placed = instances.map(|instance| scene.placed(instance));
    placed
        .flat_map(|mesh| (0..mesh.n_triangles()).map(move |t| mesh.positions(t)).collect::<Vec<_>>())
        .collect()
}
