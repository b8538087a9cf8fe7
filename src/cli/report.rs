//! `report`: what a store says, as a page that can be handed on.
//!
//! Owns the words and the files; the statistics are the library's.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use pulldown_cmark::{Options, Parser, html};
use serde_json::json;

use super::json::JsonArgs;
use super::status::Survey;
use super::{Failure, outputs, request, words};
use crate::analysis::overview::coordinate::Places;
use crate::analysis::overview::{Indices, Margin, Overview, Share};
use crate::design::{Coordinate, Design, Fixed, Varied};
use crate::experiment::Experiment;
use crate::machine::units::{five_digits, si};
use crate::measure::Quantity;
use crate::output::whole::write_text;
use crate::output::{PROGRAM, csv};
use crate::picture::sheet::Sheet;
use crate::picture::{caption, charts, drawing};
use crate::results::Results;
use crate::store::Store;

/// Writes a folder with the page as report.md and report.html, its pictures and their values. The page tells the share of chaos over each
/// coordinate and over each pair of them, which coordinates matter, how far a point is from chaos, and what was computed where.
#[derive(Args)]
pub struct ReportArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// The folder of the report [default: the store's name, with -report]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Value of a coordinate at the point whose distance from chaos is told; may be repeated [default: the middle of each]
    #[arg(long, value_name = "NAME=VALUE", value_parser = request::assignment)]
    at: Vec<(Coordinate, f64)>,
    /// Replace the report of something else
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: JsonArgs,
}

/// The most points over which the way to chaos is looked for: their places are held in memory.
const MOST_PLACES: usize = 5_000_000;

/// Panels beside each other, and their frames in pixels.
const COLUMNS: usize = 3;
const FRAME: [u32; 2] = [330, 240];

/// All that the page tells.
struct Told<'a> {
    store: &'a Store,
    experiment: &'a Experiment,
    survey: Survey,
    overview: Overview<'a>,
    of_chaos: Option<Vec<Indices>>,
    of_exponent: Option<Vec<Indices>>,
    /// The values of the coordinates at the point that is looked at.
    at: Vec<f64>,
    /// None if there are too many points.
    margin: Option<Margin>,
}

pub fn run(args: &ReportArgs) -> Result<(), Failure> {
    let name = outputs::name_of_store(&args.store).map_err(Failure::Input)?;
    let store = Store::open(&args.store).map_err(Failure::input)?;
    if !store.quantities().contains(&Quantity::Class) {
        return Err(Failure::Input(anyhow!(
            "{} does not hold class, of which a report is made: compute it with --quantities class,lyapunov",
            args.store.display()
        )));
    }
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| drawing::with_ending(&name, "-report"));
    let draws = args.out.is_some() || !args.json.wanted();
    let at = point(&store.experiment().design, &args.at)?;
    if draws {
        check_folder(&folder, store.identity(), args.force)?;
    }
    let survey = Survey::of(&store)?;
    if let Some((unit, what)) = survey.damaged.first() {
        return Err(Failure::Run(anyhow!(
            "unit {unit} is damaged ({what}): `tribochaos verify {} --repair` mends it",
            args.store.display()
        )));
    }
    if survey.tally.points() == 0 {
        return Err(Failure::Input(anyhow!(
            "{} has no finished point yet",
            args.store.display()
        )));
    }
    let results = store
        .read_some(&[Quantity::Class, Quantity::Lyapunov])
        .map_err(Failure::run)?;
    let told = Told::of(&store, &results, survey, at);
    if args.json.wanted() {
        args.json.print(&told.object());
    }
    if draws {
        let files = told.write(&folder)?;
        if !args.json.wanted() {
            print_line!("{}", told.headline());
            for file in files {
                print_line!("wrote {}", file.display());
            }
        }
    }
    Ok(())
}

/// The files of a report.
const FILES: [&str; 7] = [
    "report.md",
    "report.html",
    "shares.png",
    "shares.svg",
    "shares.csv",
    "pairs.png",
    "pairs.svg",
];

/// The line of the page by which a report of the same experiment is known.
fn signature(identity: &str) -> String {
    format!("<!-- experiment {identity} -->")
}

