//! Holds shaders and Rust together without a GPU: layouts, bindings, constants, twin functions, and translation to
//! every target language.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::mem::offset_of;

use bytemuck::Zeroable;
use naga::back::{PipelineConstants, hlsl, msl, pipeline_constants, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ScalarKind, ShaderStage, TypeInner};
use tribochaos::backend::gpu::layout::{self, Orbit, Parameters, Run, Span, Totals, binding};
use tribochaos::backend::gpu::rubbed::shader_source as rubbed;
use tribochaos::backend::gpu::shader_source::{self, Kernel, Shader};
use tribochaos::dynamics::taylor;

/// The module of every shader.
fn modules() -> impl Iterator<Item = (&'static Shader, Module)> {
    Shader::all().map(|(_, shader)| {
        let parsed = naga::front::wgsl::parse_str(shader.source);
        let module = parsed.unwrap_or_else(|error| panic!("{}", error.emit_to_string(shader.source)));
        (shader, module)
    })
}

/// Valid with nothing beyond what every WebGPU device has.
fn validated(shader: &Shader, module: &Module) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(shader.source)))
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
            steps_per_period,
            renormalise_every,
            unrecorded,
            period_tolerance
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
            step_size,
            unit_of_time
        }),
        layout_of!(Orbit {
            x,
            y,
            first_x,
            first_y,
            second_x,
            second_y,
            x_min,
            x_max,
            candidates,
            runaway_period,
            under_resolved
        }),
        layout_of!(Totals {
            growth_first,
            growth_second,
            birkhoff,
            divergence
        }),
    ])
}

fn scalar_name(inner: &TypeInner) -> String {
    match inner {
        TypeInner::Scalar(scalar) if scalar.width == 4 => match scalar.kind {
            ScalarKind::Float => "f32".to_owned(),
            ScalarKind::Uint => "u32".to_owned(),
            ScalarKind::Sint => "i32".to_owned(),
            other => panic!("a shared struct holds a {other:?}"),
        },
        other => panic!("a shared struct holds {other:?}, which is no scalar of 4 bytes"),
    }
}

#[test]
fn shared_structs_are_laid_out_alike() {
    for (_, module) in modules() {
        assert_layouts(&module);
    }
}

