//! Finding this machine's GPUs.

use wgpu::{Backend, Backends, DeviceType, InstanceDescriptor, InstanceFlags};

use crate::{DeviceInfo, DeviceKind};

/// A GPU, or a driver that stands in for one, that can be opened.
pub(crate) struct Found {
    pub(crate) info: DeviceInfo,
    pub(super) adapter: wgpu::Adapter,
}

/// All adapters of the native backends, real GPUs first: discrete, integrated, virtual, others,
/// then software. A GPU that several backends offer is listed once; a second one of the same name
/// gets a number.
pub(crate) fn enumerate() -> Vec<Found> {
    let backends = Backends::VULKAN | Backends::METAL | Backends::DX12;
    let instance = wgpu::Instance::new(InstanceDescriptor {
        backends,
        flags: flags(),
        ..InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (type_rank(info.device_type), backend_rank(info.backend))
    });
    let mut found: Vec<Found> = Vec::new();
    for adapter in adapters {
        let info = adapter.get_info();
        if !found.iter().any(|other| is_same_gpu(&other.adapter.get_info(), &info)) {
            let mut info = describe(&adapter, &info);
            number(&mut info.name, &found);
            found.push(Found { info, adapter });
        }
    }
    found
}

/// No debugging and no validation by the backend. The check of each indirect dispatch's grid costs
/// a dispatch of its own; only DX12 needs it, where `num_workgroups` is zero without.
fn flags() -> InstanceFlags {
    if cfg!(windows) { InstanceFlags::VALIDATION_INDIRECT_CALL } else { InstanceFlags::empty() }
}

fn type_rank(device_type: DeviceType) -> u8 {
    match device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

fn backend_rank(backend: Backend) -> u8 {
    match backend {
        Backend::Vulkan => 0,
        Backend::Metal => 1,
        _ => 2,
    }
}

/// Whether one backend offers what another one offered already.
fn is_same_gpu(one: &wgpu::AdapterInfo, other: &wgpu::AdapterInfo) -> bool {
    one.backend != other.backend && one.vendor == other.vendor && one.device == other.device
}

fn describe(adapter: &wgpu::Adapter, info: &wgpu::AdapterInfo) -> DeviceInfo {
    let limits = adapter.limits();
    let software = info.device_type == DeviceType::Cpu;
    let backend = [&info.backend.to_string(), info.driver.as_str(), info.driver_info.as_str()];
    let said: Vec<&str> = backend.into_iter().map(str::trim).filter(|part| !part.is_empty()).collect();
    let max_buffer_bytes = limits.max_buffer_size & !3;
    DeviceInfo {
        name: info.name.trim().to_owned(),
        kind: if software { DeviceKind::SoftwareGpu } else { DeviceKind::Gpu },
        backend: said.join(", "),
        memory_bytes: memory_bytes(adapter),
        max_buffer_bytes,
        max_binding_bytes: (limits.max_storage_buffer_binding_size & !3).min(max_buffer_bytes),
        max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
        wide_workgroup: wide_workgroup(info, &limits),
    }
}

/// 512 of NVIDIA's share a processor's registers by 128, so that more of them wait for memory at once than
/// of 64 (measured on an H100: bench/NOTES.md, "Wide workgroups"). Software does the same, so that tests
/// run it. Of others nothing is known; Metal's pipelines may take less.
fn wide_workgroup(info: &wgpu::AdapterInfo, limits: &wgpu::Limits) -> u32 {
    /// Of PCI.
    const NVIDIA: u32 = 0x10de;
    let is_known = info.vendor == NVIDIA || info.device_type == DeviceType::Cpu;
    let most = limits.max_compute_invocations_per_workgroup.min(limits.max_compute_workgroup_size_x);
    if is_known && most >= 512 { 512 } else { 64 }
}

/// Appends ` #2`, ` #3`, … to the name of a GPU that is in the machine more than once.
fn number(name: &mut String, found: &[Found]) {
    let base = name.clone();
    let mut n = 2;
    while found.iter().any(|other| other.info.name == *name) {
        *name = format!("{base} #{n}");
        n += 1;
    }
}

/// The largest heap that is the device's own. wgpu does not say; Vulkan does.
#[cfg(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))]
fn memory_bytes(adapter: &wgpu::Adapter) -> Option<u64> {
    /// `VK_MEMORY_HEAP_DEVICE_LOCAL_BIT`.
    const DEVICE_LOCAL: u32 = 1;
    // SAFETY: the handle is only asked about its properties and destroys nothing.
    let vulkan = unsafe { adapter.as_hal::<wgpu::hal::api::Vulkan>() }?;
    let instance = vulkan.shared_instance().raw_instance();
    // SAFETY: the physical device belongs to this instance and `vulkan` keeps both alive.
    let memory = unsafe { instance.get_physical_device_memory_properties(vulkan.raw_physical_device()) };
    let heaps = memory.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.as_raw() & DEVICE_LOCAL != 0).map(|heap| heap.size).max()
}

/// Metal does not tell a GPU's memory apart from the system's.
#[cfg(not(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd")))]
fn memory_bytes(_adapter: &wgpu::Adapter) -> Option<u64> {
    None
}
