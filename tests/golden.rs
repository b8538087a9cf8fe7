//! A coarse map against one that was checked in: nothing may move it unnoticed.
//!
//! `TRIBOCHAOS_UPDATE_GOLDEN=1 cargo test --test golden` writes it anew; say in the commit why it changed.

#![cfg(feature = "gpu")]

mod common;
mod gpu_context;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use common::{measure_on, pinned_settings};
use tribochaos::backend::Backend;
use tribochaos::backend::cpu::{CpuBackend, InstructionSet};
use tribochaos::backend::gpu::GpuBackend;
use tribochaos::design::{Axis, Design};
use tribochaos::experiment::Precision;
use tribochaos::measure::{Class, Measurement};
use tribochaos::parameters::{Parameter, ParameterSet};

/// One row of the golden file.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    /// None after a runaway.
    class: Option<Class>,
    lyapunov: f64,
    lyapunov_error: f64,
    period: Option<u32>,
}

impl From<&Measurement> for Row {
    fn from(m: &Measurement) -> Self {
        Self {
            class: m.class,
            lyapunov: m.lyapunov,
            lyapunov_error: m.lyapunov_error,
            period: m.period,
        }
    }
}

/// How far a map may be from the golden one.
struct Tolerance {
    /// Between the exponents of orbits that are regular in both.
    regular_exponent: f64,
    /// Between other exponents, in combined standard errors.
    combined_errors: f64,
    /// Share of the points that may break one of the rules.
    exceptions: f64,
}

fn grid() -> Design {
    let axis = |parameter, stop| Axis::even(parameter, 0.0, stop, 32).expect("within the range");
    Design::product(
        vec![axis(Parameter::ZetaK, 6.0), axis(Parameter::H1, 1.5)],
        ParameterSet::default().into(),
    )
}

fn map_on(backend: &mut dyn Backend) -> Vec<Row> {
    let grid = grid();
    let points: Vec<ParameterSet> = (0..grid.len()).map(|index| grid.point(index)).collect();
    measure_on(backend, &pinned_settings(), &points)
        .iter()
        .map(Row::from)
        .collect()
}

fn golden_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/zeta_k_h1_f64.csv")
}

fn write_golden(rows: &[Row]) {
    let grid = grid();
    let mut text = "zeta_k,h1,class,lyapunov,lyapunov_error,period\n".to_owned();
    for (index, row) in rows.iter().enumerate() {
        let p = grid.point(index);
        let class = row.class.map_or("", Class::name);
        let period = row.period.map_or(String::new(), |period| period.to_string());
        // eight decimals say more than any tolerance asks for
        let (lyapunov, error) = (row.lyapunov, row.lyapunov_error);
        let (zeta_k, h1) = (p[Parameter::ZetaK], p[Parameter::H1]);
        writeln!(text, "{zeta_k:.6},{h1:.6},{class},{lyapunov:.8},{error:.2e},{period}").expect("text grows");
    }
    let file = golden_file();
    fs::create_dir_all(file.parent().expect("a file has a folder")).expect("the folder can be made");
    fs::write(file, text).expect("the golden file can be written");
}

/// The golden rows; written first, once for all tests of the file, where the environment asks for that.
fn golden() -> &'static [Row] {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
        if std::env::var_os("TRIBOCHAOS_UPDATE_GOLDEN").is_some() {
            write_golden(&map_on(&mut CpuBackend::new(Precision::F64)));
        }
        read_golden()
    });
    &ROWS
}

fn read_golden() -> Vec<Row> {
    let text = fs::read_to_string(golden_file()).expect("the golden file is checked in");
    let rows = text.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let [_, _, class, lyapunov, lyapunov_error, period] = fields[..] else {
            panic!("six fields, not `{line}`");
        };
        Row {
            class: Class::ALL.into_iter().find(|known| known.name() == class),
            lyapunov: lyapunov.parse().expect("a number"),
            lyapunov_error: lyapunov_error.parse().expect("a number"),
            period: (!period.is_empty()).then(|| period.parse().expect("a number")),
        }
    });
    rows.collect()
}

/// What is wrong with a row, if anything.
fn fault(row: &Row, golden: &Row, tolerance: &Tolerance) -> Option<&'static str> {
    if row.class != golden.class {
        return Some("class");
    }
    let difference = (row.lyapunov - golden.lyapunov).abs();
    let allowed = match golden.class {
        None => return None,
        Some(Class::Regular) => tolerance.regular_exponent,
        Some(_) => tolerance.combined_errors * row.lyapunov_error.hypot(golden.lyapunov_error),
    };
    if row.period == golden.period {
        (difference > allowed).then_some("exponent")
    } else {
        Some("period")
    }
}

fn assert_golden(rows: &[Row], tolerance: &Tolerance, label: &str) {
    let golden = golden();
    assert_eq!(rows.len(), golden.len());
    let grid = grid();
    let mut faults = Vec::new();
    for (index, (row, golden)) in rows.iter().zip(golden).enumerate() {
        if let Some(what) = fault(row, golden, tolerance) {
            let p = grid.point(index);
            let (zeta_k, h1) = (p[Parameter::ZetaK], p[Parameter::H1]);
            faults.push(format!(
                "zeta_k = {zeta_k:.4}, h1 = {h1:.4}: {what}: {row:?}, golden {golden:?}"
            ));
        }
    }
    let allowed = (tolerance.exceptions * rows.len() as f64).floor() as usize;
    assert!(
        faults.len() <= allowed,
        "{label}: {} points of {} differ, {allowed} may:\n{}",
        faults.len(),
        rows.len(),
        faults.join("\n")
    );
}

/// Orbits that are chaotic, or have not settled when the run ends, follow the rounding of the instruction set (with or
/// without fused operations five points in a thousand change): a few may stand on the other side of a class's bound. A
/// change of the physics moves far more.
const F64: Tolerance = Tolerance {
    regular_exponent: 1e-6,
    combined_errors: 4.0,
    exceptions: 0.01,
};

#[test]
fn the_coarse_map_is_the_golden_one_on_every_instruction_set() {
    for instructions in InstructionSet::available() {
        let mut backend = CpuBackend::with_instructions(Precision::F64, instructions);
        assert_golden(&map_on(&mut backend), &F64, instructions.name());
    }
}

/// Rounding to f32 moves the points at which an orbit meets the friction layer, and with them the exponents of cycles. One
/// point in a hundred differs, by its class or by the multiple of the period that a barely stable cycle shows.
const F32: Tolerance = Tolerance {
    regular_exponent: 1e-3,
    combined_errors: 4.0,
    exceptions: 0.02,
};

#[test]
fn the_coarse_map_in_single_precision_is_close_to_the_golden_one() {
    assert_golden(&map_on(&mut CpuBackend::new(Precision::F32)), &F32, "f32");
}

#[test]
fn the_coarse_map_on_a_gpu_is_close_to_the_golden_one() {
    let Some(context) = gpu_context::open() else { return };
    assert_golden(&map_on(&mut GpuBackend::new(context)), &F32, "GPU");
}