/// Whether the folder has none of the files, or a report of the same experiment.
fn check_folder(folder: &Path, identity: &str, force: bool) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::Input(anyhow!(
            "{} is no folder: give another --out",
            folder.display()
        )));
    }
    let page = std::fs::read(folder.join(FILES[0])).unwrap_or_default();
    let is_own = String::from_utf8_lossy(&page).contains(&signature(identity));
    let there = FILES.iter().map(|name| folder.join(name)).find(|path| path.exists());
    if let (Some(there), false, false) = (there, is_own, force) {
        return Err(Failure::Input(anyhow!(
            "{} belongs to something else, or to another experiment: give another --out, or --force to replace it",
            there.display()
        )));
    }
    // the folder itself is made without a word
    outputs::check_writable(folder).map_err(Failure::Input)
}

/// The values of the coordinates at the point that is looked at: the typed ones, and the middle of each other one.
fn point(design: &Design, typed: &[(Coordinate, f64)]) -> Result<Vec<f64>, Failure> {
    let extents = Places::new(design, 1).extents;
    let mut at: Vec<f64> = extents.iter().map(|extent| extent.value(0.5)).collect();
    for &(coordinate, value) in typed {
        let place = extents.iter().position(|extent| extent.coordinate == coordinate);
        let Some(place) = place else {
            let names: Vec<&str> = extents.iter().map(|extent| extent.coordinate.name()).collect();
            return Err(Failure::Input(anyhow!(
                "{coordinate} does not vary in the store: it varies {}",
                names.join(", ")
            )));
        };
        let (low, high) = (extents[place].low, extents[place].high);
        if !(low..=high).contains(&value) {
            return Err(Failure::Input(anyhow!(
                "{coordinate} = {value} lies outside of the store, which has {low} to {high}"
            )));
        }
        at[place] = value;
    }
    Ok(at)
}

impl<'a> Told<'a> {
    fn of(store: &'a Store, results: &'a Results, survey: Survey, at: Vec<f64>) -> Self {
        let overview = Overview::new(results);
        let points = results.experiment.design.len();
        Self {
            store,
            experiment: &results.experiment,
            survey,
            of_chaos: overview.sensitivity_of_chaos(),
            of_exponent: overview.sensitivity_of(Quantity::Lyapunov),
            margin: (points <= MOST_PLACES).then(|| overview.margin(&at)),
            overview,
            at,
        }
    }

    fn fixed(&self) -> &Fixed {
        &self.experiment.design.fixed
    }

    /// A value with its unit.
    fn value(&self, coordinate: Coordinate, value: f64) -> String {
        match coordinate {
            Coordinate::Parameter(_) => five_digits(value).to_string(),
            Coordinate::Si(_) => si(value, self.fixed().unit(coordinate)),
        }
    }

    fn headline(&self) -> String {
        let share = self.overview.share();
        format!(
            "{} of {} computed points are chaotic: {}",
            share.of,
            share.all,
            percent(share)
        )
    }

