//! The devices under test, small kernels written twice by hand, and short ways to run them.

use std::{
    env,
    sync::{Arc, OnceLock},
};

use bytemuck::{Pod, cast_slice};
use midway_device::{
    Binding, BindingKind, Buffer, BufferUsage, Command, Device, DeviceKind, Kernel, OpenOptions,
    list_devices, open_device,
};
use wgsl_cpu::{Invocations, Storage};

/// Invocations per workgroup of all kernels here.
pub const WORKGROUP: u32 = 64;

/// The CPU device, with more threads than a small machine has cores.
pub fn cpu() -> Arc<dyn Device> {
    let options = OpenOptions { threads: Some(4), ..Default::default() };
    open_device("cpu", &options).expect("the CPU device needs nothing")
}

/// A real GPU, else a software one, opened once; none where there is neither, which is said, and is
/// a failure if `MIDWAY_REQUIRE_GPU` is 1.
pub fn gpu() -> Option<Arc<dyn Device>> {
    static GPU: OnceLock<Option<Arc<dyn Device>>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        let info = list_devices().into_iter().find(|info| info.kind != DeviceKind::Cpu)?;
        let folder = env::temp_dir().join("midway-device-tests");
        let options = OpenOptions { cache_folder: Some(folder), ..Default::default() };
        Some(open_device(&info.name, &options).expect("a listed device opens"))
    });
    if gpu.is_none() {
        println!("the GPU suite did not run: no adapter");
        assert!(env::var("MIDWAY_REQUIRE_GPU").as_deref() != Ok("1"), "MIDWAY_REQUIRE_GPU=1 and no adapter");
    }
    gpu.clone()
}

/// A buffer that holds `values`.
pub fn buffer_of<T: Pod>(device: &dyn Device, label: &str, usage: BufferUsage, values: &[T]) -> Buffer {
    let bytes: &[u8] = cast_slice(values);
    let buffer = device.create_buffer(label, bytes.len() as u64, usage).expect("created");
    device.write_buffer(&buffer, 0, bytes).expect("written");
    buffer
}

/// A zeroed storage buffer of `n` words.
pub fn zeros(device: &dyn Device, label: &str, n: u64) -> Buffer {
    device.create_buffer(label, n * 4, BufferUsage::Storage).expect("created")
}

/// All words of a buffer.
pub fn words(device: &dyn Device, buffer: &Buffer) -> Vec<u32> {
    let bytes = device.read_buffer(buffer, 0, buffer.bytes()).expect("read");
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
}

/// The command that runs a kernel over a grid.
pub fn dispatch(
    device: &dyn Device,
    kernel: &'static Kernel,
    buffers: &[&Buffer],
    groups: [u32; 3],
) -> Command {
    let pipeline = device.load_kernel(kernel).expect("loaded");
    Command::Dispatch { bound: device.bind(&pipeline, buffers).expect("bound"), groups }
}

const fn binding(name: &'static str, slot: u32, kind: BindingKind, min_bytes: u64) -> Binding {
    Binding { name, slot, kind, min_bytes }
}

/// Writes `start + i` at each flat index `i` of a 3D grid.
pub static WRITE_INDEX: Kernel = Kernel {
    name: "write_index",
    wgsl: "
        struct Params { start: u32, a: u32, b: u32, c: u32 }
        @group(0) @binding(0) var<uniform> params: Params;
        @group(0) @binding(2) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(64)
        fn write_index(
            @builtin(workgroup_id) group: vec3<u32>,
            @builtin(num_workgroups) groups: vec3<u32>,
            @builtin(local_invocation_index) local: u32,
        ) {
            let i = ((group.z * groups.y + group.y) * groups.x + group.x) * 64u + local;
            if i < arrayLength(&out) { out[i] = params.start + i; }
        }",
    bindings: &[
        binding("params", 0, BindingKind::Uniform, 16),
        binding("out", 2, BindingKind::StorageReadWrite, 4),
    ],
    workgroup_size: WORKGROUP,
    workgroup_override: None,
    native: write_index,
};

