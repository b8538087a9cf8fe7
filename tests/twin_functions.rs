//! Twins give the same values: their functions on random inputs.

#![cfg(feature = "gpu")]

mod gpu_context;
mod probe;

use tribochaos::backend::gpu::GpuContext;
use tribochaos::backend::gpu::shader_source::{Kernel, Lanes, Shader, Shape};
use tribochaos::dynamics::rk4::{self, StageSpeeds, State, StepSize};
use tribochaos::dynamics::tangent::{Bases, Vector};
use tribochaos::dynamics::taylor::{self, COEFFICIENTS, Flow};
use tribochaos::experiment::{Scheme, Settings};
use tribochaos::lanes::{Real, Ticks};
use tribochaos::model::friction::Friction;
use tribochaos::model::motion::{Motion, RUNAWAY_BOUND};
use tribochaos::parameters::Parameter;

use probe::{Noise, evaluate};

/// Evaluates every function of the twins at one sample a lane.
const PROBE: &str = "
struct Sample { parameters: Values, speed: StageSpeeds, state: State, bases: Bases }
struct Probe {
    force: Real, slope: Real,
    linearised: Linearised,
    stepped: State, with_tangent: State, bases: Bases, divergence: Real,
    orthonormal: Bases, growth: Growth,
}
@group(0) @binding(10) var<storage, read> samples: array<Sample>;
@group(0) @binding(11) var<storage, read_write> probes: array<Probe>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let sample = samples[thread.x];
    let motion = motion_new(sample.parameters);
    let h = step_size_new(sample.parameters.step_units);
    let v = sample.speed.start - sample.state.y;
    let stepped = step_with_tangent(motion, h, sample.speed, sample.state, sample.bases);
    let orthonormal = orthonormalise(sample.bases);
    probes[thread.x] = Probe(
        plus_force(motion.friction, Real(0.0), v), slope(motion.friction, v),
        linearised(motion, sample.state.x, sample.speed.start - sample.state.y, sample.speed.start),
        rk4_step(motion, h, sample.speed, sample.state), stepped.state, stepped.bases, stepped.divergence,
        orthonormal.bases, orthonormal.growth,
    );
}
";
const SAMPLES: usize = 64 * 256;
const INPUTS: usize = 20;
const OUTPUTS: usize = 20;

/// The fields of the shader's `Sample`, in order. Half of the states slide inside the friction layer.
fn sample(noise: &mut Noise) -> [f32; INPUTS] {
    let epsilon_0 = 10f64.powf(-3.0 * noise.unit()) as f32;
    let y = noise.within(-3.0, 3.0);
    let start = if noise.unit() < 0.5 {
        y + epsilon_0 * noise.within(-1.5, 1.5)
    } else {
        noise.within(-12.0, 12.0)
    };
    let change = noise.within(-0.02, 0.02);
    [
        noise.within(0.0, 12.0),
        noise.within(-1.0, 2.0),
        noise.within(-1.0, 1.0),
        noise.within(-1.0, 2.0),
        noise.within(0.0, 0.5),
        noise.within(0.0, 1.0),
        noise.within(-1.0, 1.0),
        noise.within(-1.0, 1.0),
        epsilon_0,
        0.005,
        0.1,
        start,
        start + change,
        start + 2.0 * change,
        noise.within(-2.0, 2.0),
        y,
        noise.within(-1.0, 1.0),
        noise.within(-1.0, 1.0),
        noise.within(-1.0, 1.0),
        noise.within(-1.0, 1.0),
    ]
}

