//! Kernels compiled by the driver, and their buffers bound.

use std::num::NonZero;

use wgsl_cpu::{Binding, BindingKind, Kernel};

use super::{GpuDevice, fault::Fault};
use crate::{Buffer, DeviceError, resource::Pipeline};

/// A compiled kernel.
pub(super) struct Ready {
    /// Invocations of a workgroup.
    pub(super) workgroup_size: u32,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl Ready {
    pub(super) fn new(
        gpu: &GpuDevice,
        kernel: &'static Kernel,
        overrides: &[(&'static str, f64)],
    ) -> Result<Self, DeviceError> {
        let refuse = |message| DeviceError::KernelRefused {
            device: gpu.info.name.clone(),
            kernel: kernel.name,
            message,
        };
        let most = gpu.device.limits().max_compute_invocations_per_workgroup;
        let chosen = overrides.iter().find(|(name, _)| kernel.workgroup_override == Some(name));
        let asked = chosen.map_or(kernel.workgroup_size, |&(_, size)| size as u32);
        if asked > most {
            return Err(refuse(format!("workgroups of {asked} invocations, and it takes at most {most}")));
        }
        let made = gpu.faults.guard(&gpu.device, || compile(gpu, kernel, overrides, asked));
        made.map_err(|fault| match fault {
            Fault::Refused(message) => refuse(message),
            fault => gpu.error("compile a kernel", fault),
        })
    }
}

fn compile(
    gpu: &GpuDevice,
    kernel: &'static Kernel,
    overrides: &[(&'static str, f64)],
    workgroup_size: u32,
) -> Ready {
    let entries: Vec<_> = kernel.bindings.iter().map(layout_entry).collect();
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(kernel.name),
        entries: &entries,
    });
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(kernel.name),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let source = wgpu::ShaderModuleDescriptor {
        label: Some(kernel.name),
        source: wgpu::ShaderSource::Wgsl(kernel.wgsl.into()),
    };
    // Bounds and loops cost an eighth of the speed and the kernels keep to them by themselves;
    // integer division by zero is defined in WGSL, and the native twins do as it says.
    let checks = wgpu::ShaderRuntimeChecks { int_div_checks: true, ..wgpu::ShaderRuntimeChecks::unchecked() };
    // SAFETY: kernels are the program's own, never input: their loops end and their indices are in
    // range, which the tests of their native twins check.
    let module = unsafe { gpu.device.create_shader_module_trusted(source, checks) };
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(kernel.name),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some(kernel.name),
        compilation_options: wgpu::PipelineCompilationOptions { constants: overrides, ..Default::default() },
        cache: gpu.cache.as_ref().map(|cache| cache.for_new_pipeline()),
    });
    Ready { workgroup_size, layout, pipeline }
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: NonZero::new(binding.min_bytes),
    };
    let ty = match binding.kind {
        BindingKind::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::StorageRead => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        BindingKind::StorageReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        BindingKind::Texels => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        },
    };
    wgpu::BindGroupLayoutEntry {
        binding: binding.slot,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

/// A compiled kernel and its buffers.
pub(super) struct Bound {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
}

impl Bound {
    pub(super) fn new(
        gpu: &GpuDevice,
        pipeline: &Pipeline,
        buffers: &[&Buffer],
    ) -> Result<Self, DeviceError> {
        let ready = gpu.ready(pipeline)?;
        let bindings = pipeline.kernel.bindings.iter().zip(buffers);
        let entries = bindings
            .map(|(binding, buffer)| {
                let resource = match binding.kind {
                    BindingKind::Texels => wgpu::BindingResource::TextureView(&gpu.texels(buffer)?.view),
                    _ => gpu.buffer(buffer)?.as_entire_binding(),
                };
                Ok(wgpu::BindGroupEntry { binding: binding.slot, resource })
            })
            .collect::<Result<Vec<_>, DeviceError>>()?;
        let descriptor = wgpu::BindGroupDescriptor {
            label: Some(pipeline.kernel.name),
            layout: &ready.layout,
            entries: &entries,
        };
        let group = gpu.guard("bind a kernel's buffers", || gpu.device.create_bind_group(&descriptor))?;
        Ok(Self { pipeline: ready.pipeline.clone(), group })
    }
}