    /// Writes the page, its pictures and their values.
    fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        let toml = self.experiment.outline();
        let text = |what: &str| {
            let coordinates = self.experiment.design.varied.coordinates();
            let fixed = caption::fixed(self.fixed(), &coordinates);
            vec![fixed, format!("{what} {PROGRAM}.")]
        };
        let draw = |name: &str, panels: Vec<_>, title: &str, what: &str| {
            let sheet = Sheet {
                // four are two by two
                columns: if panels.len() == 4 {
                    2
                } else {
                    COLUMNS.min(panels.len())
                },
                panels,
                frame: FRAME,
                caption: text(what),
            };
            let page = sheet.draw().map_err(Failure::run)?;
            let files = drawing::write_drawing(&folder.join(name), &page, title, &toml);
            files.map_err(Failure::run)
        };
        let mut files = Vec::new();
        let shares = charts::shares(&self.overview, self.fixed());
        let has_shares = !shares.is_empty();
        if has_shares {
            files.extend(draw("shares", shares, "Share of chaos over each coordinate", SHARES)?);
            files.push(self.write_shares(folder)?);
        }
        let pairs = charts::pairs(&self.overview, self.fixed());
        let has_pairs = !pairs.is_empty();
        if has_pairs {
            files.extend(draw("pairs", pairs, "Share of chaos over pairs of coordinates", PAIRS)?);
        }
        let page = self.page(has_shares, has_pairs, &toml);
        let [markdown, web] = ["report.md", "report.html"].map(|name| folder.join(name));
        write_text(&markdown, &page).map_err(Failure::run)?;
        write_text(&web, &to_html(&page)).map_err(Failure::run)?;
        files.extend([markdown, web]);
        Ok(files)
    }

    fn write_shares(&self, folder: &Path) -> Result<PathBuf, Failure> {
        let path = folder.join("shares.csv");
        let extents = self.overview.extents().iter().enumerate();
        let names: Vec<String> = extents
            .map(|(index, extent)| format!("{} is {}", index + 1, extent.coordinate))
            .collect();
        let mut comments = vec![
            "share of chaos in each bin of each coordinate, with Wilson's 95 % interval for as many random points"
                .to_owned(),
            format!("coordinate: {}", names.join(", ")),
        ];
        comments.extend(csv::experiment_comments(&self.experiment.outline()));
        let columns = ["coordinate", "value", "chaotic", "points", "share", "low", "high"];
        let extents = self.overview.extents().iter().zip(self.overview.shares());
        let rows = extents.enumerate().flat_map(|(number, (extent, shares))| {
            let bins = extent.bins.clone().into_iter().zip(shares);
            bins.map(move |(value, share)| {
                let [low, high] = share.interval();
                [
                    (number + 1) as f64,
                    value,
                    share.of as f64,
                    share.all as f64,
                    share.value(),
                    low,
                    high,
                ]
            })
        });
        csv::write_table(&path, &comments, columns, rows).map_err(Failure::run)?;
        Ok(path)
    }

    fn page(&self, has_shares: bool, has_pairs: bool, toml: &str) -> String {
        let mut page = String::new();
        let _ = writeln!(page, "# Where {} is chaotic\n", self.store.path().display());
        let _ = writeln!(page, "{}\n", signature(self.store.identity()));
        let _ = writeln!(page, "{}.\n", caption::capitalised(&words::plan(self.experiment)));
        self.tell_shares(&mut page, has_shares, has_pairs);
        self.tell_sensitivity(&mut page);
        self.tell_margin(&mut page);
        self.tell_computation(&mut page);
        let _ = writeln!(page, "## The experiment\n\n```toml\n{toml}```");
        page
    }

    fn tell_shares(&self, page: &mut String, has_shares: bool, has_pairs: bool) {
        let _ = writeln!(page, "## How much of it\n\n{}.\n", self.headline());
        let states = self.experiment.settings.sampling.initial_states;
        if states > 1 {
            let _ = writeln!(
                page,
                "A point is chaotic if the motion from at least one of its {states} initial states is.\n"
            );
        }
        let _ = writeln!(page, "| motion | points | share |\n| --- | ---: | ---: |");
        let all = self.survey.tally.points();
        for (name, count) in self.survey.tally.kinds() {
            let share = 100.0 * count as f64 / all as f64;
            let _ = writeln!(page, "| {} | {count} | {share:.2} % |", name.replace('_', "-"));
        }
        let points = self.experiment.design.len() as u64;
        if all < points {
            let _ = writeln!(page, "\n{} of {points} points are not computed yet.", points - all);
        }
        page.push('\n');
        if has_shares {
            let _ = writeln!(
                page,
                "## Along each coordinate\n\n![Shares of chaos over each coordinate](shares.png)\n\n{SHARES}\n"
            );
        }
        if has_pairs {
            let _ = writeln!(
                page,
                "## Along pairs of coordinates\n\n![Shares of chaos over pairs of coordinates](pairs.png)\n\n{PAIRS}\n"
            );
        }
    }

    fn tell_sensitivity(&self, page: &mut String) {
        let _ = writeln!(page, "## Which coordinates matter\n");
        let Some(of_chaos) = &self.of_chaos else {
            let _ = writeln!(page, "None: all points are alike.\n");
            return;
        };
        let _ = writeln!(
            page,
            "| coordinate | chaos, first order | chaos, total | λ₁, first order | λ₁, total |\n| --- | ---: | ---: | ---: | ---: |"
        );
        for (index, extent) in self.overview.extents().iter().enumerate() {
            let of_exponent = self.of_exponent.as_ref().map(|all| all[index]);
            let [chaos, exponent] = [Some(of_chaos[index]), of_exponent].map(|found| {
                let first = found.map_or_else(|| "-".to_owned(), |found| first_order(&found));
                let total = found.and_then(|found| found.total);
                format!(
                    "{first} | {}",
                    total.map_or_else(|| "-".to_owned(), |total| format!("{total:.3}"))
                )
            });
            let _ = writeln!(page, "| {} | {chaos} | {exponent} |", extent.coordinate);
        }
        let how = match &self.experiment.design.varied {
            Varied::Axes(_) if of_chaos.iter().all(|found| found.total.is_some()) => {
                "The design is a product of axes: the indices are exactly those of its points, each of which counts as likely as the others."
            }
            Varied::Axes(_) => {
                "Some points of the design are not computed: first-order indices are those of the others, and total indices cannot be told."
            }
            Varied::Points(_) => {
                "The design is a list of points: first-order indices come from bins of their values, and their standard errors from \
                 resamples. Total indices cannot be told from such a list, since it does not hold several values of one coordinate at the \
                 same values of the others: a product of axes tells them. If the coordinates of the list depend on each other, an index \
                 counts what a coordinate tells of the others as well."
            }
        };
        let _ = writeln!(
            page,
            "\nThe first-order index is the part of the variance that is gone, in the mean, once this coordinate is known. The total index is \
             the part that is left, in the mean, if only this one is not known. What the total has beyond the first order, the coordinate \
             does together with others. Chaos counts as 1, other motion as 0. {how}\n"
        );
    }

    fn tell_margin(&self, page: &mut String) {
        let coordinates: Vec<Coordinate> = self.overview.extents().iter().map(|extent| extent.coordinate).collect();
        let place = |values: &[f64]| {
            let values = coordinates.iter().zip(values);
            let values =
                values.map(|(&coordinate, &value)| format!("{coordinate} = {}", self.value(coordinate, value)));
            values.collect::<Vec<_>>().join(", ")
        };
        let _ = writeln!(page, "## How far from chaos\n\nThe point: {}.\n", place(&self.at));
        let Some(margin) = &self.margin else {
            let _ = writeln!(page, "Not looked for: there are more than {MOST_PLACES} points.\n");
            return;
        };
        match margin.nearest {
            None => {
                let _ = writeln!(page, "No computed point is chaotic.\n");
            }
            Some((index, distance)) => {
                let values = self.experiment.design.varied.values(index);
                let values: Vec<f64> = values.into_iter().map(|(_, value)| value).collect();
                let _ = writeln!(
                    page,
                    "The nearest chaotic point is {}, at the distance {distance:.3}. Distances are the root of the sum of squares of the \
                     differences, each as a part of its coordinate's range.\n",
                    place(&values)
                );
            }
        }
        let Some(room) = &margin.room else {
            let _ = writeln!(
                page,
                "There is no box around it: at the point itself the motion is chaotic, or not known to be regular.\n"
            );
            return;
        };
        if margin.within == 0 {
            let _ = writeln!(
                page,
                "There is no box around it: the points beside it are chaotic, or not known to be regular.\n"
            );
            return;
        }
        let largest = if margin.is_largest {
            "The largest box around it"
        } else {
            "The largest box around it that was found (the search was broken off)"
        };
        let _ = writeln!(
            page,
            "{largest} in which all computed points are regular or quasi-periodic, by its volume, each side as a part of its range. It has {} \
             such points; nothing is known between them.\n\n| coordinate | from | to |\n| --- | ---: | ---: |",
            margin.within
        );
        for (&coordinate, ends) in coordinates.iter().zip(room) {
            let [low, high] = ends.map(|end| self.value(coordinate, end));
            let _ = writeln!(page, "| {coordinate} | {low} | {high} |");
        }
        page.push('\n');
    }

    fn tell_computation(&self, page: &mut String) {
        let _ = writeln!(
            page,
            "## How it was computed\n\n| device | points | time | points a second |\n| --- | ---: | ---: | ---: |"
        );
        for (device, points, seconds) in &self.survey.devices {
            let time = words::duration(std::time::Duration::from_secs_f64(*seconds));
            let _ = writeln!(
                page,
                "| {device} | {points} | {time} | {:.0} |",
                *points as f64 / seconds
            );
        }
        let _ = writeln!(page, "\n{}. {PROGRAM}.\n", caption::scheme(&self.experiment.settings));
        let warnings = self.experiment.warnings();
        for warning in &warnings {
            let _ = writeln!(page, "- {warning}");
        }
        if !warnings.is_empty() {
            page.push('\n');
        }
    }

    fn object(&self) -> serde_json::Value {
        let share = |share: &Share| {
            let [low, high] = share.interval();
            json!({ "chaotic": share.of, "points": share.all, "share_low": low, "share_high": high })
        };
        let shares = self.overview.shares();
        let coordinates = self.overview.extents().iter().enumerate().map(|(index, extent)| {
            let bins = extent.bins.iter().zip(&shares[index]);
            let bins = bins.map(|(value, of_bin)| {
                let mut object = share(of_bin);
                object["value"] = (*value).into();
                object
            });
            let indices = |all: &Option<Vec<Indices>>| {
                all.as_ref().map(|all| {
                    let Indices {
                        first,
                        first_error,
                        total,
                    } = all[index];
                    json!({ "first": first, "first_error": first_error, "total": total })
                })
            };
            json!({
                "name": extent.coordinate.name(),
                "bins": bins.collect::<Vec<_>>(),
                "sensitivity_of_chaos": indices(&self.of_chaos),
                "sensitivity_of_lyapunov": indices(&self.of_exponent),
                "at": self.at[index],
                "room": self.margin.as_ref().and_then(|margin| margin.room.as_ref()).map(|room| room[index]),
            })
        });
        json!({
            "experiment": self.experiment.outline(),
            "share_of_chaos": share(&self.overview.share()),
            "motion": self.survey.tally,
            "coordinates": coordinates.collect::<Vec<_>>(),
            "distance_from_chaos": self.margin.as_ref().and_then(|margin| margin.nearest).map(|(_, distance)| distance),
        })
    }
}

