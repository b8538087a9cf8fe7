//! `reproduce`: the paper's figures and the table of its numbers.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::anyhow;
use clap::Args;
use serde_json::{Value, json};

use super::json::JsonArgs;
use super::progress;
use super::{Failure, outputs, words};
use crate::studies::paper::{Effort, FIGURES, Figure, Files};

/// Figures that are there and current are not computed again.
#[derive(Args)]
pub struct ReproduceArgs {
    /// Figure by its number in the paper; may be repeated [default: all]
    #[arg(long, value_name = "N.N", value_parser = figure)]
    figure: Vec<&'static Figure>,
    /// Folder for the figures and the table [default: outputs/paper, with --quick outputs/paper-quick]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Coarse scans, in seconds, with the same rows and pictures
    #[arg(long)]
    quick: bool,
    /// Compute current figures again, and replace full figures by quick ones or quick ones by full ones
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: JsonArgs,
}

fn figure(id: &str) -> Result<&'static Figure, String> {
    Figure::from_id(id).map_err(|error| error.to_string())
}

pub fn run(args: &ReproduceArgs) -> Result<(), Failure> {
    let (effort, default) = if args.quick {
        (Effort::Quick, "outputs/paper-quick")
    } else {
        (Effort::Full, "outputs/paper")
    };
    let folder = args.out.as_deref().unwrap_or(default.as_ref());
    if folder.is_file() {
        return Err(Failure::Input(anyhow!(
            "{} is a file: give --out a folder",
            folder.display()
        )));
    }
    let is_for_people = !args.json.wanted();
    let writes = is_for_people || args.out.is_some();
    if writes {
        outputs::check_writable(&folder.join("table.md")).map_err(Failure::Input)?;
    }
    let files = Files::new(folder, effort);
    let figures: Vec<&Figure> = if args.figure.is_empty() {
        FIGURES.iter().collect()
    } else {
        args.figure.clone()
    };
    if let Some(figure) = figures.iter().find(|figure| files.is_of_other_effort(figure))
        && !args.force
        && writes
    {
        return Err(Failure::Input(anyhow!(
            "{} holds {} figure {}: give another --out, or --force to replace it",
            folder.display(),
            if args.quick { "the full" } else { "a quick" },
            figure.id
        )));
    }
    progress::catch_signals();
    let mut objects = Vec::new();
    let mut object = |figure: &Figure, rows: Value| objects.push(json!({ "figure": figure.id, "rows": rows }));
    for figure in figures {
        if !args.force
            && let Some(kept) = files.current(figure)
        {
            object(figure, json!(kept.rows));
            if is_for_people {
                print_line!("figure {} is current", figure.id);
            }
            continue;
        }
        let started = Instant::now();
        let outcome = figure
            .compute(effort, &mut progress::until_stopped)
            .map_err(Failure::run)?
            .ok_or_else(|| {
                Failure::Interrupted(format!(
                    "figure {} is not finished; the same command goes on with it",
                    figure.id
                ))
            })?;
        object(figure, json!(outcome.rows));
        if !writes {
            continue;
        }
        let written = files.write(figure, &outcome).map_err(Failure::run)?;
        if is_for_people {
            print_line!("figure {} in {}", figure.id, words::duration(started.elapsed()));
            for file in written {
                print_line!("wrote {}", file.display());
            }
        }
    }
    let mut object = json!({ "figures": objects });
    if writes {
        let (table, path) = files.write_table().map_err(Failure::run)?;
        if is_for_people {
            print_line!("wrote {}\n\n{table}", path.display());
            return Ok(());
        }
        object["table"] = path.display().to_string().into();
    }
    args.json.print(&object);
    Ok(())
}
