//! The files of a map: their names, whether they may be written, and the pictures.
//!
//! Owns the rule that results of another experiment are not overwritten; the formats are the library's.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use rayon::prelude::*;

use super::json::JsonArgs;
use super::{Failure, words};
use crate::experiment::{Experiment, Request};
use crate::map::{self, ParameterMap};
use crate::measure::Quantity;
use crate::output::csv;
use crate::output::whole::own_part;
use crate::picture::{self, Style, png};
use crate::store::check_replaceable;

/// Checks before any work that a file can be written at `path`, whose folders need not exist yet. For this, creates a temporary
/// file in the nearest existing folder, and removes it again.
///
/// # Errors
/// If the file cannot be written, with the reason and what to do.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let parent = path.parent().unwrap_or("".as_ref());
    let mut folder = parent;
    while !folder.as_os_str().is_empty() && fs::symlink_metadata(folder).is_err() {
        folder = folder.parent().unwrap_or("".as_ref());
    }
    let trial = own_part(&folder.join(path.file_name().unwrap_or_default()));
    // a new folder `outputs` is the default; the name of another new folder may be mistyped
    if folder != parent && parent != Path::new("outputs") {
        eprintln!("note: the folder {} is not there, and is created", parent.display());
    }
    File::create_new(&trial)
        .and_then(|_| fs::remove_file(&trial))
        .map_err(|error| {
            anyhow!(
                "cannot write {}: {error}; check the folder's permissions, or give another --out",
                path.display()
            )
        })
}

/// The most points of a map: its results are read back into memory, at about 100 bytes for each, and drawn.
const MOST_POINTS: usize = 50_000_000;

/// The path that all output names begin with.
pub struct Outputs {
    name: PathBuf,
}

impl Outputs {
    pub fn new(name: &Path) -> Self {
        Self { name: name.to_owned() }
    }

    fn path(&self, suffix: &str) -> PathBuf {
        let mut path = self.name.clone().into_os_string();
        path.push(suffix);
        path.into()
    }

    pub fn store(&self) -> PathBuf {
        self.path(".zarr")
    }

    pub fn picture(&self, quantity: Quantity) -> PathBuf {
        self.path(&format!("-{}.png", quantity.info().name))
    }

    /// The table of the border of chaos; none where there is no border.
    pub fn border(&self, experiment: &Experiment) -> Option<PathBuf> {
        map::has_border(experiment).then(|| self.path("-border.csv"))
    }

    /// Whether the experiment may be run and drawn under this name; leaves nothing behind.
    ///
    /// # Errors
    /// If a picture of another experiment is in the way and `force` is not given, there are too many points, or the place cannot be
    /// written.
    pub fn check(&self, experiment: &Experiment, force: bool) -> anyhow::Result<()> {
        self.check_place(experiment)?;
        if force {
            Ok(check_replaceable(&self.store())?)
        } else if self.store().exists() {
            Ok(())
        } else {
            self.check_pictures(experiment)
        }
    }

    /// Whether files can be written under this name.
    fn check_place(&self, experiment: &Experiment) -> anyhow::Result<()> {
        let text = self.name.to_string_lossy();
        if self.name.file_name().is_none() || text.ends_with(std::path::is_separator) {
            bail!("`{text}` names no file: give --out a name such as outputs/map");
        }
        let points = experiment.design.len();
        if points > MOST_POINTS {
            let sides: Vec<String> = experiment
                .design
                .axes()
                .iter()
                .map(|axis| axis.count().to_string())
                .collect();
            bail!(
                "a map of {} points is too large: {points} points do not fit into memory (at most {MOST_POINTS})",
                sides.join(" x ")
            );
        }
        let drawn = Quantity::drawn(experiment.wears());
        let pictures: Vec<PathBuf> = drawn.iter().map(|&quantity| self.picture(quantity)).collect();
        for file in pictures.into_iter().chain(self.border(experiment)) {
            if file.is_dir() {
                bail!("{} is a folder: move it away, or give another --out", file.display());
            }
        }
        check_writable(&self.store())
    }

