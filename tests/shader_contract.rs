//! Holds shaders and Rust together without a GPU: layouts, bindings, constants, twin functions, and translation to
//! every target language.

#![cfg(feature = "gpu")]

mod reflection;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use naga::Module;
use tribochaos::backend::gpu::layout::Span;
use tribochaos::backend::gpu::reduced::layout::{self, BINDINGS, Orbit, Parameters, Run, Totals};
use tribochaos::backend::gpu::shader_source::{Lanes, Shader, Shape};
use tribochaos::dynamics::taylor;
use tribochaos::experiment::Scheme;

use reflection::{Layout, layout_of, parsed, validated};

/// Every shader of the reduced model, and its text for every number of lanes.
fn sources() -> impl Iterator<Item = (&'static Shader, String)> {
    let shaders = [Scheme::Rk4, Scheme::Taylor].map(Shader::of);
    shaders
        .into_iter()
        .flat_map(|shader| Lanes::ALL.map(|lanes| (shader, shader.source(Shape { lanes, modes: None }))))
}

/// The module of each.
fn modules() -> impl Iterator<Item = Module> {
    sources().map(|(_, source)| parsed(&source))
}

fn rust_layouts() -> BTreeMap<&'static str, Layout> {
    BTreeMap::from([
        layout_of!(Run {
            instances,
            steps_per_period,
            renormalise_every,
            unrecorded,
            window,
            max_period,
            period_tolerance
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
            step_units,
            unit_of_time
        }),
        layout_of!(Orbit {
            x,
            y,
            x_min,
            x_max,
            period,
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

#[test]
fn shared_structs_are_laid_out_alike() {
    for module in modules() {
        reflection::assert_layouts(&module, &rust_layouts());
    }
}

#[test]
fn bindings_have_the_host_s_numbers_and_kinds() {
    for module in modules() {
        let all_bound = module
            .global_variables
            .iter()
            .all(|(_, global)| global.binding.is_some());
        assert!(all_bound, "there are no variables but those that are shared");
        reflection::assert_bindings(&module, &BINDINGS);
    }
}

#[test]
fn the_drive_table_is_as_long_as_the_host_makes_it() {
    let module = modules().next().unwrap();
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
    for (shader, source) in sources() {
        reflection::assert_constants_and_kernels(&parsed(&source), shader);
    }
}

#[test]
fn every_kernel_translates_to_every_target_language() {
    for (shader, source) in sources() {
        let module = parsed(&source);
        let info = validated(&module, &source);
        reflection::assert_translates(&module, &info, shader);
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
    ("dynamics/decay", "single", "shaders are in single precision"),
    ("dynamics/decay", "empty", "for arrays that are not filled yet"),
    ("dynamics/dense", "coefficients", "WGSL has no private fields"),
    ("dynamics/matrix", "cofactor", "of an inverse that WGSL writes out"),
    ("dynamics/matrix", "dot", "built into WGSL"),
    ("dynamics/matrix", "apply", "built into WGSL"),
    ("dynamics/matrix", "product", "built into WGSL"),
    ("dynamics/radau", "constants", "the shader writes its constants out"),
    ("dynamics/radau", "cardinal", "the shader writes its constants out"),
    ("dynamics/radau", "hermite", "the shader writes its constants out"),
    ("dynamics/radau", "hermite_slope", "the shader writes its constants out"),
    ("dynamics/adaptive/accepted", "start", "the host starts peaks"),
    ("dynamics/adaptive", "mode", "the host converts pressures and modes"),
    ("dynamics/adaptive", "heat", "the host starts orbits and tangents"),
    ("dynamics/adaptive", "mode_count", "the shader has a constant for it"),
    ("dynamics/adaptive/tangent", "at", "the host starts tangents"),
    ("dynamics/adaptive/tangent", "components", "the host reads the vectors"),
    (
        "dynamics/adaptive/tangent",
        "orthonormalise",
        "the shader carries one vector",
    ),
    ("dynamics/adaptive/tangent", "subtract", "the shader carries one vector"),
    ("dynamics/adaptive/tangent", "dot", "the shader carries one vector"),
    ("dynamics/adaptive/orbit", "start", "the host starts orbits"),
    ("dynamics/adaptive/orbit", "resumed", "the host starts orbits"),
    ("dynamics/adaptive/orbit", "begin_run", "the host starts orbits"),
    ("dynamics/adaptive/orbit", "mode_pressures", "the host reads the modes"),
    (
        "dynamics/adaptive/orbit",
        "heat_sums",
        "the shader has them as variables",
    ),
    ("dynamics/radau", "parts", "the shader names them one by one"),
    ("model/rubbing", "spectrum", "the host finds the modes"),
    ("model/rubbing", "has_ramp_ended", "the host decides"),
    ("model/rubbing", "is_warm", "the host decides"),
    ("dynamics/adaptive/orbit", "y", "the host reads it from v"),
    (
        "dynamics/adaptive/orbit",
        "time",
        "for histories, which the CPU computes",
    ),
    ("dynamics/adaptive/orbit", "pressure", "for histories"),
    ("dynamics/adaptive/orbit", "surface_temperature", "for histories"),
    ("dynamics/adaptive/orbit", "wear", "the host reads it from the fit"),
    ("dynamics/tangent", "start", "the host starts the vectors"),
    (
        "dynamics/divergence_check",
        "is_checked",
        "the host dispatches the kernel",
    ),
    ("dynamics/divergence_check", "alike", "the host sizes the dispatches"),
    ("dynamics/tangent", "from_lanes", "threads have no lanes"),
    ("dynamics/tangent", "lane", "threads have no lanes"),
    ("dynamics/adaptive/tangent", "in_plane", "the host reads the vectors"),
    (
        "dynamics/adaptive/tangent",
        "take_divergence",
        "only the CPU sums the divergence up",
    ),
    ("dynamics/radau", "divergence", "only the CPU sums the divergence up"),
    ("dynamics/taylor", "ticks_per_unit", "the shader has one number type"),
    (
        "dynamics/taylor",
        "is_layer_resolved",
        "the host marks what is not resolved",
    ),
    ("model/rubbing", "none", "the host chooses the modes"),
    (
        "model/friction",
        "thinnest_layer",
        "the host marks what is not resolved",
    ),
    ("dynamics/taylor", "of", "the shader has instances in lanes"),
    ("dynamics/taylor", "unit_of_time", "the host gives it to the shader"),
    (
        "dynamics/taylor",
        "longest_step_units",
        "the host gives it to the shader",
    ),
    (
        "dynamics/stroboscope",
        "window",
        "the host tells the shader when the window begins",
    ),
    ("dynamics/stroboscope", "most_states", "the host sizes the buffer"),
    ("dynamics/stroboscope", "periods", "threads have no lanes"),
    ("dynamics/stroboscope", "default", "the host allocates the states"),
];

/// Name and text of every file that shaders are made of, once.
fn source_files() -> BTreeMap<&'static str, &'static str> {
    let of_schemes = Scheme::ALL.into_iter().flat_map(|scheme| Shader::of(scheme).files);
    of_schemes.copied().chain(Lanes::ALL.map(Lanes::file)).collect()
}

/// The names after `fn `, tests left out.
fn functions(text: &str) -> BTreeSet<&str> {
    let code = text.split("#[cfg(test)]").next().unwrap();
    code.lines()
        .map(str::trim_start)
        .filter(|line| !line.starts_with("//"))
        .map(|line| line.strip_prefix("pub(super) ").unwrap_or(line))
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
    for (name, wgsl) in source_files() {
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
    assert_eq!(pairs, 19);
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
    assert_eq!(files, source_files().into_keys().map(str::to_owned).collect());
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
