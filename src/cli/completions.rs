//! `completions`: for shells, and man pages.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, anyhow};
use clap::{Args, Command};
use clap_complete::Shell;

use super::{Failure, print};

/// Completions go to standard output: `tribochaos completions bash > FILE`. The manual of a shell tells where the shell looks for
/// them.
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum, required_unless_present = "man")]
    shell: Option<Shell>,
    /// Write a man page for each command into a folder instead
    #[arg(long, value_name = "FOLDER", conflicts_with = "shell")]
    man: Option<PathBuf>,
}

pub fn run(args: &CompletionsArgs, mut command: Command) -> Result<(), Failure> {
    if let Some(folder) = &args.man {
        fs::create_dir_all(folder)
            .and_then(|()| clap_mangen::generate_to(command, folder))
            .with_context(|| format!("cannot write man pages into {}", folder.display()))
            .map_err(Failure::Run)?;
        print_line!("wrote {}", folder.display());
        return Ok(());
    }
    let shell = args
        .shell
        .ok_or_else(|| Failure::Input(anyhow!("name a shell, or give a folder by --man")))?;
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "tribochaos", &mut script);
    print::print(format_args!("{}", String::from_utf8_lossy(&script)));
    Ok(())
}
