//! Which device a name opens, and what a GPU refuses.

use std::fs;

use midway_device::{
    Binding, BindingKind, BufferUsage, DeviceError, DeviceKind, Kernel, OpenOptions, list_devices,
    open_device,
};
use wgsl_cpu::{Invocations, Storage};

use crate::common::{self, STEP, dispatch, words, zeros};

fn names() -> Vec<String> {
    list_devices().into_iter().map(|info| info.name).collect()
}

#[test]
fn the_cpu_is_always_there() {
    assert!(names().contains(&"cpu".into()));
    for name in ["cpu", "CPU"] {
        let cpu = open_device(name, &OpenOptions { threads: Some(3), ..Default::default() }).expect("opens");
        assert_eq!((cpu.info().kind, cpu.info().backend.as_str()), (DeviceKind::Cpu, "native, 3 threads"));
    }
}

#[test]
fn an_unknown_name_lists_what_there_is() {
    let error = open_device("voodoo 2", &OpenOptions::default()).err().expect("there is none");
    assert_eq!(error, DeviceError::UnknownDevice { asked: "voodoo 2".into(), available: names() });
    assert!(error.to_string().contains("this machine has: ") && error.to_string().contains("cpu"));
}

#[test]
fn auto_and_gpu_never_take_a_software_gpu() {
    let real = list_devices().into_iter().find(|info| info.kind == DeviceKind::Gpu);
    let auto = open_device("auto", &OpenOptions::default()).expect("the CPU at least");
    let expected = real.as_ref().map_or("cpu", |info| &info.name);
    assert_eq!(auto.info().name, expected);
    match (real, open_device("gpu", &OpenOptions::default())) {
        (Some(info), Ok(gpu)) => assert_eq!(gpu.info().name, info.name),
        (None, Err(error)) => assert_eq!(error, DeviceError::NoGpu { available: names() }),
        (real, gpu) => panic!("{real:?} and {:?}", gpu.err()),
    }
}

#[test]
fn each_listed_device_opens_by_its_name() {
    for info in list_devices() {
        let device = open_device(&info.name, &OpenOptions::default()).expect("opens");
        assert_eq!(device.info().name, info.name);
        assert_eq!(device.info().kind, info.kind);
    }
}

#[test]
fn compiled_kernels_are_kept_on_disk() {
    let Some(gpu) = common::gpu() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = OpenOptions { cache_folder: Some(folder.path().join("new")), ..Default::default() };
    let run = || {
        let device = open_device(&gpu.info().name, &options).expect("opens");
        let data = zeros(&*device, "data", 1);
        device.run(&[dispatch(&*device, &STEP, &[&data], [1, 1, 1])], false).expect("runs");
        assert_eq!(words(&*device, &data), [1]);
    };
    run();
    let Ok(files) = folder.path().join("new").read_dir() else {
        println!("{} keeps no compiled kernels", gpu.info().backend);
        return;
    };
    run();
    // A damaged file costs time and nothing else.
    for file in files {
        fs::write(file.expect("listed").path(), b"not a cache").expect("writable");
        run();
    }
}

#[test]
fn a_kernel_the_driver_refuses_is_an_error() {
    static WRONG: Kernel = Kernel {
        name: "wrong",
        wgsl: "@compute @workgroup_size(64) fn wrong() { let x: u32 = 1.5; }",
        bindings: &[],
        workgroup_size: 64,
        workgroup_override: None,
        native: nothing,
    };
    static MISNAMED: Kernel =
        Kernel { name: "other", wgsl: "@compute @workgroup_size(64) fn wrong() {}", ..WRONG };
    static WIDE: Kernel = Kernel { workgroup_size: 1 << 20, ..WRONG };
    let Some(gpu) = common::gpu() else { return };
    static CHOSEN: Kernel = Kernel {
        wgsl: "override SIZE: u32 = 64u; @compute @workgroup_size(SIZE) fn wrong() {}",
        workgroup_override: Some("SIZE"),
        ..WRONG
    };
    gpu.load_kernel(&CHOSEN).expect("as wide as by default");
    let too_wide = [("SIZE", f64::from(1 << 20))];
    for (kernel, overrides) in [(&WRONG, &[][..]), (&MISNAMED, &[]), (&WIDE, &[]), (&CHOSEN, &too_wide)] {
        let error = gpu.load_specialised(kernel, overrides).expect_err("refused");
        println!("{error}");
        assert!(matches!(error, DeviceError::KernelRefused { .. }), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    // The device goes on working.
    let data = zeros(&*gpu, "data", 1);
    gpu.run(&[dispatch(&*gpu, &STEP, &[&data], [1, 1, 1])], false).expect("runs");
}

#[test]
fn a_kernel_with_too_many_buffers_is_an_error() {
    static BINDINGS: [Binding; 4096] =
        [Binding { name: "b", slot: 0, kind: BindingKind::StorageRead, min_bytes: 4 }; 4096];
    static MANY: Kernel = Kernel {
        name: "many",
        wgsl: "",
        bindings: &BINDINGS,
        workgroup_size: 64,
        workgroup_override: None,
        native: nothing,
    };
    let Some(gpu) = common::gpu() else { return };
    let limit = gpu.info().max_storage_buffers;
    if limit >= 4096 {
        println!("{} takes {limit} storage buffers", gpu.info().name);
        return;
    }
    let device = gpu.info().name.clone();
    let error = gpu.load_kernel(&MANY).expect_err("too many");
    assert_eq!(error, DeviceError::TooManyStorageBuffers { device, kernel: "many", count: 4096, limit });
}

#[test]
fn a_uniform_too_large_is_an_error() {
    let Some(gpu) = common::gpu() else { return };
    let error = gpu.create_buffer("params", 1 << 40, BufferUsage::Uniform).expect_err("too large");
    assert!(matches!(error, DeviceError::BufferTooLarge { .. }), "{error}");
}

#[test]
fn memory_that_runs_out_is_an_error() {
    let cpu = common::cpu();
    let limit = cpu.info().max_buffer_bytes;
    // Fresh pages that are never touched.
    let most = cpu.create_buffer("most", (limit / 4 * 3) & !3, BufferUsage::Storage);
    let Ok(most) = most else { return };
    let bytes = (limit / 2) & !3;
    let error = cpu.create_buffer("rest", bytes, BufferUsage::Storage).expect_err("full");
    assert_eq!(error, DeviceError::OutOfMemory { device: "cpu".into(), label: "rest".into(), bytes });
    drop(most);
    cpu.create_buffer("rest", bytes, BufferUsage::Storage).expect("free again");
}

unsafe fn nothing(_: &[Storage<'_>], _: Invocations) {}