/// What the shader's `Probe` is on the CPU, and the size of the terms each value is made of: what a rounding
/// error is relative to.
#[expect(clippy::too_many_lines, reason = "every value that the shader gives, in its order")]
fn expected(sample: &[f32; INPUTS]) -> ([f32; OUTPUTS], [f32; OUTPUTS]) {
    let &[
        zeta_k,
        h1,
        omega_k,
        b,
        epsilon,
        f_0,
        alpha,
        beta,
        epsilon_0,
        step,
        _,
        start,
        middle,
        end,
        x,
        y,
        x1,
        y1,
        x2,
        y2,
    ] = sample;
    // as the motion has it, with the damping in its linear term
    let friction = Friction::<f32>::new(epsilon, f_0, alpha - h1, beta, epsilon_0);
    let motion = Motion::<f32>::new(|parameter| match parameter {
        Parameter::ZetaK => zeta_k,
        Parameter::H1 => h1,
        Parameter::OmegaK => omega_k,
        Parameter::B => b,
        Parameter::Epsilon => epsilon,
        Parameter::F0 => f_0,
        Parameter::Alpha => alpha,
        Parameter::Beta => beta,
        Parameter::Epsilon0 => epsilon_0,
        other => unreachable!("the equations of motion do not contain {other}"),
    });
    let h = StepSize::<f32>::new(|_| step.into());
    let speed = StageSpeeds { start, middle, end };
    let state = State { x, y };
    let bases = Bases {
        first: Vector { x: x1, y: y1 },
        second: Vector { x: x2, y: y2 },
    };
    let linearised = motion.linearised(x, start - y, start);
    let stepped = rk4::step(&motion, &h, speed, state);
    let (with_tangent, tangent, divergence) =
        rk4::step_with_tangent(&motion, &h, speed, state, [bases.first, bases.second]);
    let mut orthonormal = bases;
    let growth = orthonormal.orthonormalise();
    let v = start - y;
    let values = [
        friction.plus_force(0.0, v),
        friction.slope(v),
        linearised.acceleration,
        linearised.by_x,
        linearised.by_y,
        stepped.x,
        stepped.y,
        with_tangent.x,
        with_tangent.y,
        tangent[0].x,
        tangent[0].y,
        tangent[1].x,
        tangent[1].y,
        divergence,
        orthonormal.first.x,
        orthonormal.first.y,
        orthonormal.second.x,
        orthonormal.second.y,
        growth.first,
        growth.second,
    ];

    let speeds = v.abs() + 3.0 * (middle - start).abs();
    let linear = alpha.abs() + h1.abs();
    let force = epsilon * (f_0 + linear * speeds + beta.abs() * speeds.powi(3));
    let layer = 2.0 * epsilon * f_0 / epsilon_0;
    let slope = layer + epsilon * (linear + 3.0 * beta.abs() * speeds * speeds);
    let by_x = 1.0 + 3.0 * b.abs() * x * x;
    let by_y = slope + epsilon * h1.abs();
    let acceleration = x.abs() * by_x + epsilon * h1.abs() * start.abs() + force;
    // at later stages v itself is rounded, which the layer's steepness makes more of
    let rounded_v = start.abs() + y.abs() + step * acceleration;
    let acceleration_later = acceleration + slope * rounded_v;
    let by_y_later = by_y + (layer / epsilon_0 + 6.0 * epsilon * beta.abs() * speeds) * rounded_v;
    let y_end = y.abs() + step * acceleration_later;
    let x_end = x.abs() + step * y_end;
    let vector = |x: f32, y: f32| {
        let y_end = y.abs() + step * (x.abs() * by_x + (y.abs() + step * x.abs() * by_x) * by_y_later);
        [x.abs() + step * y_end, y_end]
    };
    let ([first_x, first_y], [second_x, second_y]) = (vector(x1, y1), vector(x2, y2));
    // what Gram-Schmidt takes away is lost in digits
    let lost = x2.hypot(y2) / growth.second.exp();
    // the logarithm is off by up to 2^-21 near 1, four of f32's units of rounding
    let values_size = [
        force,
        slope,
        acceleration,
        by_x,
        by_y,
        x_end,
        y_end,
        x_end,
        y_end,
        first_x,
        first_y,
        second_x,
        second_y,
        step * by_y_later,
        1.0,
        1.0,
        lost,
        lost,
        4.0 + growth.first.abs(),
        4.0 + lost + growth.second.abs(),
    ];
    (values, values_size)
}

