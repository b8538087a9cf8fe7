//! Holds the shader of the full model and Rust together without a GPU: layouts, bindings, constants, and translation to
//! every target language. Its twin functions are held by `shader_contract`.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;

use bytemuck::Zeroable;
use naga::back::{PipelineConstants, hlsl, msl, pipeline_constants, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ScalarKind, ShaderStage, StorageAccess, TypeInner};
use tribochaos::backend::gpu::layout::Span;
use tribochaos::backend::gpu::rubbed::layout::{HeatMode, Orbit, Parameters, Run, Totals, binding};
use tribochaos::backend::gpu::rubbed::shader_source;
use tribochaos::experiment::MAX_MODES;

fn module(modes: u32) -> Module {
    let source = shader_source::source(modes);
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)))
}

/// Valid with nothing beyond what every WebGPU device has.
fn validated(module: &Module) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string("")))
}

/// Name, offset and type of every field, and the whole size.
type Layout = (Vec<(String, usize, String)>, usize);

macro_rules! layout_of {
    ($type:ident { $($field:ident),* $(,)? }) => {{
        // naming every field here makes one that is left out a compile error
        let $type { $($field),* } = $type::zeroed();
        let fields = vec![$((
            stringify!($field).to_owned(),
            offset_of!($type, $field),
            std::any::type_name_of_val(&$field).to_owned(),
        )),*];
        (stringify!($type), (fields, size_of::<$type>()))
    }};
}

fn rust_layouts() -> BTreeMap<&'static str, Layout> {
    BTreeMap::from([
        layout_of!(Run {
            instances,
            unrecorded,
            period_tolerance,
            tolerance,
            longest
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
            candidates,
            under_resolved,
            runaway,
            given_up_period
        }),
        layout_of!(Totals { growth, birkhoff }),
    ])
}

fn scalar_name(inner: &TypeInner) -> String {
    match inner {
        TypeInner::Scalar(scalar) if scalar.width == 4 => match scalar.kind {
            ScalarKind::Float => "f32".to_owned(),
            ScalarKind::Uint => "u32".to_owned(),
            other => panic!("a shared struct holds a {other:?}"),
        },
        other => panic!("a shared struct holds {other:?}, which is no scalar of 4 bytes"),
    }
}

#[test]
fn shared_structs_are_laid_out_alike() {
    let module = module(8);
    let rust = rust_layouts();
    let mut compared = BTreeSet::new();
    for (_, global) in module.global_variables.iter() {
        if global.binding.is_none() {
            continue;
        }
        let element = match module.types[global.ty].inner {
            TypeInner::Array { base, .. } => base,
            _ => global.ty,
        };
        let ty = &module.types[element];
        let TypeInner::Struct { members, span } = &ty.inner else {
            continue;
        };
        let name = ty.name.as_deref().unwrap();
        let fields = members
            .iter()
            .map(|member| {
                (
                    member.name.clone().unwrap(),
                    member.offset as usize,
                    scalar_name(&module.types[member.ty].inner),
                )
            })
            .collect();
        let wgsl: Layout = (fields, *span as usize);
        assert_eq!(rust.get(name), Some(&wgsl), "{name}");
        compared.insert(name);
    }
    assert!(compared.iter().eq(rust.keys()), "only {compared:?} were compared");
}

#[test]
fn bindings_have_the_host_s_numbers_and_kinds() {
    let module = module(8);
    let found: BTreeMap<u32, (String, AddressSpace)> = module
        .global_variables
        .iter()
        .filter_map(|(_, global)| Some((global.binding?, global)))
        .map(|(resource, global)| {
            assert_eq!(resource.group, 0);
            (resource.binding, (global.name.clone().unwrap(), global.space))
        })
        .collect();
    let read = AddressSpace::Storage {
        access: StorageAccess::LOAD,
    };
    let read_write = AddressSpace::Storage {
        access: StorageAccess::LOAD | StorageAccess::STORE,
    };
    let expected = BTreeMap::from(
        [
            (binding::RUN, "run", AddressSpace::Uniform),
            (binding::SPAN, "span", AddressSpace::Uniform),
            (binding::BIRKHOFF_WEIGHTS, "birkhoff_weights", read),
            (binding::PARAMETERS, "parameters", read),
            (binding::HEAT_MODES, "heat_modes", read),
            (binding::MODES, "mode_states", read_write),
            (binding::LAST_STATES, "last_states", read_write),
            (binding::ORBITS, "orbits", read_write),
            (binding::TOTALS, "totals", read_write),
        ]
        .map(|(number, name, space)| (number, (name.to_owned(), space))),
    );
    assert_eq!(found, expected);
}

#[test]
fn every_constant_is_set_and_the_kernel_exists() {
    let module = module(8);
    let names: BTreeSet<_> = module
        .overrides
        .iter()
        .map(|(_, constant)| constant.name.clone().unwrap())
        .collect();
    let set: BTreeSet<_> = shader_source::constants(64, true)
        .map(|(name, _)| name.to_owned())
        .into_iter()
        .collect();
    assert_eq!(names, set);
    let entry_points: Vec<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(entry_points, [shader_source::ENTRY_POINT]);
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
        let info = validated(&module);
        for carries_tangent in [false, true] {
            let constants: PipelineConstants = shader_source::constants(64, carries_tangent)
                .into_iter()
                .map(|(name, value)| (name.to_owned(), value))
                .collect();
            let name = shader_source::ENTRY_POINT;
            let entry = Some((ShaderStage::Compute, name));
            let (module, info) = pipeline_constants::process_overrides(&module, &info, entry, &constants).unwrap();
            let entry_point = (ShaderStage::Compute, name.to_owned());

            let options = spv::PipelineOptions {
                shader_stage: entry_point.0,
                entry_point: entry_point.1.clone(),
            };
            let words = spv::write_vec(&module, &info, &spv::Options::default(), Some(&options)).unwrap();
            assert_eq!(words[0], 0x0723_0203);

            let options = msl::PipelineOptions {
                entry_point: Some(entry_point.clone()),
                ..Default::default()
            };
            let (text, _) = msl::write_string(&module, &info, &msl::Options::default(), &options).unwrap();
            assert!(text.contains("kernel void"));

            let options = hlsl::PipelineOptions {
                entry_point: Some(entry_point),
            };
            let mut text = String::new();
            hlsl::Writer::new(&mut text, &hlsl::Options::default(), &options)
                .write(&module, &info, None)
                .unwrap();
            assert!(text.contains("numthreads(64, 1, 1)"));
        }
    }
}
