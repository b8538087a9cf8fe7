//! Holds the shader of the full model and Rust together without a GPU: layouts, bindings, constants, and translation to
//! every target language. Its twin functions are held by `shader_contract`.

#![cfg(feature = "gpu")]

mod reflection;

use std::collections::BTreeMap;

use naga::Module;
use tribochaos::backend::gpu::layout::Span;
use tribochaos::backend::gpu::rubbed::layout::{BINDINGS, HeatMode, Orbit, Parameters, Run, Totals};
use tribochaos::backend::gpu::shader_source::{Lanes, Shader, Shape};
use tribochaos::experiment::{MAX_MODES, Scheme};

use reflection::{Layout, layout_of, parsed, validated};

fn shader() -> &'static Shader {
    Shader::of(Scheme::Radau)
}

fn source(modes: u32) -> String {
    shader().source(Shape {
        lanes: Lanes::One,
        modes: Some(modes),
    })
}

fn module(modes: u32) -> Module {
    parsed(&source(modes))
}

fn rust_layouts() -> BTreeMap<&'static str, Layout> {
    BTreeMap::from([
        layout_of!(Run {
            instances,
            unrecorded,
            window,
            max_period,
            period_tolerance,
            tolerance,
            newton,
            reach,
            longest_step_periods,
            swing
        }),
        layout_of!(Span {
            first_instance,
            instances,
            first,
            periods,
            elapsed,
            watched
        }),
        layout_of!(Parameters {
            zeta_k,
            h1,
            omega_k,
            b,
            epsilon,
            f_0,
            alpha,
            beta,
            epsilon_0,
            gamma,
            k_w,
            ramp_rate,
            period,
            surface_temperature
        }),
        layout_of!(HeatMode { rate, weight }),
        layout_of!(Orbit {
            x,
            v,
            fit,
            heat_pressure,
            heat_falloff,
            contact,
            sine,
            cosine,
            left,
            periods,
            step,
            piece,
            guess_0,
            guess_1,
            guess_2,
            guess_3,
            since,
            tangent_x,
            tangent_v,
            tangent_fit,
            tangent_pressure,
            tangent_falloff,
            tangent_flux,
            peak_pressure,
            peak_periods,
            peak_time,
            peak_temperature,
            lost_periods,
            lost_time,
            x_min,
            x_max,
            period,
            under_resolved,
            runaway,
            given_up_period,
            runaway_phase
        }),
        layout_of!(Totals { growth, birkhoff }),
    ])
}

#[test]
fn shared_structs_are_laid_out_alike() {
    reflection::assert_layouts(&module(8), &rust_layouts());
}

#[test]
fn bindings_have_the_host_s_numbers_and_kinds() {
    reflection::assert_bindings(&module(8), &BINDINGS);
}

#[test]
fn every_constant_is_set_and_the_kernel_exists() {
    reflection::assert_constants_and_kernels(&module(8), shader());
}

#[test]
fn loops_over_modes_are_written_out_once_for_each() {
    for modes in [1, 12, 32] {
        let source = source(modes);
        assert!(!source.contains("m < HEAT_MODES"));
        let loops = shader()
            .files
            .iter()
            .map(|(_, text)| text.matches("m < HEAT_MODES").count())
            .sum::<usize>();
        assert!(loops > 5);
        for m in 0..=modes {
            assert_eq!(source.matches(&format!("const m = {m}u;")).count(), loops);
        }
    }
    assert!(source(MAX_MODES).contains("m < HEAT_MODES"));
}

#[test]
fn the_kernel_translates_to_every_target_language_for_every_number_of_modes() {
    for modes in [1, 12, 32, MAX_MODES] {
        let module = module(modes);
        let info = validated(&module, &source(modes));
        reflection::assert_translates(&module, &info, shader());
    }
}
