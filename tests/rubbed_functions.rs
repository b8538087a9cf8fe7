//! Twins of the full model give the same values: their functions on random inputs.

#![cfg(feature = "gpu")]

mod gpu_context;
mod probe;

use tribochaos::backend::gpu::shader_source::{Kernel, Lanes, Shader, Shape};
use tribochaos::dynamics::decay::{Decay, decay};
use tribochaos::dynamics::dense::Cubic;
use tribochaos::dynamics::radau::{self, Drive, Heat, Memory, NODES, Perturbation, Start};
use tribochaos::experiment::Scheme;
use tribochaos::lanes::Real;
use tribochaos::model::rubbing::Rubbing;
use tribochaos::parameters::Parameter;

use probe::{Noise, evaluate};

const SAMPLES: usize = 64 * 128;

/// Heat modes of a probed instance, without the lumped one.
const MODES: u32 = 2;

fn probed<const I: usize, const O: usize>(probe: &str, samples: &[[f32; I]]) -> Option<Vec<[f32; O]>> {
    let context = gpu_context::open()?;
    let shader = Shader::of(Scheme::Radau);
    let shape = Shape {
        lanes: Lanes::One,
        modes: Some(MODES),
    };
    let source = shader.source(shape) + probe;
    Some(evaluate(
        &context,
        &source,
        &shader.constants(Kernel::Tangent, 64),
        1,
        samples,
    ))
}

#[test]
fn decays_agree() {
    const PROBE: &str = "
@group(0) @binding(10) var<storage, read> samples: array<f32>;
@group(0) @binding(11) var<storage, read_write> probes: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let z = samples[thread.x];
    let decay = decay(z, 1.0 / z);
    probes[thread.x] = vec4(decay.factor, decay.moments);
}
";
    let mut noise = Noise(2);
    let samples: Vec<[f32; 1]> = (0..SAMPLES)
        .map(|_| [10f64.powf(2.5 * noise.unit() - 1.0 + 0.2) as f32 * if noise.unit() < 0.2 { 1e-4 } else { 1.0 }])
        .collect();
    let Some(probes) = probed::<1, 4>(PROBE, &samples) else {
        return;
    };
    for ([z], probe) in samples.iter().zip(&probes) {
        let Decay { factor, moments } = decay(f64::from(*z), 1.0 / f64::from(*z));
        assert!((f64::from(probe[0]) - factor).abs() < 1e-5 * factor + 1e-7, "{z}");
        for k in 0..3 {
            let error = f64::from(probe[1 + k]) / moments[k] - 1.0;
            assert!(error.abs() < 1e-4, "moment {k} at {z}: {error:e}");
        }
    }
}

#[test]
fn crossings_and_maxima_of_cubics_agree() {
    const PROBE: &str = "
struct Sample { start: f32, first: f32, second: f32, last: f32, level: f32 }
struct Probe { crossing: f32, value: f32, s: f32, beyond: f32 }
@group(0) @binding(10) var<storage, read> samples: array<Sample>;
@group(0) @binding(11) var<storage, read_write> probes: array<Probe>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let sample = samples[thread.x];
    let cubic = cubic_new(sample.start, vec3(sample.first, sample.second, sample.last));
    let greatest = maximum(cubic);
    let within = crossing(cubic, sample.level, NODE_0, NODE_1);
    probes[thread.x] = Probe(within, greatest.value, greatest.s, beyond(cubic, sample.last - 0.3, sample.last + 0.4));
}
";
    let mut noise = Noise(3);
    let samples: Vec<[f32; 5]> = (0..SAMPLES)
        .map(|i| {
            // half of the cubics rise all the way, the others turn
            let bend = if i % 2 == 0 { 0.05 } else { 3.0 };
            let start = noise.within(-1.0, 1.0);
            let [first, second, last] = NODES.map(|node| start + node as f32 + bend * noise.within(-1.0, 1.0));
            [
                start,
                first,
                second,
                last,
                first + (second - first) * noise.within(0.05, 0.95),
            ]
        })
        .collect();
    let Some(probes) = probed::<5, 4>(PROBE, &samples) else {
        return;
    };
    for (i, (sample, &[crossing, value, s, beyond])) in samples.iter().zip(&probes).enumerate() {
        let [start, first, second, last, level] = sample.map(f64::from);
        let cubic = Cubic::new(start, [first, second, last]);
        if i % 2 == 0 {
            let expected = cubic.crossing(level, NODES[0], NODES[1]);
            assert!(
                (f64::from(crossing) - expected).abs() < 1e-5,
                "{sample:?}: {crossing} {expected}"
            );
        }
        let (greatest, _) = cubic.maximum();
        assert!(
            (f64::from(value) - greatest).abs() < 1e-4,
            "{sample:?}: {value} {greatest}"
        );
        assert!((cubic.at(f64::from(s)) - greatest).abs() < 1e-4, "{sample:?}: {s}");
        // where the parabola only just comes to the level, rounding decides whether it does
        let foreseen = |shift: f64| cubic.beyond([last - 0.3 - shift, last + 0.4 + shift]);
        let (expected, spread) = (foreseen(0.0), (foreseen(-1e-5) - foreseen(1e-5)).abs());
        // a time that is many steps ahead does not matter
        let near = |time: f64| time.min(20.0);
        assert!(
            (near(f64::from(beyond)) - near(expected)).abs() < 1e-4 * near(expected) + spread,
            "{sample:?}: {beyond} {expected}"
        );
    }
}

