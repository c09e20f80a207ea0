//! Every kernel function on a GPU against the same function on the CPU device, by probes.

pub mod compare;
pub mod device;
mod instances;
mod surfaces;
mod traversal;

use bytemuck::cast_slice;
use compare::{Results, Tolerance, compare};
use midway_device::Device;
use midway_kernels::{KERNELS, constants::PROBE_STRIDE};
use midway_tests::estimate::{cpu, gpu};

use crate::support::Random;

/// Not a multiple of a workgroup.
const N: u32 = 20_011;
/// Words of an invocation's input, and of its output.
const STRIDE: usize = 4 * PROBE_STRIDE as usize;

/// Floats differ where a GPU's compiler contracts a multiplication and an addition into one
/// rounding, and by the 2.5 ulp that WGSL grants a division and the inverse square root of
/// `normalize`. A handful of such steps stays below this.
const ROUNDING: Tolerance = Tolerance::Float { relative: 1e-5, absolute: 2e-6, outliers: 0.0 };

/// The same, where a comparison of rounded numbers chooses a branch: which half of the disk, which
/// side of a surface, which lobe. That is within rounding of the edge about once in 10^5.
const BRANCHES: Tolerance = Tolerance::Float { relative: 1e-5, absolute: 5e-6, outliers: 5e-4 };

/// The adjoint factor divides by cosines: at one near 0.01, which about one direction in 100 has
/// towards either normal, it carries a hundred times their rounding. And so does the density of a
/// lobe of roughness 0.05 the rounding of its facet's normal.
const LOBES: Tolerance = Tolerance::Float { relative: 3e-4, absolute: 5e-6, outliers: 5e-3 };

/// Directions between two cells of an environment's map, and at its poles, where the longitude is
/// anything: about one in 10^4 is within rounding of either.
const CELLS: Tolerance = Tolerance::Float { relative: 2e-5, absolute: 2e-5, outliers: 1e-3 };

/// Each probe but those with modules of their own.
const PROBES: &[(&str, Tolerance)] = &[
    ("probe_random", Tolerance::Exact),
    ("probe_math", ROUNDING),
    ("probe_sampling", BRANCHES),
    ("probe_bsdf", LOBES),
    ("probe_mis", ROUNDING),
    ("probe_albedo", ROUNDING),
    ("probe_camera", CAMERA),
    ("probe_light", CELLS),
    ("probe_pixel_filter", FILTER),
    ("probe_dispersion", BRANCHES),
];

/// Film coordinates are to some hundreds of pixels, and their error is one of the whole film, or of
/// a point and a lens whose differences they are: some 1e-6 of 640 pixels.
const CAMERA: Tolerance = Tolerance::Float { relative: 1e-5, absolute: 1e-3, outliers: 0.0 };

/// Offsets in the last 1e-6 of the tails follow rounding; a splat may go to another pixel where its
/// number is within rounding of the edge between two.
const FILTER: Tolerance = Tolerance::Float { relative: 1e-5, absolute: 2e-5, outliers: 1e-3 };

/// Numbers over a few magnitudes, of both signs.
fn inputs(seed: u64) -> Vec<f32> {
    let mut random = Random::new(seed);
    (0..N as usize * STRIDE).map(|_| random.between(-4.0, 4.0) as f32).collect()
}

fn probe(device: &dyn Device, name: &str, inputs: &[f32]) -> Results {
    let zeros = vec![0u32; N as usize * STRIDE];
    let buffers: [(&str, &[u8]); 2] = [("probe_in", cast_slice(inputs)), ("probe_out", cast_slice(&zeros))];
    let mut outputs = device::run(device, name, &buffers, N);
    let words = outputs.remove("probe_out").expect("every probe writes probe_out");
    Results { device: device.info().name.clone(), words }
}

#[test]
fn every_probe_is_run() {
    for kernel in KERNELS.iter().filter(|kernel| kernel.name.starts_with("probe_")) {
        let listed = PROBES.iter().any(|(name, _)| *name == kernel.name);
        // Those have tests of their own.
        assert!(
            listed
                || [
                    "probe_traversal",
                    "probe_surface",
                    "probe_texture",
                    "probe_environment",
                    "probe_light_tree"
                ]
                .contains(&kernel.name),
            "{} is run by no test",
            kernel.name
        );
    }
}

#[test]
fn functions_agree_on_both_devices() {
    let Some(gpu) = gpu() else { return };
    println!("{} against {}", cpu().info().name, gpu.info().name);
    let differences: Vec<String> = (70..)
        .zip(PROBES)
        .filter_map(|(seed, (name, tolerance))| {
            let inputs = inputs(seed);
            let (a, b) = (probe(&*cpu(), name, &inputs), probe(&*gpu, name, &inputs));
            compare(&a, &b, STRIDE, *tolerance).err().map(|error| format!("{name}: {error}"))
        })
        .collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

/// One function's results are not another's: inputs do reach the probes, and outputs the comparison.
#[test]
fn other_inputs_give_other_results() {
    let Some(gpu) = gpu() else { return };
    for (name, tolerance) in PROBES.iter().filter(|(name, _)| *name != "probe_random") {
        let (a, b) = (probe(&*cpu(), name, &inputs(80)), probe(&*gpu, name, &inputs(81)));
        assert!(compare(&a, &b, STRIDE, *tolerance).is_err(), "{name} ignores its inputs");
    }
}
