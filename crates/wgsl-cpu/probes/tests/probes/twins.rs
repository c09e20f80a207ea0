//! Each probe natively and on a GPU: the same words, or floats as near as WGSL asks for. Any
//! adapter will do; without one the tests say that they did not run, which
//! `MIDWAY_REQUIRE_GPU=1` makes a failure.

use std::{env, sync::Arc};

use midway_device::{
    BufferUsage, Command, Device, DeviceError, DeviceKind, OpenOptions, list_devices, open_device,
};
use wgsl_cpu::BindingKind;
use wgsl_cpu_probes::cases::{self, Case, Tolerance};

#[test]
fn gpu_agrees_with_native() {
    let Some(gpu) = any_gpu() else { return };
    println!("on {}", gpu.info().name);
    let failures: Vec<String> = cases::all()
        .iter()
        .filter_map(|case| {
            let on_gpu =
                run(gpu.as_ref(), case).unwrap_or_else(|error| panic!("{}: {error}", case.kernel.name));
            first_difference(&case.run_native(), &on_gpu, case.tolerance)
                .map(|difference| format!("{}: {difference}", case.kernel.name))
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn cpu_device_agrees_with_native() {
    let cpu = open_device("cpu", &OpenOptions::default()).expect("the CPU is always there");
    for case in cases::all() {
        let on_device =
            run(cpu.as_ref(), &case).unwrap_or_else(|error| panic!("{}: {error}", case.kernel.name));
        let difference = first_difference(&case.run_native(), &on_device, Tolerance::Exact);
        assert!(difference.is_none(), "{}: {difference:?}", case.kernel.name);
    }
}

/// The comparison itself must fail where it should.
#[test]
fn comparison_finds_differences() {
    let one = 1.0f32.to_bits();
    let near = 1.000_000_1f32.to_bits();
    let far = 1.1f32.to_bits();
    let nan = f32::NAN.to_bits();
    assert!(first_difference(&[one], &[near], Tolerance::Float(1e-6)).is_none());
    assert!(first_difference(&[one], &[near], Tolerance::Exact).is_some());
    assert!(first_difference(&[one], &[far], Tolerance::Float(1e-3)).is_some());
    assert!(first_difference(&[one], &[nan], Tolerance::Float(1e-3)).is_some());
    assert!(first_difference(&[one, one], &[one], Tolerance::Float(1e-3)).is_some());
}

/// A GPU, real or not; `None`, said aloud, if there is none.
fn any_gpu() -> Option<Arc<dyn Device>> {
    let gpus = list_devices().into_iter().filter(|info| info.kind != DeviceKind::Cpu);
    let Some(info) = gpus.min_by_key(|info| info.kind == DeviceKind::SoftwareGpu) else {
        assert!(env::var("MIDWAY_REQUIRE_GPU").as_deref() != Ok("1"), "MIDWAY_REQUIRE_GPU=1 and no adapter");
        println!("NOT RUN: this machine has no GPU and no software GPU");
        return None;
    };
    Some(open_device(&info.name, &OpenOptions::default()).expect("a listed device opens"))
}

fn run(device: &dyn Device, case: &Case) -> Result<Vec<u32>, DeviceError> {
    let mut buffers = Vec::new();
    for (binding, words) in case.kernel.bindings.iter().zip(&case.buffers) {
        let usage = match binding.kind {
            BindingKind::Uniform => BufferUsage::Uniform,
            BindingKind::StorageRead | BindingKind::StorageReadWrite => BufferUsage::Storage,
            BindingKind::Texels => BufferUsage::Texels,
        };
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let buffer = device.create_buffer(binding.name, bytes.len() as u64, usage)?;
        device.write_buffer(&buffer, 0, &bytes)?;
        buffers.push(buffer);
    }
    let pipeline = device.load_kernel(case.kernel)?;
    let bound = device.bind(&pipeline, &buffers.iter().collect::<Vec<_>>())?;
    device.run(&[Command::Dispatch { bound, groups: [case.groups, 1, 1] }], false)?;
    let output = &buffers[case.output];
    let bytes = device.read_buffer(output, 0, output.bytes())?;
    Ok(bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect())
}

/// Where two results differ by more than is allowed.
fn first_difference(native: &[u32], other: &[u32], tolerance: Tolerance) -> Option<String> {
    if native.len() != other.len() {
        return Some(format!("{} words, not {}", other.len(), native.len()));
    }
    let is_same = |a: u32, b: u32| match tolerance {
        Tolerance::Exact => a == b,
        Tolerance::Float(tolerance) => {
            let (a_value, b_value) = (f32::from_bits(a), f32::from_bits(b));
            a == b || (a_value - b_value).abs() <= tolerance * a_value.abs().max(1.0)
        }
    };
    let at = (0..native.len()).find(|&i| !is_same(native[i], other[i]))?;
    let (a, b) = (native[at], other[at]);
    Some(format!("word {at}: {a:#x} ({}) natively, {b:#x} ({})", f32::from_bits(a), f32::from_bits(b)))
}
