//! Functions of the shaders, evaluated by a kernel that a test appends to them.
//!
//! Owns the passage of samples through a device; what is probed is each test's.

use tribochaos::backend::gpu::GpuContext;

/// Uniform numbers in 0..1 from a linear congruence.
pub struct Noise(pub u64);

impl Noise {
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, low: f64, high: f64) -> f32 {
        (low + (high - low) * self.unit()) as f32
    }
}

/// What the kernel `probe` of the shader `source` makes of the samples, one a lane: as many as whole workgroups of 64
/// threads hold. It reads them from binding 10 and writes to binding 11, and has no others; there, each number is followed
/// by those of the thread's other lanes.
pub fn evaluate<const I: usize, const O: usize>(
    context: &GpuContext,
    source: &str,
    constants: &[(&str, f64)],
    lanes: usize,
    samples: &[[f32; I]],
) -> Vec<[f32; O]> {
    use wgpu::BufferUsages as Usage;
    assert!(samples.len().is_multiple_of(64 * lanes));
    let by_lanes: Vec<f32> = samples
        .chunks(lanes)
        .flat_map(|thread| (0..I).flat_map(move |i| thread.iter().map(move |sample| sample[i])))
        .collect();
    let device = context.device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("probe"),
        layout: None,
        module: &module,
        entry_point: Some("probe"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            ..Default::default()
        },
        cache: None,
    });
    let buffer = |size, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let size = (samples.len() * size_of::<[f32; O]>()) as u64;
    let input = buffer(size_of_val(samples) as u64, Usage::STORAGE | Usage::COPY_DST);
    let output = buffer(size, Usage::STORAGE | Usage::COPY_SRC);
    let staging = buffer(size, Usage::MAP_READ | Usage::COPY_DST);
    context.queue().write_buffer(&input, 0, bytemuck::cast_slice(&by_lanes));
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 10,
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 11,
                resource: output.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.dispatch_workgroups((samples.len() / (64 * lanes)) as u32, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&output, 0, &staging, 0, size);
    context.queue().submit([encoder.finish()]);
    staging.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let probes: Vec<f32> = bytemuck::pod_collect_to_vec(&staging.slice(..).get_mapped_range().unwrap());
    probes
        .chunks(O * lanes)
        .flat_map(|thread| (0..lanes).map(move |lane| std::array::from_fn(|i| thread[i * lanes + lane])))
        .collect()
}
