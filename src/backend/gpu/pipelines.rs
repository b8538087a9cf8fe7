//! The compiled kernels and the layout of their bindings.
//!
//! Owns compilation, done once a device; knows nothing of what the buffers hold.

use std::sync::OnceLock;

use super::layout::{DRIVE_ENTRIES, Orbit, Parameters, Run, Span, Tangent, Totals, binding};
use super::shader_source::{Kernel, Lanes, Shader};
use crate::experiment::Scheme;

/// The kernels of one scheme.
type Kernels = [wgpu::ComputePipeline; Kernel::ALL.len()];

/// The kernels of one device, a scheme's compiled when they are first asked for.
pub struct Pipelines {
    layout: wgpu::BindGroupLayout,
    kernels: [OnceLock<Kernels>; Scheme::ALL.len()],
    workgroup_size: u32,
    lanes: Lanes,
}

impl Pipelines {
    /// Compiles nothing yet; errors are left to the device's error handler.
    pub fn new(device: &wgpu::Device, workgroup_size: u32, lanes: Lanes) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("batch"),
            entries: &entries(),
        });
        Self {
            layout,
            kernels: Default::default(),
            workgroup_size,
            lanes,
        }
    }

    /// A kernel of a scheme's shader, compiled by the first call; errors are left to the device's error handler.
    pub fn kernel(
        &self,
        device: &wgpu::Device,
        scheme: Scheme,
        shader: &Shader,
        kernel: Kernel,
    ) -> &wgpu::ComputePipeline {
        let kernels = self.kernels[scheme as usize].get_or_init(|| self.compile(device, shader));
        &kernels[kernel as usize]
    }

    fn compile(&self, device: &wgpu::Device, shader: &Shader) -> Kernels {
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("batch"),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("tribochaos"),
            source: wgpu::ShaderSource::Wgsl(shader.source(self.lanes).into()),
        });
        Kernel::ALL.map(|kernel| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(kernel.entry_point()),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(kernel.entry_point()),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &kernel.constants(self.workgroup_size),
                    ..Default::default()
                },
                cache: None,
            })
        })
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub fn workgroup_size(&self) -> u32 {
        self.workgroup_size
    }

    /// Instances that a workgroup carries.
    pub fn workgroup_instances(&self) -> u32 {
        self.workgroup_size * self.lanes.count()
    }
}

fn entries() -> [wgpu::BindGroupLayoutEntry; 9] {
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
        (binding::TANGENTS, read_write, size_of::<Tangent>()),
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
