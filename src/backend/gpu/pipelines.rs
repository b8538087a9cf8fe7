//! The compiled kernels and the layout of their bindings.
//!
//! Owns compilation, done once a device; knows nothing of what the buffers hold.

use super::layout::{DRIVE_ENTRIES, Orbit};
use super::layout::{Parameters, Run, Span, Totals, binding};
use super::shader_source::{self, Kernel};

/// The kernels of one device.
pub struct Pipelines {
    layout: wgpu::BindGroupLayout,
    kernels: [wgpu::ComputePipeline; Kernel::ALL.len()],
    workgroup_size: u32,
}

impl Pipelines {
    /// Compiles the kernels; errors are left to the device's error handler.
    pub fn new(device: &wgpu::Device, workgroup_size: u32) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("batch"),
            entries: &entries(),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("batch"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("tribochaos"),
            source: wgpu::ShaderSource::Wgsl(shader_source::SOURCE.into()),
        });
        let kernels = Kernel::ALL.map(|kernel| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(kernel.entry_point()),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(kernel.entry_point()),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &shader_source::constants(workgroup_size),
                    ..Default::default()
                },
                cache: None,
            })
        });
        Self {
            layout,
            kernels,
            workgroup_size,
        }
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub fn kernel(&self, kernel: Kernel) -> &wgpu::ComputePipeline {
        &self.kernels[kernel as usize]
    }

    pub fn workgroup_size(&self) -> u32 {
        self.workgroup_size
    }
}

fn entries() -> [wgpu::BindGroupLayoutEntry; 8] {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let read = Storage { read_only: true };
    let read_write = Storage { read_only: false };
    [
        (binding::RUN, Uniform, size_of::<Run>()),
        (binding::SPAN, Uniform, size_of::<Span>()),
        (binding::DRIVE, Uniform, DRIVE_ENTRIES * size_of::<[f32; 4]>()),
        (binding::BIRKHOFF_WEIGHTS, read, size_of::<f32>()),
        (binding::PARAMETERS, read, size_of::<Parameters>()),
        (binding::ORBITS, read_write, size_of::<Orbit>()),
        (binding::TOTALS, read_write, size_of::<Totals>()),
        (binding::LAST_STATES, read_write, size_of::<[f32; 2]>()),
    ]
    .map(|(binding, ty, size)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: wgpu::BufferSize::new(size as u64),
        },
        count: None,
    })
}