#[test]
fn what_is_no_number_is_below_nothing() {
    const PROBE: &str = "
@group(0) @binding(10) var<storage, read> samples: array<vec2<f32>>;
@group(0) @binding(11) var<storage, read_write> probes: array<f32>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let sample = samples[thread.x];
    let all_below = all(are_below(vec3(abs(sample.x), 0.0, 0.0), vec3(sample.y)));
    probes[thread.x] = select(0.0, 1.0, is_below(abs(sample.x), sample.y)) + select(0.0, 2.0, all_below);
}
";
    let cases = [
        ([0.0, 1.0], 3.0),
        ([-1.0, 1.5], 3.0),
        ([2.0, 1.5], 0.0),
        ([f32::INFINITY, 1e9], 0.0),
        ([f32::NAN, 1e9], 0.0),
        ([-f32::NAN, 1e9], 0.0),
    ];
    let mut samples = vec![[0.0; 2]; 64];
    for (sample, (case, _)) in samples.iter_mut().zip(&cases) {
        *sample = *case;
    }
    let Some(probes) = probed::<2, 1>(PROBE, &samples) else {
        return;
    };
    for ([probe], (case, expected)) in probes.iter().zip(cases) {
        assert_eq!(*probe, expected, "{case:?}");
    }
}

/// A trial step and a perturbation carried over it.
const STEP_PROBE: &str = "
struct Sample {
    parameters: Parameters,
    x: f32, v: f32, shaft_speed: f32, fit: f32, contact: f32, h: f32,
    speed_0: f32, speed_1: f32, speed_2: f32, fit_0: f32, fit_1: f32, fit_2: f32, guess: f32,
    rate_0: f32, rate_1: f32, rate_2: f32, weight_0: f32, weight_1: f32, weight_2: f32,
    mode_0: f32, mode_1: f32, mode_2: f32,
    tangent_x: f32, tangent_v: f32, tangent_fit: f32, tangent_pressure: f32, tangent_falloff: f32, tangent_flux: f32,
}
struct Probe {
    converged: f32,
    x_0: f32, x_1: f32, x_2: f32, v_0: f32, v_1: f32, v_2: f32,
    pressure_0: f32, pressure_1: f32, pressure_2: f32, closed_0: f32, closed_1: f32, closed_2: f32,
    flux_0: f32, flux_1: f32, flux_2: f32, falloff_0: f32, falloff_1: f32, falloff_2: f32,
    heat_pressure: f32, heat_falloff: f32, worn: f32,
    tangent_x: f32, tangent_v: f32, tangent_fit: f32, tangent_pressure: f32, tangent_falloff: f32, tangent_flux: f32,
    tangent_flux_0: f32, tangent_flux_1: f32,
}
@group(0) @binding(10) var<storage, read> samples: array<Sample>;
@group(0) @binding(11) var<storage, read_write> probes: array<Probe>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn probe(@builtin(global_invocation_id) thread: vec3<u32>) {
    let sample = samples[thread.x];
    let rubbing = rubbing_new(sample.parameters);
    let h = sample.h;
    rates = array(sample.rate_0, sample.rate_1, sample.rate_2);
    inverse_rates = array(1.0 / sample.rate_0, 1.0 / sample.rate_1, 1.0 / sample.rate_2);
    weights = array(sample.weight_0, sample.weight_1, sample.weight_2);
    modes = array(sample.mode_0, sample.mode_1, sample.mode_2);
    var heat: Heat;
    for (var m = 0u; m < HEAT_MODES; m++) {
        heat.pressure += weights[m] * modes[m];
        heat.falloff += weights[m] * rates[m] * modes[m];
    }
    let piece = rubbing_piece(rubbing, piece_index(rubbing.friction, sample.v));
    let start = start_new(rubbing, piece, sample.x, sample.v, sample.shaft_speed, sample.fit, heat, sample.contact);
    let speed = vec3(sample.speed_0, sample.speed_1, sample.speed_2);
    let drive = Drive(h, speed, vec3(sample.fit_0, sample.fit_1, sample.fit_2));
    let memory = memory_new(h);
    let trial = solve(rubbing, start, drive, memory, vec3(sample.guess), 1e-5);
    let end = memory_end(memory, parabola(trial.flux));
    let falloff = trial_falloff(trial, rubbing, start, h, end);
    let tangent_heat = Heat(sample.tangent_pressure, sample.tangent_falloff);
    let at = Perturbation(sample.tangent_x, sample.tangent_v, sample.tangent_fit, tangent_heat, sample.tangent_flux);
    let after = perturbed(trial, rubbing, start, h, memory, at);
    probes[thread.x] = Probe(
        select(0.0, 1.0, trial.converged),
        trial.x[0], trial.x[1], trial.x[2], trial.v[0], trial.v[1], trial.v[2],
        trial.pressure[0], trial.pressure[1], trial.pressure[2],
        trial.if_closed[0], trial.if_closed[1], trial.if_closed[2],
        trial.flux[0], trial.flux[1], trial.flux[2], falloff[0], falloff[1], falloff[2],
        end.pressure, end.falloff, worn(trial, rubbing, h),
        after.end.x, after.end.v, after.end.fit, after.end.heat.pressure, after.end.heat.falloff, after.end.flux,
        after.flux[0], after.flux[1],
    );
}
";
const INPUTS: usize = 42;
const OUTPUTS: usize = 30;

