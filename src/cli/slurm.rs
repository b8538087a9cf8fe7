//! `slurm`: a scan as a job array of Slurm, the scheduler of most clusters of this field.
//!
//! Owns the script; what the tasks compute is a scan's.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, anyhow};
use clap::Args;

use super::Failure;
use super::scan::{Prepared, ScanArgs};
use crate::output::PROGRAM;
use crate::output::whole::write_text;

/// Creates the store, and writes the experiment, NAME.toml, and a script, NAME.slurm, beside it. A task that reaches its time limit is
/// put into the queue again. Each task of the array computes a fixed part of the units.
#[derive(Args)]
pub struct SlurmArgs {
    #[command(flatten)]
    scan: ScanArgs,
    /// Tasks of the array
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_TASKS))]
    tasks: u32,
    /// Time limit of a task, as Slurm has it; what is not finished by then is put into the queue again
    #[arg(long, value_name = "[DAYS-]HH:MM:SS", default_value = "1:00:00")]
    time: String,
    /// Processors of a task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    cpus: u32,
    /// GPUs of a task
    #[arg(long, value_name = "N", default_value_t = 0)]
    gpus_per_task: u32,
    /// Partition of the cluster [default: the cluster's]
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Submit the script with sbatch
    #[arg(long)]
    submit: bool,
}

/// Tasks of an array: clusters allow 1001 unless told otherwise.
const MOST_TASKS: i64 = 1000;

/// Seconds before the time limit at which a task is asked to stop: more than a slice of periods takes.
const NOTICE: u32 = 60;

pub fn run(args: &SlurmArgs) -> Result<(), Failure> {
    let Some(prepared) = args.scan.prepare()? else {
        return Ok(());
    };
    let units = prepared.create_store()?;
    if args.tasks as usize > units {
        return Err(Failure::Input(anyhow!(
            "{} tasks are more than the {units} units of the scan: use fewer tasks, or a smaller --unit-points and another --out",
            args.tasks
        )));
    }
    let (store, script, experiment) = args.write(&prepared)?;
    print_line!(
        "store:  {}, {units} units, {} for a task at most",
        store.display(),
        units.div_ceil(args.tasks as usize)
    );
    print_line!("wrote {}\nwrote {}", experiment.display(), script.display());
    if args.submit {
        return submit(&script);
    }
    print_line!("submit it: sbatch {}", script.display());
    Ok(())
}

impl SlurmArgs {
    /// Writes the experiment and the script beside the store; returns the paths of all three.
    fn write(&self, prepared: &Prepared) -> Result<(PathBuf, PathBuf, PathBuf), Failure> {
        let store = std::path::absolute(&prepared.path).map_err(Failure::run)?;
        let [experiment, script] = ["toml", "slurm"].map(|extension| store.with_extension(extension));
        for file in [&experiment, &script] {
            if file.exists() && !self.scan.force() {
                return Err(Failure::Input(anyhow!(
                    "{} is there already: give another --out, or --force to replace it",
                    file.display()
                )));
            }
        }
        write_text(&experiment, &prepared.written.to_toml()).map_err(Failure::run)?;
        let program = std::env::current_exe().context("the program does not know where it is");
        let program = program.map_err(Failure::Run)?;
        let text = self.script(&program, &experiment, &store);
        write_text(&script, &text).map_err(Failure::run)?;
        Ok((store, script, experiment))
    }

    fn script(&self, program: &Path, experiment: &Path, store: &Path) -> String {
        let Self {
            tasks,
            time,
            cpus,
            gpus_per_task,
            partition,
            ..
        } = self;
        let name = store.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let logs = store.with_extension("%a.log");
        let mut text = format!(
            "#!/bin/bash\n\
             # {PROGRAM}: each task computes a part of the units of {store}\n\
             #SBATCH --job-name={name}\n\
             #SBATCH --array=1-{tasks}\n\
             #SBATCH --time={time}\n\
             #SBATCH --cpus-per-task={cpus}\n\
             #SBATCH --output={logs}\n\
             #SBATCH --open-mode=append\n\
             #SBATCH --requeue\n\
             # the program is told before the time limit, so that it loses nothing but the unit it is at\n\
             #SBATCH --signal=B:TERM@{NOTICE}\n",
            store = store.display(),
            logs = logs.display(),
        );
        if *gpus_per_task > 0 {
            let _ = writeln!(text, "#SBATCH --gpus-per-task={gpus_per_task}");
        }
        if let Some(partition) = partition {
            let _ = writeln!(text, "#SBATCH --partition={partition}");
        }
        let _ = write!(
            text,
            "\n\
             export RAYON_NUM_THREADS=$SLURM_CPUS_PER_TASK\n\
             {program} scan {experiment} --out {store} --part \"$SLURM_ARRAY_TASK_ID/{tasks}\" &\n\
             scan=$!\n\
             trap 'kill -TERM $scan' TERM\n\
             wait $scan\n\
             code=$?\n\
             # a signal ends the first wait, not the program\n\
             while kill -0 $scan 2>/dev/null; do wait $scan; code=$?; done\n\
             if [ $code = 143 ]; then\n  \
               # stopped before it was done: again, from where it is\n  \
               scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\"\n\
             fi\n\
             exit $code\n",
            program = quoted(program),
            experiment = quoted(experiment),
            store = quoted(store),
        );
        text
    }
}

/// A path as a word of a shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}

fn submit(script: &Path) -> Result<(), Failure> {
    let output = Command::new("sbatch").arg("--parsable").arg(script).output();
    let output = output.context("sbatch cannot be run: is this a machine of the cluster?");
    let output = output.map_err(Failure::Run)?;
    let [said, complained] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).trim().to_owned());
    if !output.status.success() {
        return Err(Failure::Run(anyhow!("sbatch refused the script: {complained}")));
    }
    print_line!("submitted as job {said}");
    Ok(())
}