const SHARES: &str = "Share of chaotic points among all computed ones in each bin, over all values of the other coordinates. The bands are \
                      Wilson's 95 % intervals for as many points drawn at random.";
const PAIRS: &str = "Share of chaotic points among all computed ones in each pair of bins, over all values of the other coordinates. Grey: no \
                     point there.";

fn percent(share: Share) -> String {
    let [low, high] = share.interval().map(|end| 100.0 * end);
    format!("{:.2} % (95 % interval {low:.2} to {high:.2} %)", 100.0 * share.value())
}

fn first_order(indices: &Indices) -> String {
    if indices.first_error > 0.0 {
        format!("{:.3} ± {:.3}", indices.first, indices.first_error)
    } else {
        format!("{:.3}", indices.first)
    }
}

/// The page in HTML, with a style of its own.
fn to_html(markdown: &str) -> String {
    let mut body = String::new();
    html::push_html(&mut body, Parser::new_ext(markdown, Options::ENABLE_TABLES));
    let title = markdown.lines().next().unwrap_or_default().trim_start_matches("# ");
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}</body>\n\
         </html>\n"
    )
}

const STYLE: &str = "
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; }
h1, h2 { line-height: 1.2; margin-top: 2.2rem; }
img { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border-bottom: 1px solid #ccc; padding: 0.3rem 0.9rem; }
pre { background: #f4f4f4; padding: 1rem; overflow-x: auto; font-size: 14px; }
";