fn rubbing<R: Real>(sample: &[R; INPUTS]) -> Rubbing<R> {
    Rubbing::new(|parameter| match parameter {
        Parameter::ZetaK => sample[0],
        Parameter::H1 => sample[1],
        Parameter::OmegaK => sample[2],
        Parameter::B => sample[3],
        Parameter::Epsilon => sample[4],
        Parameter::F0 => sample[5],
        Parameter::Alpha => sample[6],
        Parameter::Beta => sample[7],
        Parameter::Epsilon0 => sample[8],
        Parameter::Gamma => sample[9],
        Parameter::KW => sample[10],
        Parameter::RampRate => sample[11],
        other => unreachable!("the equations of motion do not contain {other}"),
    })
}

fn start<R: Real>(sample: &[R; INPUTS], rubbing: &Rubbing<R>) -> Start<R> {
    let (rates, weights, modes) = (&sample[27..30], &sample[30..33], &sample[33..36]);
    let zero = R::splat(0.0);
    let mut heat = Heat {
        pressure: zero,
        falloff: zero,
    };
    for m in 0..3 {
        heat.pressure = heat.pressure + weights[m] * modes[m];
        heat.falloff = heat.falloff + weights[m] * rates[m] * modes[m];
    }
    let [x, v, speed, fit, contact] = [14, 15, 16, 17, 18].map(|i| sample[i]);
    let above = |boundary: R| R::select(boundary.less(v), R::splat(1.0), zero);
    let piece = above(-rubbing.epsilon_0) + above(zero) + above(rubbing.epsilon_0);
    Start::new(rubbing, rubbing.piece(piece), x, v, speed, fit, heat, contact)
}

/// The fields of the shader's `Sample`, in order. Half of the states slide inside the friction layer, a tenth are in the
/// gap; steps are as short as a scheme would make them.
fn sample(noise: &mut Noise) -> [f32; INPUTS] {
    let epsilon_0 = 10f64.powf(-3.0 * noise.unit()) as f32;
    let v = if noise.unit() < 0.5 {
        epsilon_0 * noise.within(-0.9, 0.9)
    } else {
        let sign = if noise.unit() < 0.5 { 1.0 } else { -1.0 };
        sign * (1.1 * epsilon_0 + noise.within(0.1, 4.0))
    };
    let gamma = noise.within(0.0, 2.0);
    let mut sample = [0.0; INPUTS];
    sample[..14].copy_from_slice(&[
        noise.within(0.0, 12.0),
        noise.within(0.0, 2.0),
        noise.within(-1.0, 1.0),
        noise.within(0.5, 2.0),
        noise.within(0.05, 0.2),
        noise.within(0.1, 0.5),
        noise.within(0.0, 0.5),
        noise.within(0.1, 0.5),
        epsilon_0,
        gamma,
        if noise.unit() < 0.5 {
            0.0
        } else {
            noise.within(0.0, 0.05)
        },
        f32::MAX,
        3.0,
        0.5,
    ]);
    sample[14] = noise.within(-1.5, 1.5);
    sample[15] = v;
    sample[16] = v + noise.within(-2.0, 2.0);
    sample[17] = noise.within(-5.0, 1.0);
    sample[18] = if noise.unit() < 0.1 { 0.0 } else { 1.0 };
    for (m, rate) in [0.5, 5.0, 100.0].into_iter().enumerate() {
        sample[27 + m] = rate * noise.within(0.5, 2.0);
        sample[30 + m] = 2.0 * gamma * noise.within(0.1, 0.5);
        sample[33 + m] = noise.within(5.0, 40.0) / sample[27 + m];
    }
    let acceleration = start(&sample, &rubbing(&sample)).acceleration;
    let drive = noise.within(-4.0, 4.0);
    let slides = (acceleration.abs() + drive.abs()).max(1e-3);
    let reach = if v.abs() < epsilon_0 { 0.1 * epsilon_0 } else { 0.05 };
    sample[19] = (reach / slides).min(0.1);
    for (i, node) in NODES.into_iter().enumerate() {
        sample[20 + i] = drive * sample[19] * node as f32;
        sample[23 + i] = 0.01 * sample[19] * node as f32;
    }
    sample[26] = acceleration;
    for value in &mut sample[36..] {
        *value = noise.within(-1.0, 1.0);
    }
    sample
}

