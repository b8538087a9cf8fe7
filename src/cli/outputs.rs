//! The files of a map: their names, whether they may be written, and the pictures.
//!
//! Owns the rule that results of another experiment are not overwritten; the formats are the library's.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use tribochaos::experiment::{Experiment, Request};
use tribochaos::map::{self, ParameterMap};
use tribochaos::measure::Quantity;
use tribochaos::output::{PROGRAM, csv};
use tribochaos::picture::{self, Style, png};
use tribochaos::store::{self, MapStore, StoreError, WriteLock};

/// Whether a file can be written at `path`, whose folders need not be there yet: found out before any work, by beginning
/// one beside its place, or where the first missing folder would be, and taking it away again.
///
/// # Errors
/// If the file cannot be written, with the reason and what to do.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let parent = path.parent().unwrap_or("".as_ref());
    let mut folder = parent;
    while !folder.as_os_str().is_empty() && fs::symlink_metadata(folder).is_err() {
        folder = folder.parent().unwrap_or("".as_ref());
    }
    let mut hidden = OsString::from(".");
    hidden.push(path.file_name().unwrap_or_default());
    hidden.push(format!(".{}.part", std::process::id()));
    let trial = folder.join(hidden);
    // the folder of the defaults is expected; another one may be mistyped
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

/// The most points of a map, whose results are read back into memory: 250 bytes for each.
const MOST_POINTS: usize = 50_000_000;