#[test]
fn functions_agree_to_a_few_roundings() {
    let Some(context) = gpu_context::open() else { return };
    let mut noise = Noise(1);
    let samples: Vec<[f32; INPUTS]> = (0..SAMPLES).map(|_| sample(&mut noise)).collect();
    for lanes in Lanes::ALL {
        assert_functions(&samples, &probed(&context, Scheme::Rk4, lanes, PROBE, &samples));
    }
}

fn assert_functions(samples: &[[f32; INPUTS]], probes: &[[f32; OUTPUTS]]) {
    let mut worst = [0f32; OUTPUTS];
    for (sample, probe) in samples.iter().zip(probes) {
        let (values, sizes) = expected(sample);
        for i in 0..OUTPUTS {
            let error = (probe[i] - values[i]).abs() / (sizes[i] * f32::EPSILON);
            assert!(
                error.is_finite(),
                "output {i}: {} for {} at {sample:?}",
                probe[i],
                values[i]
            );
            worst[i] = worst[i].max(error);
        }
    }
    assert!(worst.iter().all(|&error| error < 8.0), "{worst:?}");
}

/// Steps of the Taylor scheme: series, events, clocks, vectors and growth, from random states in random pieces.
#[test]
fn taylor_steps_agree_to_some_roundings() {
    const PROBE: &str = "
struct Sample { parameters: Values, x: Real, w: Real, piece: Real, vector: Vector }
struct Probe {
    x: Real, w: Real, piece: Real, left: Real, turning: Real, vector: Vector, divergence: Real, area: Real,
}
@group(0) @binding(10) var<storage, read> samples: array<Sample>;
@group(0) @binding(11) var<storage, read_write> probes: array<Probe>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let sample = samples[thread.x];
    let flow = flow_new(sample.parameters);
    let state = state_start(flow, sample.x, sample.w, Word(TICKS_PER_PERIOD));
    let step = taylor_step(flow, state);
    let area = area_new(sample.vector);
    let vector = vector_at(step.series, sample.vector, step.s);
    let second = vector_at(step.series, area.second, step.s);
    probes[thread.x] = Probe(
        step.end.x, step.end.w, step.end.piece, Real(step.end.left) / TICKS_PER_UNIT, turning(step),
        vector, divergence_to(step.series, step.s), spanned(vector, second),
    );
}
";
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings::default();
    let mut noise = Noise(2);
    let samples: Vec<[f32; 16]> = (0..SAMPLES)
        .map(|_| {
            let unit = taylor::unit_of_time(2.0);
            let mut set = tribochaos::parameters::ParameterSet::default();
            for (parameter, low, high) in [
                (Parameter::ZetaK, 0.0, 12.0),
                (Parameter::H1, -1.0, 2.0),
                (Parameter::OmegaK, -1.0, 1.0),
                (Parameter::Epsilon0, 0.005, 0.1),
            ] {
                set = set.with(parameter, f64::from(noise.within(low, high)));
            }
            let shared = tribochaos::backend::gpu::reduced::layout::Parameters::new(&set, &settings);
            let parameters: [f32; 11] = bytemuck::cast(shared);
            let v = if noise.unit() < 0.5 {
                shared.epsilon_0 * noise.within(-1.5, 1.5)
            } else {
                noise.within(-4.0, 4.0)
            };
            let w = (shared.omega_k - v) * unit as f32;
            let mut sample = [0.0; 16];
            sample[..11].copy_from_slice(&parameters);
            sample[11..].copy_from_slice(&[
                noise.within(-1.5, 1.5),
                w,
                0.0,
                noise.within(-1.0, 1.0),
                noise.within(-0.1, 0.1),
            ]);
            sample
        })
        .collect();
    for lanes in Lanes::ALL {
        assert_taylor_steps(&samples, &probed(&context, Scheme::Taylor, lanes, PROBE, &samples));
    }
}