/// What the shader's `Probe` is on the CPU.
fn expected<R: Real<Mask = bool>>(sample: &[f32; INPUTS]) -> [f64; OUTPUTS] {
    let sample = sample.map(|value| R::splat(value.into()));
    let rubbing = rubbing(&sample);
    let start = start(&sample, &rubbing);
    let h = sample[19];
    let three = |first: usize| [0, 1, 2].map(|i| sample[first + i]);
    let drive = Drive {
        h,
        speed: three(20),
        fit: three(23),
    };
    let (rates, weights, modes) = (three(27), three(30), three(33));
    let mut steps = [Decay::<R>::empty(); 3];
    let inverse_rates = rates.map(|rate| R::splat(1.0) / rate);
    let memory = Memory::new(h, &rates, &inverse_rates, &weights, &modes, &mut steps);
    let trial = radau::solve(&rubbing, &start, &drive, &memory, [sample[26]; 3], R::splat(1e-5));
    let end = memory.end(radau::parabola(trial.flux));
    let falloff = trial.falloff(&rubbing, &start, h, end);
    let at = Perturbation {
        x: sample[36],
        v: sample[37],
        fit: sample[38],
        heat: Heat {
            pressure: sample[39],
            falloff: sample[40],
        },
        flux: sample[41],
    };
    let (after, flux) = trial.perturbed(&rubbing, &start, h, &memory, &at);
    let converged = R::select(trial.converged, R::splat(1.0), R::splat(0.0));
    let mut values = vec![converged];
    for nodes in [trial.x, trial.v, trial.pressure, trial.if_closed, trial.flux, falloff] {
        values.extend(nodes);
    }
    values.extend([end.pressure, end.falloff, trial.worn(&rubbing, h)]);
    values.extend([
        after.x,
        after.v,
        after.fit,
        after.heat.pressure,
        after.heat.falloff,
        after.flux,
    ]);
    values.extend(&flux[..2]);
    let values: Vec<f64> = values.into_iter().map(|value| value.lane(0)).collect();
    values.try_into().expect("as many as the shader's")
}

#[test]
fn a_trial_step_is_as_near_to_f64_as_f32_on_the_cpu_is() {
    let mut noise = Noise(4);
    let samples: Vec<[f32; INPUTS]> = (0..SAMPLES).map(|_| sample(&mut noise)).collect();
    let Some(probes) = probed::<INPUTS, OUTPUTS>(STEP_PROBE, &samples) else {
        return;
    };
    let mut errors = vec![[const { Vec::new() }; 2]; OUTPUTS];
    let mut unsettled = 0;
    for (sample, probe) in samples.iter().zip(&probes) {
        let (exact, single) = (expected::<f64>(sample), expected::<f32>(sample));
        if [exact[0], single[0], probe[0].into()] != [1.0; 3] {
            unsettled += 1;
            continue;
        }
        for i in 1..OUTPUTS {
            for (errors, value) in errors[i].iter_mut().zip([f64::from(probe[i]), single[i]]) {
                let error = (value - exact[i]).abs() / exact[i].abs().max(1e-3);
                errors.push(if error.is_nan() { f64::INFINITY } else { error });
            }
        }
    }
    assert!(unsettled < SAMPLES / 50, "{unsettled} of {SAMPLES}");
    for (i, [gpu, cpu]) in errors.iter_mut().enumerate().skip(1) {
        for errors in [&mut *gpu, &mut *cpu] {
            errors.sort_by(f64::total_cmp);
        }
        for (part, allowed) in [(0.5, 2.0), (0.9, 2.0), (0.99, 3.0)] {
            let [gpu, cpu] = [&*gpu, &*cpu].map(|errors| errors[(part * errors.len() as f64) as usize]);
            assert!(gpu < allowed * cpu + 1e-7, "output {i}, {part}: {gpu:e} for {cpu:e}");
        }
        assert!(gpu[gpu.len() / 2] < 1e-5, "output {i}: {:e}", gpu[gpu.len() / 2]);
    }
}