/// A number of bytes in a unit in which it can be read.
fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "kB", "MB", "GB", "TB"];
    let rank = UNITS.len() - 1;
    let rank = (0..rank)
        .find(|&rank| (count as f64) < 1e3f64.powi(rank as i32 + 1))
        .unwrap_or(rank);
    let value = count as f64 / 1e3f64.powi(rank as i32);
    let digits = usize::from(rank > 0 && value < 100.0);
    format!("{value:.digits$} {}", UNITS[rank])
}

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

    /// Opens the store before a run: that of the same experiment, to go on with it, or a new one whose tiles have about `unit` points.
    /// As long as the lock is held no other process writes it; with `wait` the end of another one is waited for.
    ///
    /// # Errors
    /// If another process writes the store, the pictures would be too large, the results of another experiment are in the way and `force` is not given,
    /// the place cannot be written, or the disk is too small.
    pub fn open(
        &self,
        experiment: &Experiment,
        unit: usize,
        force: bool,
        wait: bool,
    ) -> anyhow::Result<(MapStore, WriteLock)> {
        self.check_place(experiment)?;
        let path = self.store();
        let lock = match WriteLock::take(&path) {
            Err(error @ StoreError::Busy { .. }) if wait => {
                eprintln!("{error}: waiting");
                WriteLock::wait(&path)?
            }
            lock => lock?,
        };
        self.open_alone(experiment, unit, force).map(|store| (store, lock))
    }

    fn open_alone(&self, experiment: &Experiment, unit: usize, force: bool) -> anyhow::Result<MapStore> {
        if let Some(store) = self.check_store(experiment, force)? {
            return Ok(store);
        }
        let path = self.store();
        let axes = experiment.design.axes();
        let tile = store::shape([axes[0].count(), axes[1].count()], unit);
        let size = store::size_bytes(experiment, tile);
        let free = store::free_space(&path).with_context(|| format!("cannot write {}", path.display()))?;
        if size > free {
            bail!(
                "the store {} would take {}, and the disk has {} free: use fewer points or another disk",
                path.display(),
                bytes(size),
                bytes(free)
            );
        }
        if !path.exists() {
            return Ok(MapStore::create(&path, experiment, tile)?);
        }
        // what is replaced goes only once the new store is there
        let aside = self.path(".zarr.replaced");
        fs::rename(&path, &aside).with_context(|| format!("cannot replace {}", path.display()))?;
        match MapStore::create(&path, experiment, tile) {
            Ok(store) => {
                fs::remove_dir_all(&aside).with_context(|| format!("cannot remove {}", aside.display()))?;
                Ok(store)
            }
            Err(error) => {
                fs::rename(&aside, &path).with_context(|| format!("cannot put {} back", path.display()))?;
                Err(error.into())
            }
        }
    }

    /// Whether the experiment may be run and drawn under this name; leaves nothing behind. Returns the store to go on with,
    /// if there is one.
    ///
    /// # Errors
    /// As [`Outputs::open`], but for the room on the disk.
    pub fn check(&self, experiment: &Experiment, force: bool) -> anyhow::Result<Option<MapStore>> {
        self.check_place(experiment)?;
        self.check_store(experiment, force)
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

    /// Whether what is there may be gone on with, or be replaced.
    fn check_store(&self, experiment: &Experiment, force: bool) -> anyhow::Result<Option<MapStore>> {
        match (self.store().exists(), force) {
            (true, false) => return self.resumable(experiment).map(Some),
            (true, true) => self.check_replaceable()?,
            (false, false) => self.check_pictures(experiment)?,
            (false, true) => {}
        }
        Ok(None)
    }

    fn resumable(&self, experiment: &Experiment) -> anyhow::Result<MapStore> {
        let path = self.store();
        let store = MapStore::open(&path).context("give another --out, or --force to replace a damaged store")?;
        if !store.experiment().has_results_of(experiment) {
            bail!(
                "{} holds the results of another experiment: give another --out, or --force to replace them",
                path.display()
            );
        }
        if store.attribute("program").and_then(|program| program.as_str()) != Some(PROGRAM) {
            bail!(
                "{} was computed by another version of the program: give another --out, or --force to replace it",
                path.display()
            );
        }
        Ok(store)
    }

    /// A store may be replaced, however damaged; nothing else.
    fn check_replaceable(&self) -> anyhow::Result<()> {
        let path = self.store();
        if store::looks_like_a_store(&path) {
            return Ok(());
        }
        bail!(
            "{} is no store of a map: it is not replaced, move it away",
            path.display()
        );
    }

    /// Pictures without a store are in the way unless they show the same experiment; so is a table without them.
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

    /// Draws the pictures that a map has unless asked otherwise, and writes the border of chaos, if it has one; returns the files.
    pub fn draw(&self, map: &ParameterMap, style: &Style) -> anyhow::Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        // of a map that is too large for a picture there are the store and the table
        let fits = picture::check_size(&map.experiment, style).is_ok();
        for &quantity in Quantity::drawn(map.experiment.wears()).iter().filter(|_| fits) {
            // limits are those of the exponent
            let limits = style.limits.filter(|_| quantity == Quantity::Lyapunov);
            let style = Style {
                limits,
                ..style.clone()
            };
            files.push(self.draw_quantity(map, quantity, &style)?);
        }
        if let Some(table) = self.border(&map.experiment) {
            csv::write_border(&table, map)?;
            files.push(table);
        }
        Ok(files)
    }

    pub fn draw_quantity(&self, map: &ParameterMap, quantity: Quantity, style: &Style) -> anyhow::Result<PathBuf> {
        let path = self.picture(quantity);
        picture::draw(map, quantity, style, &path)?;
        Ok(path)
    }
}

/// Whether a picture shows the results of an experiment.
fn shows(picture: &Path, experiment: &Experiment) -> bool {
    let shown = png::read_experiment(picture).ok();
    let shown = shown.and_then(|toml| Request::from_toml(&toml).ok()?.resolve().ok());
    shown.is_some_and(|shown| shown.has_results_of(experiment))
}

/// `outputs/map` of `outputs/map.zarr`.
pub fn name_of_store(store: &Path) -> anyhow::Result<PathBuf> {
    match store.extension() {
        Some(extension) if extension == "zarr" => Ok(store.with_extension("")),
        _ => Err(anyhow!("{} is no store: its name should end in .zarr", store.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_shown_in_units_that_show_them() {
        for (count, text) in [
            (0, "0 bytes"),
            (999, "999 bytes"),
            (45_300, "45.3 kB"),
            (9_400_000, "9.4 MB"),
            (123_456_789_012, "123 GB"),
            (5_000_000_000_000_000, "5000 TB"),
        ] {
            assert_eq!(bytes(count), text);
        }
    }
}