fn assert_layouts(module: &Module) {
    let rust = rust_layouts();
    let mut compared = BTreeSet::new();
    for (_, global) in module.global_variables.iter() {
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
    for (_, module) in modules() {
        assert_bindings(&module);
    }
}

fn assert_bindings(module: &Module) {
    let found: BTreeMap<u32, (String, AddressSpace)> = module
        .global_variables
        .iter()
        .map(|(_, global)| {
            let resource = global.binding.unwrap();
            assert_eq!(resource.group, 0);
            (resource.binding, (global.name.clone().unwrap(), global.space))
        })
        .collect();
    let storage = |write: bool| AddressSpace::Storage {
        access: naga::StorageAccess::LOAD
            | if write {
                naga::StorageAccess::STORE
            } else {
                naga::StorageAccess::empty()
            },
    };
    let expected = BTreeMap::from(
        [
            (binding::RUN, "run", AddressSpace::Uniform),
            (binding::SPAN, "span", AddressSpace::Uniform),
            (binding::DRIVE, "drive", AddressSpace::Uniform),
            (binding::BIRKHOFF_WEIGHTS, "birkhoff_weights", storage(false)),
            (binding::PARAMETERS, "parameters", storage(false)),
            (binding::ORBITS, "orbits", storage(true)),
            (binding::TOTALS, "totals", storage(true)),
            (binding::LAST_STATES, "last_states", storage(true)),
        ]
        .map(|(number, name, space)| (number, (name.to_owned(), space))),
    );
    assert_eq!(found, expected);
}

#[test]
fn the_drive_table_is_as_long_as_the_host_makes_it() {
    let (_, module) = modules().next().unwrap();
    let (_, drive) = module
        .global_variables
        .iter()
        .find(|(_, global)| global.name.as_deref() == Some("drive"))
        .unwrap();
    let bytes = module.types[drive.ty].inner.size(module.to_ctx());
    let entries = layout::drive_entries(8192);
    assert_eq!(bytes as usize, size_of_val(&entries[..]));
    assert!(entries.iter().flatten().flatten().filter(|sin| **sin != 0.0).count() > 16000);
}

#[test]
fn every_constant_is_set_and_every_kernel_exists() {
    for (_, module) in modules() {
        assert_constants_and_kernels(&module);
    }
}

fn assert_constants_and_kernels(module: &Module) {
    let names: BTreeSet<_> = module
        .overrides
        .iter()
        .map(|(_, constant)| constant.name.clone().unwrap())
        .collect();
    let set: BTreeSet<_> = shader_source::constants(64)
        .map(|(name, _)| name.to_owned())
        .into_iter()
        .collect();
    assert_eq!(names, set);
    let entry_points: Vec<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(entry_points, Kernel::ALL.map(Kernel::entry_point));
}

#[test]
fn every_kernel_translates_to_every_target_language() {
    for (shader, module) in modules() {
        assert_translates(shader, &module);
    }
}

fn assert_translates(shader: &Shader, module: &Module) {
    let info = validated(shader, module);
    let constants: PipelineConstants = shader_source::constants(64)
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect();
    for kernel in Kernel::ALL {
        let entry = (ShaderStage::Compute, kernel.entry_point());
        let (module, info) = pipeline_constants::process_overrides(module, &info, Some(entry), &constants).unwrap();
        let entry_point = (ShaderStage::Compute, kernel.entry_point().to_owned());

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

/// Functions of a twin pair that only the Rust side has, and why.
const RUST_ONLY: &[(&str, &str, &str)] = &[
    (
        "model/motion",
        "by_phase",
        "for vectors along the flow, which only the f64 reference carries",
    ),
    ("model/friction", "cubic", "an accessor"),
    ("model/friction", "epsilon_0", "an accessor"),
    ("model/friction", "layer_rate", "an accessor"),
    ("model/rubbing", "heat_modes", "the host finds the modes"),
    ("dynamics/decay", "empty", "for arrays that are not filled yet"),
    ("dynamics/matrix", "cofactor", "of an inverse that WGSL writes out"),
    ("dynamics/matrix", "dot", "built into WGSL"),
    ("dynamics/matrix", "apply", "built into WGSL"),
    ("dynamics/matrix", "product", "built into WGSL"),
    ("dynamics/radau", "constants", "the shader writes its constants out"),
    ("dynamics/radau", "cardinal", "the shader writes its constants out"),
    ("dynamics/radau", "hermite", "the shader writes its constants out"),
    ("dynamics/radau", "hermite_slope", "the shader writes its constants out"),
    (
        "dynamics/adaptive",
        "start",
        "the host starts orbits, tangents and peaks",
    ),
    ("dynamics/adaptive", "period", "the kernel's loop"),
    (
        "dynamics/adaptive",
        "part_of_period",
        "the kernel's loop, over whole periods",
    ),
    ("dynamics/adaptive", "y", "the host reads it from v"),
    ("dynamics/adaptive", "time", "for histories, which the CPU computes"),
    ("dynamics/adaptive", "pressure", "for histories"),
    ("dynamics/adaptive", "surface_temperature", "for histories"),
    ("dynamics/adaptive", "wear", "the host reads it from the fit"),
    ("dynamics/adaptive", "running_mask", "there are no lanes to wait for"),
    ("dynamics/tangent", "start", "the host starts the vectors"),
    ("dynamics/tangent", "along", "the host starts the vectors"),
    ("dynamics/tangent", "from_lanes", "threads have no lanes"),
    ("dynamics/tangent", "lane", "threads have no lanes"),
    ("dynamics/taylor", "unit_of_time", "the host gives it to the shader"),
    ("dynamics/taylor", "longest_step", "the host gives it to the shader"),
    (
        "dynamics/stroboscope",
        "window",
        "the host tells the shader when the window begins",
    ),
    (
        "dynamics/stroboscope",
        "period",
        "the host reads the period from the candidates",
    ),
    ("dynamics/stroboscope", "candidates", "an accessor"),
    ("dynamics/stroboscope", "default", "the host starts the candidates"),
];

/// Name and text of every piece of a shader, once.
fn pieces() -> BTreeMap<&'static str, &'static str> {
    let all = Shader::all().flat_map(|(_, shader)| shader.pieces);
    all.chain(rubbed::PIECES).copied().collect()
}

/// The names after `fn `, tests left out.
fn functions(text: &str) -> BTreeSet<&str> {
    let code = text.split("#[cfg(test)]").next().unwrap();
    code.lines()
        .map(str::trim_start)
        .filter(|line| !line.starts_with("//"))
        .filter_map(|line| line.split_once("fn ").filter(|(before, _)| !before.contains('(')))
        .filter_map(|(_, rest)| rest.split(['(', '<']).next())
        .collect()
}

/// A shader's names share one space, so that some carry their type's or their module's name before the Rust name.
fn is_twin(wgsl: &str, rust: &str) -> bool {
    wgsl == rust || wgsl.ends_with(&format!("_{rust}"))
}

#[test]
fn every_function_of_a_twin_exists_on_both_sides() {
    let root = env!("CARGO_MANIFEST_DIR");
    let mut pairs = 0;
    for (name, wgsl) in pieces() {
        let stem = name.strip_suffix(".wgsl").unwrap();
        if !["model/", "dynamics/"].iter().any(|folder| stem.starts_with(folder)) {
            continue;
        }
        let rust = fs::read_to_string(format!("{root}/src/{stem}.rs")).unwrap();
        let (rust, wgsl) = (functions(&rust), functions(wgsl));
        let alone: BTreeSet<_> = RUST_ONLY
            .iter()
            .filter(|exception| exception.0 == stem)
            .map(|exception| exception.1)
            .collect();
        for function in &wgsl {
            assert!(
                rust.iter().any(|twin| is_twin(function, twin)),
                "{stem}: only WGSL has {function}"
            );
        }
        let missing: BTreeSet<_> = rust
            .iter()
            .filter(|function| !wgsl.iter().any(|twin| is_twin(twin, function)))
            .copied()
            .collect();
        assert_eq!(missing, alone, "{stem}: functions that only Rust has");
        pairs += 1;
    }
    assert_eq!(pairs, 13);
}

#[test]
fn every_shader_file_is_compiled() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
    let mut files = BTreeSet::new();
    let mut folders = vec![std::path::PathBuf::from(root)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let parts = path.strip_prefix(root).unwrap().iter();
                files.insert(parts.map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"));
            }
        }
    }
    assert_eq!(files, pieces().into_keys().map(str::to_owned).collect());
}

/// `TRIBOCHAOS_UPDATE_SHADERS=1` writes it anew instead.
#[test]
fn the_generated_shader_is_what_the_recurrences_print() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/generated/taylor.wgsl");
    let text = taylor::wgsl::source();
    if std::env::var_os("TRIBOCHAOS_UPDATE_SHADERS").is_some() {
        fs::write(file, &text).unwrap();
    }
    assert!(
        fs::read_to_string(file).unwrap() == text,
        "{file} is out of date: TRIBOCHAOS_UPDATE_SHADERS=1 cargo test --test shader_contract, and build again"
    );
}
