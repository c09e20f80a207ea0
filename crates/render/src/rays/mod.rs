//! How many rays a second each traversal kernel traces over each hierarchy: `midway bench rays`.
//!
//! One level, everything solid: instances are laid out as copies, and what cut-outs cost is not
//! part of it. Every variant is given the same rays, and its hits are compared with the first one's.

mod batches;
mod generated;
mod measure;

use std::{sync::Arc, time::Duration};

use glam::Vec3;
use midway_accel::{BuildOptions, Bvh, WideBvh, build, build_wide};
use midway_device::{Device, DeviceKind};
use midway_kernels::constants as k;
use midway_scene::Scene;

use crate::RenderError;

pub use generated::{add_point_lights, generated_scene};
use measure::Bench;

/// Rays of each kind on a GPU, unless said: those of the yardstick that goals are in.
const GPU_RAYS: u32 = 1 << 24;
/// And on the CPU or a software GPU.
const CPU_RAYS: u32 = 1 << 18;

/// What to measure.
#[derive(Clone, Debug)]
pub struct RaysOptions {
    /// Rays of each kind; by the device where none.
    pub n_rays: Option<u32>,
    /// Runs measured after one to warm up; the median counts. At least 1.
    pub repeats: u32,
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
    is_wide: bool,
}

/// Every variant; the first is what others are compared with.
const VARIANTS: [Variant; 3] = [
    Variant { name: "while-while", closest: "bench_closest_binary", any: "bench_any_binary", is_wide: false },
    Variant {
        name: "speculative",
        closest: "bench_closest_speculative",
        any: "bench_any_speculative",
        is_wide: false,
    },
    Variant { name: "wide", closest: "bench_closest_wide", any: "bench_any_wide", is_wide: true },
];

/// What a ray asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The nearest hit.
    Closest,
    /// Whether there is any.
    Any,
}

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
    /// The device's own time, the median.
    pub time: Duration,
    /// Time of all threads together in the median run by CPU time, where the system says.
    pub cpu_time: Option<Duration>,
    /// Share of the rays that hit something.
    pub hit_share: f64,
    /// Rays whose answer is not the first variant's: another hit or none, or a distance that differs by over 10⁻⁴.
    pub n_different: usize,
}

impl RayReport {
    /// Millions of rays a second.
    pub fn mrays_per_second(&self) -> f64 {
        self.n_rays as f64 / self.time.as_secs_f64().max(1e-9) * 1e-6
    }

    /// Millions of rays a second of one thread's CPU time.
    pub fn mrays_per_cpu_second(&self) -> Option<f64> {
        self.cpu_time.map(|time| self.n_rays as f64 / time.as_secs_f64().max(1e-9) * 1e-6)
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
        let splits = if spatial_splits { "splits" } else { "plain" };
        for is_wide in [false, true] {
            let variants: Vec<&Variant> = VARIANTS.iter().filter(|v| v.is_wide == is_wide).collect();
            if !variants.iter().any(|v| bench.wants_any(v.name, splits)) {
                continue;
            }
            let hierarchy = Hierarchy::build(&triangles, &build_options, is_wide)?;
            tell_hierarchy(&hierarchy.report);
            bench.measure(&hierarchy, &variants, &mut tell)?;
        }
    }
    Ok(())
}

/// A hierarchy as kernels read it.
struct Hierarchy {
    nodes: Vec<[u32; 4]>,
    slots: Vec<[u32; 4]>,
    report: HierarchyReport,
}

impl Hierarchy {
    fn build(triangles: &[[Vec3; 3]], options: &BuildOptions, is_wide: bool) -> Result<Self, RenderError> {
        let report =
            |name, statistics: &midway_accel::Statistics, bytes, slots: usize, depth| HierarchyReport {
                name,
                spatial_splits: options.spatial_splits,
                build_time: statistics.build_time,
                bytes,
                nodes: statistics.inner_nodes,
                slots_per_triangle: slots as f64 / triangles.len() as f64,
                sah_cost: statistics.sah_cost,
                depth,
            };
        if is_wide {
            let WideBvh { nodes, primitives, max_depth, statistics, .. } = &build_wide(triangles, options)?;
            let bytes = size_of_val(nodes.as_slice()) + size_of_val(primitives.as_slice());
            return Ok(Self {
                nodes: nodes.iter().flat_map(|node| node.0).collect(),
                slots: pack_slots(triangles, primitives),
                report: report("wide", statistics, bytes, primitives.len(), *max_depth),
            });
        }
        let bvh: Bvh = build(triangles, options)?;
        let report =
            report("binary", &bvh.statistics, bvh.memory_bytes(), bvh.primitives.len(), bvh.max_depth);
        Ok(Self { slots: pack_slots(triangles, &bvh.primitives), nodes: bvh.nodes, report })
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
