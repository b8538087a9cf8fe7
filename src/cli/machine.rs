//! `machine`: from SI units to the dimensionless parameters.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use serde_json::{Map, Value, json};

use super::json::JsonArgs;
use super::request::{self, SubjectArgs};
use super::{Failure, analysis};
use crate::design::Coordinate;
use crate::experiment::{Experiment, Request};
use crate::machine::units::si;
use crate::machine::{CONSTANTS, MATERIALS, Machine, SI_QUANTITIES, Scale, Sensitivities, TEMPLATE, sensitivities};
use crate::parameters::Parameter;

/// Prints the dimensionless parameters, the scales that convert results to SI units, warnings of unlikely values, and the
/// logarithmic sensitivities d ln(group)/d ln(quantity): by how many per cent a group changes if a quantity changes by one per
/// cent.
#[derive(Args)]
#[command(after_long_help = quantity_table())]
pub struct MachineArgs {
    /// The machine, as --template prints one
    file: Option<PathBuf>,
    /// Value of a quantity, instead of that in the file; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = request::assignment)]
    set: Vec<(Coordinate, f64)>,
    #[command(flatten)]
    json: JsonArgs,
    /// Print a complete file with comments, the machine of the paper's preset, and stop
    #[arg(long, conflicts_with_all = ["file", "set", "json", "materials"])]
    template: bool,
    /// Print the table of materials with their sources, and stop
    #[arg(long, conflicts_with_all = ["file", "set"])]
    materials: bool,
}

/// The table of quantities, for the end of the help.
fn quantity_table() -> String {
    let mut help =
        String::from("Quantities (those with two units per metre of contact length, or of the whole part):\n");
    for info in SI_QUANTITIES {
        let unit = match (info.unit, info.whole_unit) {
            ("1", _) => String::new(),
            (unit, None) => unit.to_owned(),
            (unit, Some(whole)) => format!("{unit} or {whole}"),
        };
        let _ = writeln!(
            help,
            "  {:<24}{:<4}{unit:<18}{} {}",
            info.name, info.symbol, info.meaning, info.source
        );
    }
    help.push_str(
        "\nmaterial gives youngs_modulus to thermal_diffusivity by its name. ambient_temperature (293.15 K), melting_point and\n\
         yield_strength, of the material unless given, are what results are judged by.\n",
    );
    help
}

pub fn run(args: &MachineArgs) -> Result<(), Failure> {
    if args.template {
        print_text!("{TEMPLATE}");
        return Ok(());
    }
    if args.materials {
        if args.json.wanted() {
            args.json.print(&materials_object());
        } else {
            print_text!("{}", materials());
        }
        return Ok(());
    }
    let subject = SubjectArgs {
        from: None,
        print_experiment: false,
        set: args.set.clone(),
        machine: args.file.clone(),
    };
    let missing = || Failure::Input(anyhow!("there is no machine: give its file; --template prints one"));
    if args.file.is_none() {
        return Err(missing());
    }
    let mut request = Request::default();
    subject.apply(&mut request)?;
    let experiment = request.resolve_point().map_err(Failure::input)?;
    let machine = experiment.design.fixed.machine().ok_or_else(missing)?;
    if args.json.wanted() {
        args.json.print(&object(&experiment, machine));
        return Ok(());
    }
    for warning in experiment.warnings() {
        eprintln!("warning: {warning}");
    }
    print_text!("{}", words(&experiment, machine));
    Ok(())
}

/// The parameters that the machine gives, in the table's order.
fn determined(experiment: &Experiment) -> impl Iterator<Item = (Parameter, f64)> + '_ {
    let is_determined = |parameter| experiment.design.fixed.governing(parameter).is_some();
    experiment
        .fixed_parameters()
        .filter(move |(parameter, _)| is_determined(*parameter))
}

fn words(experiment: &Experiment, machine: &Machine) -> String {
    let mut text = String::from("dimensionless parameters\n");
    for (parameter, value) in determined(experiment) {
        let info = parameter.info();
        let _ = writeln!(
            text,
            "  {:<12} {:<3} {value:<12.6} {}",
            info.name, info.symbol, info.meaning
        );
    }
    let scales = machine.scales();
    let _ = writeln!(
        text,
        "\nscales: a dimensionless result times its scale is one in SI units"
    );
    for (scale, symbol, of) in [
        (Scale::Time, "t*", "time"),
        (Scale::Temperature, "T*", "temperature above the ambient one"),
        (Scale::Pressure, "P*", "contact pressure"),
        (Scale::Length, "U*", "wear"),
    ] {
        let value = si(scales.of(scale), scale.unit());
        let _ = writeln!(text, "  {symbol:<16} {value:<12} {of}");
    }
    let _ = writeln!(text, "  {:<16} {:<12} sliding speed", "V*", si(scales.speed, "m/s"));
    let _ = writeln!(
        text,
        "\nk* {} per metre of contact; wells at angles of {:.3} rad, 1/sqrt(b)",
        si(machine.spring(), "N/m²"),
        1.0 / experiment.design.fixed[Parameter::B].sqrt()
    );
    let _ = writeln!(
        text,
        "\nlogarithmic sensitivities: per cent of a group for one per cent of a quantity (. for none)"
    );
    text + &table(&sensitivities(machine))
}