unsafe fn write_index(bindings: &[Storage<'_>], invocations: Invocations) {
    let (params, out) = (bindings[0], bindings[1]);
    for i in flat(invocations) {
        if i < out.array_length(0, 4) {
            // SAFETY: within the uniform's 16 bytes and the array's length; each index is written
            // by one invocation.
            unsafe { out.at(i as usize * 4).store(params.at(0).load::<u32>() + i) };
        }
    }
}

/// Adds `i + 1` for each flat index `i` to the first word.
pub static ADD_ALL: Kernel = Kernel {
    name: "add_all",
    wgsl: "
        @group(0) @binding(0) var<storage, read_write> sum: atomic<u32>;
        @compute @workgroup_size(64)
        fn add_all(@builtin(global_invocation_id) id: vec3<u32>) {
            atomicAdd(&sum, id.x + 1u);
        }",
    bindings: &[binding("sum", 0, BindingKind::StorageReadWrite, 4)],
    workgroup_size: WORKGROUP,
    workgroup_override: None,
    native: add_all,
};

unsafe fn add_all(bindings: &[Storage<'_>], invocations: Invocations) {
    for i in flat(invocations) {
        // SAFETY: the first word, only accessed as an atomic one.
        unsafe { bindings[0].at(0).atomic::<u32>() }.fetch_add(i + 1);
    }
}

/// Makes `[count[0], 1, 1]` the grid of a later dispatch, at word 1 of `args`.
pub static WRITE_ARGS: Kernel = Kernel {
    name: "write_args",
    wgsl: "
        @group(0) @binding(0) var<storage, read> count: array<u32>;
        @group(0) @binding(1) var<storage, read_write> args: array<u32>;
        @compute @workgroup_size(64)
        fn write_args(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x == 0u {
                args[1] = count[0];
                args[2] = 1u;
                args[3] = 1u;
            }
        }",
    bindings: &[
        binding("count", 0, BindingKind::StorageRead, 4),
        binding("args", 1, BindingKind::StorageReadWrite, 16),
    ],
    workgroup_size: WORKGROUP,
    workgroup_override: None,
    native: write_args,
};

unsafe fn write_args(bindings: &[Storage<'_>], invocations: Invocations) {
    for _ in flat(invocations).filter(|&i| i == 0) {
        // SAFETY: four words are bound, which this one invocation alone writes.
        unsafe {
            bindings[1].at(4).store(bindings[0].at(0).load::<u32>());
            bindings[1].at(8).store([1u32, 1]);
        }
    }
}

/// Makes each word `3 w + 1`: applied twice, the order of commands shows.
pub static STEP: Kernel = Kernel {
    name: "step_words",
    wgsl: "
        @group(0) @binding(0) var<storage, read_write> data: array<u32>;
        @compute @workgroup_size(64)
        fn step_words(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < arrayLength(&data) { data[id.x] = data[id.x] * 3u + 1u; }
        }",
    bindings: &[binding("data", 0, BindingKind::StorageReadWrite, 4)],
    workgroup_size: WORKGROUP,
    workgroup_override: None,
    native: step_words,
};

unsafe fn step_words(bindings: &[Storage<'_>], invocations: Invocations) {
    for i in flat(invocations).filter(|&i| i < bindings[0].array_length(0, 4)) {
        // SAFETY: within the array; each word is accessed by one invocation.
        unsafe {
            let word = bindings[0].at(i as usize * 4);
            word.store(word.load::<u32>().wrapping_mul(3).wrapping_add(1));
        }
    }
}

/// Each invocation's index in the whole dispatch, workgroups in row-major order.
fn flat(invocations: Invocations) -> impl Iterator<Item = u32> {
    let first = invocations.first * WORKGROUP;
    first..first + invocations.count * WORKGROUP
}
