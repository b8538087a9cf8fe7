//! The compiled kernels of the full model and the layout of their bindings.
//!
//! Owns compilation, for one number of heat modes; knows nothing of what the buffers hold.

use super::super::context::GpuContext;
use super::super::layout::Span;
use super::layout::{HeatMode, Orbit, Parameters, Run, Totals, binding};
use super::shader_source;
use crate::backend::BackendError;

/// The kernels of one device.
pub struct Pipelines {
    modes: u32,
    layout: wgpu::BindGroupLayout,
    plain: wgpu::ComputePipeline,
    tangent: wgpu::ComputePipeline,
}

impl Pipelines {
    /// Compiles the kernels for so many heat modes.
    pub fn new(context: &GpuContext, modes: u32) -> Result<Self, BackendError> {
        let device = context.device();
        let workgroup_size = context.pipelines().workgroup_size();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("rubbed batch"),
            entries: &entries(),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("rubbed batch"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("tribochaos, full model"),
            source: wgpu::ShaderSource::Wgsl(shader_source::source(modes).into()),
        });
        let pipeline = |carries_tangent| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(shader_source::ENTRY_POINT),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(shader_source::ENTRY_POINT),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &shader_source::constants(workgroup_size, carries_tangent),
                    ..Default::default()
                },
                cache: None,
            })
        };
        let (plain, tangent) = (pipeline(false), pipeline(true));
        context.check()?;
        Ok(Self {
            modes,
            layout,
            plain,
            tangent,
        })
    }

    /// The number of heat modes that the kernels are for.
    pub fn modes(&self) -> u32 {
        self.modes
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub fn kernel(&self, carries_tangent: bool) -> &wgpu::ComputePipeline {
        if carries_tangent { &self.tangent } else { &self.plain }
    }
}

fn entries() -> [wgpu::BindGroupLayoutEntry; 9] {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let read = Storage { read_only: true };
    let read_write = Storage { read_only: false };
    [
        (binding::RUN, Uniform, size_of::<Run>()),
        (binding::SPAN, Uniform, size_of::<Span>()),
        (binding::BIRKHOFF_WEIGHTS, read, size_of::<f32>()),
        (binding::PARAMETERS, read, size_of::<Parameters>()),
        (binding::HEAT_MODES, read, size_of::<HeatMode>()),
        (binding::MODES, read_write, size_of::<f32>()),
        (binding::LAST_STATES, read_write, size_of::<[f32; 2]>()),
        (binding::ORBITS, read_write, size_of::<Orbit>()),
        (binding::TOTALS, read_write, size_of::<Totals>()),
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
