//! `export`: a store as a table of comma-separated values.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use tribochaos::engine::Sink;
use tribochaos::measure::{Quantity, Values};
use tribochaos::output::whole::write_whole;
use tribochaos::output::{PROGRAM, csv};
use tribochaos::store::{Store, StoreError};

use super::{Failure, outputs, request};

#[derive(Args)]
pub struct ExportArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// The table, NAME.csv [default: the store's name, with .csv]
    #[arg(long, value_name = "NAME.csv")]
    out: Option<PathBuf>,
    /// Quantities of the table [default: all that are stored]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = request::named::<Quantity>)]
    quantities: Vec<Quantity>,
    /// Replace a table that is there
    #[arg(long)]
    force: bool,
}

pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let name = outputs::name_of_store(&args.store).map_err(Failure::Input)?;
    let path = args.out.clone().unwrap_or_else(|| name.with_extension("csv"));
    if path.extension().is_none_or(|extension| extension != "csv") {
        return Err(Failure::Input(anyhow!(
            "{} is no table: its name should end in .csv",
            path.display()
        )));
    }
    if path.exists() && !args.force {
        return Err(Failure::Input(anyhow!(
            "{} is there already: give another --out, or --force to replace it",
            path.display()
        )));
    }
    let store = Store::open(&args.store).map_err(Failure::input)?;
    let held = store.quantities();
    if let Some(missing) = args.quantities.iter().find(|&quantity| !held.contains(quantity)) {
        return Err(Failure::Input(anyhow!(
            "{} does not hold {}",
            args.store.display(),
            missing.info().name
        )));
    }
    let quantities = if args.quantities.is_empty() {
        held
    } else {
        args.quantities.clone()
    };
    outputs::check_writable(&path).map_err(Failure::Input)?;
    let mut rows = 0;
    let mut damage: Option<StoreError> = None;
    let written = write_whole(&path, |file| {
        write_header(file, &store, &quantities)?;
        for unit in 0..store.units() {
            match store.read_unit(unit) {
                Ok(None) => {}
                Ok(Some(columns)) => {
                    let points = store.points(unit);
                    rows += points.len();
                    for (place, index) in points.enumerate() {
                        write_row(file, &store, &quantities, index, &|quantity| {
                            let column = columns.iter().find(|(of, _)| *of == quantity);
                            column.map_or(f64::NAN, |(_, column)| column.value(place))
                        })?;
                    }
                }
                Err(error) => {
                    let text = error.to_string();
                    damage = Some(error);
                    return Err(std::io::Error::other(text));
                }
            }
        }
        Ok(())
    });
    if let Some(error) = damage {
        return Err(Failure::run(error));
    }
    written.map_err(Failure::run)?;
    let points = store.experiment().design.len();
    if rows < points {
        print_line!("{rows} of {points} points: the others are not computed");
    }
    print_line!("wrote {}", path.display());
    Ok(())
}

fn write_header(file: &mut impl std::io::Write, store: &Store, quantities: &[Quantity]) -> std::io::Result<()> {
    writeln!(file, "# {PROGRAM}: results of {}", store.path().display())?;
    for line in csv::experiment_comments(&store.experiment().outline()) {
        writeln!(file, "# {line}")?;
    }
    let coordinates = store.experiment().design.varied.coordinates();
    let names = coordinates.iter().map(|coordinate| coordinate.name());
    let names: Vec<&str> = names
        .chain(quantities.iter().map(|quantity| quantity.info().name))
        .collect();
    writeln!(file, "{}", names.join(","))
}

/// A value that does not apply is left empty; codes are their names.
fn write_row(
    file: &mut impl std::io::Write,
    store: &Store,
    quantities: &[Quantity],
    index: usize,
    value: &dyn Fn(Quantity) -> f64,
) -> std::io::Result<()> {
    for (column, (_, value)) in store.experiment().design.varied.values(index).iter().enumerate() {
        write!(file, "{}{value}", if column > 0 { "," } else { "" })?;
    }
    for &quantity in quantities {
        write!(file, ",")?;
        match (value(quantity), quantity.info().values) {
            (value, _) if !value.is_finite() => {}
            (code, Values::Code(names)) => write!(file, "{}", names[code as usize])?,
            // as short as the stored number is
            (value, Values::F32) => write!(file, "{}", value as f32)?,
            (value, Values::F64) => write!(file, "{value}")?,
        }
    }
    writeln!(file)
}
