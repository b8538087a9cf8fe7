//! The compiled kernels of a shader, the layout of their bindings, and how fast each has been found to be.
//!
//! Owns compilation; knows nothing of what the buffers hold.

use super::context::{GpuContext, WORKGROUP_SIZE};
use super::layout::{Access, Binding};
use super::pacer::Pacer;
use super::shader_source::{Kernel, Shader, Shape};
use crate::backend::BackendError;

/// A kernel, compiled for a device.
pub(super) struct Compiled {
    kernel: Kernel,
    pub pipeline: wgpu::ComputePipeline,
    pub pacer: Pacer,
}

/// The kernels of a shader, for threads of one shape.
pub(super) struct Kernels {
    shape: Shape,
    layout: wgpu::BindGroupLayout,
    compiled: Vec<Compiled>,
}

impl Kernels {
    /// Compiles all kernels of a shader.
    pub fn new(
        context: &GpuContext,
        shader: &Shader,
        shape: Shape,
        bindings: &[Binding],
    ) -> Result<Self, BackendError> {
        let device = context.device();
        let entries: Vec<_> = bindings.iter().map(layout_entry).collect();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("batch"),
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("batch"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("tribochaos"),
            source: wgpu::ShaderSource::Wgsl(shader.source(shape).into()),
        });
        let compile = |kernel| {
            let entry_point = shader.entry_point(kernel);
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &shader.constants(kernel, WORKGROUP_SIZE),
                    ..Default::default()
                },
                cache: None,
            })
        };
        let compiled = shader
            .kernels()
            .map(|kernel| Compiled {
                kernel,
                pipeline: compile(kernel),
                pacer: Pacer::default(),
            })
            .collect();
        context.check()?;
        Ok(Self {
            shape,
            layout,
            compiled,
        })
    }

    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The layout of the bindings. A device accepts the layout of other kernels in its place if their bindings are the same.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub fn kernel(&mut self, kernel: Kernel) -> &mut Compiled {
        let mut compiled = self.compiled.iter_mut();
        let found = compiled.find(|compiled| compiled.kernel == kernel);
        found.expect("a model asks for its own shader's kernels")
    }

    /// Forgets how fast the kernels have been found to be.
    pub fn forget_pace(&mut self) {
        for compiled in &mut self.compiled {
            compiled.pacer = Pacer::default();
        }
    }
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    use wgpu::BufferBindingType::{Storage, Uniform};
    wgpu::BindGroupLayoutEntry {
        binding: binding.number,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding.access {
                Access::Uniform => Uniform,
                Access::Read => Storage { read_only: true },
                Access::ReadWrite | Access::Kept => Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: wgpu::BufferSize::new(binding.element()),
        },
        count: None,
    }
}
