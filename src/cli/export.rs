//! `export`: a store as a table, of comma-separated values or as Parquet.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;

use super::{Failure, outputs, request};
use crate::engine::Sink;
use crate::measure::{Quantity, Values};
use crate::output::whole::write_whole;
use crate::output::{PROGRAM, csv, parquet};
use crate::results::Column;
use crate::store::{Store, StoreError};

#[derive(Args)]
pub struct ExportArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// The table, NAME.csv or NAME.parquet [default: the store's name, with .csv]
    #[arg(long, value_name = "NAME.csv|NAME.parquet")]
    out: Option<PathBuf>,
    /// Quantities of the table [default: all that are stored]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = request::named::<Quantity>)]
    quantities: Vec<Quantity>,
    /// Replace a table that is there
    #[arg(long)]
    force: bool,
}

/// Rows of a piece of the table: so many that a data frame reads it fast.
const PIECE: usize = 1 << 17;

pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let name = outputs::name_of_store(&args.store).map_err(Failure::Input)?;
    let path = args.out.clone().unwrap_or_else(|| name.with_extension("csv"));
    let is_parquet = match path.extension().and_then(|extension| extension.to_str()) {
        Some("csv") => false,
        Some("parquet") => true,
        _ => {
            return Err(Failure::Input(anyhow!(
                "{} is no table: its name should end in .csv or .parquet",
                path.display()
            )));
        }
    };
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
    let mut quantities = held;
    if !args.quantities.is_empty() {
        quantities.clone_from(&args.quantities);
        let mut seen = Vec::new();
        quantities.retain(|quantity| {
            !seen.contains(quantity) && {
                seen.push(*quantity);
                true
            }
        });
    }
    outputs::check_writable(&path).map_err(Failure::Input)?;
    let mut table = Table {
        store: &store,
        quantities,
        unit: 0,
        rows: 0,
        damage: None,
    };
    let experiment = store.experiment().outline();
    let headings = table.headings();
    let written = if is_parquet {
        parquet::write(&path, &experiment, &headings, &mut || table.next())
    } else {
        write_whole(&path, |file| {
            writeln!(file, "# {PROGRAM}: results of {}", store.path().display())?;
            for line in csv::experiment_comments(&experiment) {
                writeln!(file, "# {line}")?;
            }
            let names: Vec<&str> = headings.iter().map(|(name, _)| *name).collect();
            writeln!(file, "{}", names.join(","))?;
            while let Some(columns) = table.next()? {
                write_rows(file, &headings, &columns)?;
            }
            Ok(())
        })
    };
    if let Some(error) = table.damage {
        return Err(Failure::run(error));
    }
    written.map_err(Failure::run)?;
    let points = store.experiment().design.len();
    if table.rows < points {
        print_line!("{} of {points} points: the others are not computed", table.rows);
    }
    print_line!("wrote {}", path.display());
    Ok(())
}

/// The finished points of a store as the rows of a table: the coordinates, then the quantities.
struct Table<'a> {
    store: &'a Store,
    quantities: Vec<Quantity>,
    /// The unit that comes next.
    unit: usize,
    /// Rows so far.
    rows: usize,
    /// What ended the table before its end.
    damage: Option<StoreError>,
}

impl Table<'_> {
    fn headings(&self) -> Vec<(&'static str, Values)> {
        let coordinates = self.store.experiment().design.varied.coordinates();
        let coordinates = coordinates.iter().map(|coordinate| (coordinate.name(), Values::F64));
        let quantities = self
            .quantities
            .iter()
            .map(|quantity| (quantity.info().name, quantity.info().values));
        coordinates.chain(quantities).collect()
    }

    /// The next rows, by their columns; None at the end.
    fn next(&mut self) -> io::Result<Option<Vec<Column>>> {
        let varied = &self.store.experiment().design.varied;
        let mut coordinates = vec![Vec::new(); varied.coordinates().len()];
        let mut values = vec![Vec::new(); self.quantities.len()];
        while self.unit < self.store.units() && coordinates[0].len() < PIECE {
            let found = self.store.read_unit(self.unit).map_err(|error| {
                let text = error.to_string();
                self.damage = Some(error);
                io::Error::other(text)
            })?;
            let points = self.store.points(self.unit);
            self.unit += 1;
            let Some(columns) = found else {
                continue;
            };
            for index in points {
                for (column, (_, value)) in coordinates.iter_mut().zip(varied.values(index)) {
                    column.push(value);
                }
            }
            for (quantity, values) in self.quantities.iter().zip(&mut values) {
                let column = columns.iter().find(|(of, _)| of == quantity);
                let (_, column) = column.expect("a unit has all that its store holds");
                values.extend(column.values());
            }
        }
        let rows = coordinates[0].len();
        self.rows += rows;
        if rows == 0 {
            return Ok(None);
        }
        let values = self.quantities.iter().zip(values).map(|(quantity, values)| {
            let mut column = Column::new(quantity.info().values, rows);
            for (row, value) in values.into_iter().enumerate() {
                column.set(row, value);
            }
            column
        });
        Ok(Some(coordinates.into_iter().map(Column::F64).chain(values).collect()))
    }
}

/// A value that does not apply is left empty; codes are their names.
fn write_rows(file: &mut impl Write, headings: &[(&str, Values)], columns: &[Column]) -> io::Result<()> {
    for row in 0..columns[0].len() {
        for (place, ((_, values), column)) in headings.iter().zip(columns).enumerate() {
            if place > 0 {
                write!(file, ",")?;
            }
            match (column.value(row), values) {
                (value, _) if !value.is_finite() => {}
                (code, Values::Code(names)) => write!(file, "{}", names[code as usize])?,
                // as short as the stored number is
                (value, Values::F32) => write!(file, "{}", value as f32)?,
                (value, Values::F64) => write!(file, "{value}")?,
            }
        }
        writeln!(file)?;
    }
    Ok(())
}
