//! Holds the shader of the full model and Rust together without a GPU: layouts, bindings, constants, and translation to
//! every target language. Its twin functions are held by `shader_contract`.

#![cfg(feature = "gpu")]

mod reflection;

use std::collections::BTreeMap;

use naga::{AddressSpace, Module};
use tribochaos::backend::gpu::layout::Span;
use tribochaos::backend::gpu::rubbed::layout::{HeatMode, Orbit, Parameters, Run, Totals, binding};
use tribochaos::backend::gpu::rubbed::shader_source;
use tribochaos::experiment::MAX_MODES;

use reflection::{Layout, READ, READ_WRITE, layout_of, parsed, validated};

fn module(modes: u32) -> Module {
    parsed(&shader_source::source(modes))
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
            longest,
            swing
        }),
        layout_of!(Span {
            first_instance,
            instances,
            first,
            periods,
            elapsed,
            measured
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
    reflection::assert_bindings(
        &module(8),
        [
            (binding::RUN, "run", AddressSpace::Uniform),
            (binding::SPAN, "span", AddressSpace::Uniform),
            (binding::BIRKHOFF_WEIGHTS, "birkhoff_weights", READ),
            (binding::PARAMETERS, "parameters", READ),
            (binding::HEAT_MODES, "heat_modes", READ),
            (binding::MODES, "mode_states", READ_WRITE),
            (binding::LAST_STATES, "last_states", READ_WRITE),
            (binding::ORBITS, "orbits", READ_WRITE),
            (binding::TOTALS, "totals", READ_WRITE),
        ],
    );
}

#[test]
fn every_constant_is_set_and_the_kernel_exists() {
    let constants = shader_source::constants(64, true);
    reflection::assert_constants_and_kernels(&module(8), &constants, &[shader_source::ENTRY_POINT]);
}

#[test]
fn loops_over_modes_are_written_out_once_for_each() {
    for modes in [1, 12, 32] {
        let source = shader_source::source(modes);
        assert!(!source.contains("m < HEAT_MODES"));
        let loops = shader_source::PIECES
            .iter()
            .map(|(_, text)| text.matches("m < HEAT_MODES").count())
            .sum::<usize>();
        assert!(loops > 5);
        for m in 0..=modes {
            assert_eq!(source.matches(&format!("const m = {m}u;")).count(), loops);
        }
    }
    assert!(shader_source::source(MAX_MODES).contains("m < HEAT_MODES"));
}

#[test]
fn the_kernel_translates_to_every_target_language_for_every_number_of_modes() {
    for modes in [1, 12, 32, MAX_MODES] {
        let module = module(modes);
        let info = validated(&module, &shader_source::source(modes));
        for carries_tangent in [false, true] {
            let constants = shader_source::constants(64, carries_tangent);
            reflection::assert_translates(&module, &info, shader_source::ENTRY_POINT, &constants);
        }
    }
}