/// The sensitivities in two blocks that fit a terminal: one of the parameters, one of k* and the scales.
fn table(table: &Sensitivities) -> String {
    let mut text = String::new();
    let first_scale = table
        .groups
        .iter()
        .position(|group| group.name == "k_star")
        .unwrap_or(0);
    let cell = |value: f64| match value {
        value if value.is_nan() => "-".to_owned(),
        0.0 => ".".to_owned(),
        value => format!("{value:.2}"),
    };
    // wide enough that the widest cell stands apart from the one before it
    let width = |column: usize| {
        let widths = table.values.iter().map(|values| cell(values[column]).len() + 1);
        widths.max().unwrap_or(0).max(LEAST_COLUMN)
    };
    for columns in [0..first_scale, first_scale..table.groups.len()] {
        let _ = write!(text, "\n  {:<24}", "");
        for column in columns.clone() {
            let symbol = table.groups[column].symbol;
            // a combining mark takes no room
            let width = width(column) + symbol.chars().filter(|c| *c == '\u{303}').count();
            let _ = write!(text, "{symbol:>width$}");
        }
        text.push('\n');
        for (quantity, values) in table.quantities.iter().zip(&table.values) {
            if values[columns.clone()].iter().all(|value| *value == 0.0) {
                continue;
            }
            let _ = write!(text, "  {:<24}", quantity.name());
            for column in columns.clone() {
                let (cell, width) = (cell(values[column]), width(column));
                let _ = write!(text, "{cell:>width$}");
            }
            text.push('\n');
        }
    }
    text
}

/// Least width of a column of sensitivities.
const LEAST_COLUMN: usize = 6;

fn object(experiment: &Experiment, machine: &Machine) -> Value {
    let parameters: Map<String, Value> = determined(experiment)
        .map(|(parameter, value)| (parameter.name().to_owned(), value.into()))
        .collect();
    let scales = machine.scales();
    let table = sensitivities(machine);
    let rows: Map<String, Value> = table
        .quantities
        .iter()
        .zip(&table.values)
        .map(|(quantity, values)| {
            let row: Map<String, Value> = table
                .groups
                .iter()
                .zip(values)
                .map(|(group, value)| (group.name.to_owned(), (*value).into()))
                .collect();
            (quantity.name().to_owned(), row.into())
        })
        .collect();
    let object = json!({
        "parameters": parameters,
        "scales": {
            "time_s": scales.time,
            "temperature_k": scales.temperature,
            "pressure_pa": scales.pressure,
            "length_m": scales.length,
            "speed_m_per_s": scales.speed,
        },
        "k_star_n_per_m2": machine.spring(),
        "warnings": experiment.warnings(),
        "sensitivities": rows,
    });
    analysis::with_machine(object, experiment)
}

fn materials() -> String {
    let mut text = String::new();
    for material in MATERIALS {
        let _ = writeln!(text, "{}: {}", material.name, material.title);
        let constants: Vec<String> = CONSTANTS
            .iter()
            .zip(material.constants)
            .map(|(quantity, value)| format!("{} {}", quantity.info().symbol, si(value, quantity.info().unit)))
            .collect();
        let _ = writeln!(
            text,
            "  {}; melts at {} K, yields at {}\n  {}",
            constants.join(", "),
            material.melting_point,
            si(material.yield_strength, "Pa"),
            material.source
        );
    }
    text
}

fn materials_object() -> Value {
    let object = |material: &crate::machine::Material| {
        let mut object = json!({ "name": material.name, "title": material.title });
        for (quantity, value) in CONSTANTS.iter().zip(material.constants) {
            object[quantity.name()] = value.into();
        }
        object["melting_point"] = material.melting_point.into();
        object["yield_strength"] = material.yield_strength.into();
        object["source"] = material.source.into();
        object
    };
    MATERIALS.iter().map(object).collect()
}