fn assert_taylor_steps(samples: &[[f32; 16]], probes: &[[f32; 9]]) {
    let mut different_pieces = 0;
    let mut worst = [0f32; 9];
    for (sample, probe) in samples.iter().zip(probes) {
        let value = |parameter| match parameter {
            Parameter::ZetaK => sample[0],
            Parameter::H1 => sample[1],
            Parameter::OmegaK => sample[2],
            Parameter::B => sample[3],
            Parameter::Epsilon => sample[4],
            Parameter::F0 => sample[5],
            Parameter::Alpha => sample[6],
            Parameter::Beta => sample[7],
            Parameter::Epsilon0 => sample[8],
            other => unreachable!("the equations of motion do not contain {other}"),
        };
        let flow = Flow::<f32>::new(value, sample[10], sample[9]);
        let start = flow.start(sample[11], sample[12], Ticks::splat(f32::PERIOD_TICKS));
        let (step, end) = taylor::step::<f32, COEFFICIENTS, true>(&flow, &start);
        let first = Vector {
            x: sample[14],
            y: sample[15],
        };
        let vector = step.series.vector_at(first, step.s);
        let second = step.series.vector_at(taylor::growth::Area::new(first).second, step.s);
        let values = [
            end.x,
            end.w,
            end.piece,
            end.left as f32 / taylor::ticks_per_unit::<f32>() as f32,
            taylor::turning(&step, &end),
            vector.x,
            vector.y,
            step.series.divergence_to(step.s),
            vector.x * second.y - vector.y * second.x,
        ];
        // a step that ends at a boundary in one of the two and just before it in the other is no fault
        if probe[2] != values[2] {
            different_pieces += 1;
            continue;
        }
        for i in 0..9 {
            let error = (probe[i] - values[i]).abs();
            assert!(
                error.is_finite(),
                "output {i}: {} for {} at {sample:?}",
                probe[i],
                values[i]
            );
            worst[i] = worst[i].max(error);
        }
    }
    println!("{worst:?}, {different_pieces} pieces differ");
    assert!(different_pieces < SAMPLES / 500, "{different_pieces} pieces differ");
    assert!(worst.iter().all(|&error| error < 2e-4), "{worst:?}");
}

#[test]
fn runaways_are_told_also_where_compilers_assume_that_there_is_no_nan() {
    const PROBE: &str = "
struct Sample { x: Real, y: Real }
@group(0) @binding(10) var<storage, read> samples: array<Sample>;
@group(0) @binding(11) var<storage, read_write> probes: array<Word>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    probes[thread.x] = select(Word(0u), Word(1u), has_run_away(samples[thread.x].x, samples[thread.x].y));
}
";
    let Some(context) = gpu_context::open() else { return };
    let (bound, nan, infinity) = (RUNAWAY_BOUND as f32, f32::NAN, f32::INFINITY);
    let cases = [
        ([0.0, 0.0], false),
        ([-1.0, 1e-40], false),
        ([bound - 1.0, -0.5], false),
        ([-bound, 0.0], true),
        ([bound / 2.0, -bound / 2.0], true),
        ([f32::MAX, f32::MAX], true),
        ([0.0, -infinity], true),
        ([infinity, -infinity], true),
        ([nan, 0.0], true),
        ([0.0, -nan], true),
        ([nan, infinity], true),
    ];
    let mut samples = vec![[0.0; 2]; 128];
    for (sample, (case, _)) in samples.iter_mut().zip(&cases) {
        *sample = *case;
    }
    for lanes in Lanes::ALL {
        let probes: Vec<[f32; 1]> = probed(&context, Scheme::Rk4, lanes, PROBE, &samples);
        for ([probe], (case, expected)) in probes.iter().zip(cases) {
            assert_eq!(probe.to_bits(), u32::from(expected), "{case:?}");
        }
    }
}

/// What the scheme's shader with a probing kernel makes of the samples.
fn probed<const I: usize, const O: usize>(
    context: &GpuContext,
    scheme: Scheme,
    lanes: Lanes,
    probe: &str,
    samples: &[[f32; I]],
) -> Vec<[f32; O]> {
    let shader = Shader::of(scheme);
    let source = shader.source(Shape { lanes, modes: None }) + probe;
    let constants = shader.constants(Kernel::Checked, 64);
    evaluate(context, &source, &constants, lanes.count() as usize, samples)
}