    /// Checks that existing pictures show the same experiment. A table without the picture of the exponent is refused.
    pub fn check_pictures(&self, experiment: &Experiment) -> anyhow::Result<()> {
        if let Some(table) = self.border(experiment)
            && table.exists()
            && !self.picture(Quantity::Lyapunov).exists()
        {
            bail!(
                "{} is there already: give another --out, or --force to replace it",
                table.display()
            );
        }
        for &quantity in Quantity::drawn(experiment.wears()) {
            let path = self.picture(quantity);
            if path.exists() && !shows(&path, experiment) {
                bail!(
                    "{} shows another experiment: give another --out, or --force to replace it",
                    path.display()
                );
            }
        }
        Ok(())
    }

    /// Draws the default pictures of a map, and writes the border of chaos, if it has one; returns the files.
    pub fn draw(&self, map: &ParameterMap, style: &Style) -> anyhow::Result<Vec<PathBuf>> {
        // a map that is too large for a picture has only the store and the table
        let fits = picture::check_size(&map.experiment, style).is_ok();
        let drawn = Quantity::drawn(map.experiment.wears()).iter().copied();
        let drawn: Vec<Quantity> = drawn
            .filter(|&quantity| fits && map.column(quantity).is_some())
            .collect();
        let pictures = drawn.into_par_iter().map(|quantity| {
            // here the limits apply only to the exponent
            let limits = style.limits.filter(|_| quantity == Quantity::Lyapunov);
            let style = Style {
                limits,
                ..style.clone()
            };
            self.draw_quantity(map, quantity, &style)
        });
        let mut files: Vec<PathBuf> = pictures.collect::<Result<_, _>>()?;
        if let Some(table) = self.border(&map.experiment)
            && map.column(Quantity::Class).is_some()
        {
            csv::write_border(&table, map)?;
            files.push(table);
        }
        Ok(files)
    }

    /// Draws some quantities of a map, or the default pictures if there are none, and tells which files were written.
    pub fn draw_and_tell(
        &self,
        map: &ParameterMap,
        quantities: &[Quantity],
        style: &Style,
        json: JsonArgs,
    ) -> Result<(), Failure> {
        let files = if quantities.is_empty() {
            self.draw(map, style)
        } else {
            let draw = |&quantity| self.draw_quantity(map, quantity, style);
            quantities.iter().map(draw).collect()
        };
        let files = files.map_err(Failure::Input)?;
        if json.wanted() {
            let mut object = words::object(map);
            object["files"] = files.iter().map(|file| file.display().to_string()).collect();
            json.print(&object);
            return Ok(());
        }
        for file in files {
            print_line!("wrote {}", file.display());
        }
        Ok(())
    }

    pub fn draw_quantity(&self, map: &ParameterMap, quantity: Quantity, style: &Style) -> anyhow::Result<PathBuf> {
        let path = self.picture(quantity);
        picture::draw(map, quantity, style, &path)?;
        Ok(path)
    }
}

/// Whether a map has some quantities, which are to be drawn.
///
/// # Errors
/// If its store does not hold one of them.
pub fn check_held(map: &ParameterMap, quantities: &[Quantity], store: &Path) -> anyhow::Result<()> {
    let Some(missing) = quantities.iter().find(|&&quantity| map.column(quantity).is_none()) else {
        return Ok(());
    };
    let held: Vec<&str> = map.quantities().iter().map(|quantity| quantity.info().name).collect();
    bail!(
        "{} does not hold {}: it holds {}",
        store.display(),
        missing.info().name,
        held.join(", ")
    );
}

/// Whether a picture shows the results of an experiment.
fn shows(picture: &Path, experiment: &Experiment) -> bool {
    shown(picture).is_some_and(|shown| shown.has_results_of(experiment))
}

/// The experiment that a picture shows, if it has one.
pub fn shown(picture: &Path) -> Option<Experiment> {
    let toml = png::read_experiment(picture).ok()?;
    Request::from_toml(&toml).ok()?.resolve().ok()
}

/// `outputs/map` of `outputs/map.zarr`.
pub fn name_of_store(store: &Path) -> anyhow::Result<PathBuf> {
    match store.extension() {
        Some(extension) if extension == "zarr" => Ok(store.with_extension("")),
        _ => Err(anyhow!("{} is no store: its name should end in .zarr", store.display())),
    }
}
