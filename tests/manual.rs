//! Every command that the README and the manual show is run, on fewer points where it shows many, so that none can rot.

#![cfg(feature = "cli")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;

/// Most values of an axis, and most states of a section, that a command is run with here.
const VALUES: usize = 12;
const STATES: &str = "20000";

/// Commands of which the same is shown with less work: the option is added.
const SHORTENED: [(&str, &str); 8] = [
    ("threshold --overlay", "--width 0.03"),
    (
        "tribochaos threshold",
        "--transient-periods 60 --align-periods 20 --periods 64",
    ),
    ("tribochaos reproduce", "--quick --figure 4.1"),
    ("tribochaos lyapunov", "--no-onset"),
    ("tribochaos bench", "--help"),
    ("devices --check", "--help"),
    ("--lifetime", "--lifetime-periods 100"),
    ("--transient-periods 2000", "--dry-run"),
];

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_dir(root.join("docs")).expect("the manual");
    let docs = docs.map(|page| page.expect("a page").path());
    [root.join("README.md")].into_iter().chain(docs).collect()
}

/// The commands of a page's shell blocks: lines that end in a backslash go on, comments and prompts are none.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut is_shell = false;
    let mut open = String::new();
    for line in page.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            is_shell = !is_shell && language == "sh";
            continue;
        }
        if !is_shell {
            continue;
        }
        open += line;
        if open.ends_with('\\') {
            open.pop();
            continue;
        }
        let command = std::mem::take(&mut open);
        let command = command.split(" #").next().unwrap_or_default().trim().to_owned();
        if !command.is_empty() {
            commands.push(command);
        }
    }
    commands
}

/// The command with less work.
fn shortened(command: &str) -> String {
    let mut words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
    for word in &mut words {
        let fields: Vec<&str> = word.split(':').collect();
        if let (true, Some(Ok(count))) = (
            word.contains('=') && fields.len() > 2,
            fields.last().map(|count| count.parse::<usize>()),
        ) {
            let head = word.rsplit_once(':').expect("it has fields").0.to_owned();
            *word = format!("{head}:{}", count.min(VALUES));
        }
    }
    if let Some(at) = words.iter().position(|word| word == "--points")
        && words[1] == "poincare"
    {
        words[at + 1] = STATES.into();
    }
    if let Some(at) = words.iter().position(|word| word == "--lifetime") {
        // the number of states is optional
        if words.get(at + 1).is_some_and(|word| word.parse::<u32>().is_ok()) {
            words.remove(at + 1);
        }
        words.insert(at + 1, "100".to_owned());
    }
    let is_map = words.get(1).is_some_and(|word| word == "map");
    let has_axes = command.contains("--x ") || command.contains("--from") || command.contains(".toml");
    let mut short = words.join(" ");
    if is_map && !has_axes {
        short += " --x zeta_k=0:12:12 --y h1=0:2:12";
    }
    for (part, option) in SHORTENED {
        if command.contains(part) {
            // a flag that is there already may not be given twice
            let new = option
                .split(' ')
                .filter(|word| *word != "--quick" || !command.contains("--quick"));
            short = format!("{short} {}", new.collect::<Vec<_>>().join(" "));
        }
    }
    short
}

#[test]
fn every_command_of_the_readme_and_the_manual_runs() {
    let mut shown = 0;
    let failures: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = pages()
            .into_iter()
            .map(|page| {
                let text = fs::read_to_string(&page).expect("UTF-8");
                let commands: Vec<String> = commands(&text)
                    .into_iter()
                    .filter(|command| command.starts_with("tribochaos "))
                    .collect();
                shown += commands.len();
                scope.spawn(move || run(&page, &commands))
            })
            .collect();
        runs.into_iter().flat_map(|run| run.join().expect("the run")).collect()
    });
    assert!(shown > 30, "only {shown} commands were found");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Runs the commands of a page one after another in a folder that has the gallery, the machines and the designs; the failures.
fn run(page: &Path, commands: &[String]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    for shown in ["outputs/gallery", "examples/machines", "examples/designs"] {
        let copies = folder.path().join(shown);
        fs::create_dir_all(&copies).expect("a folder");
        for file in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(shown)).expect("a folder") {
            let file = file.expect("a file").path();
            fs::copy(&file, copies.join(file.file_name().expect("a name"))).expect("a copy");
        }
    }
    let program = cargo_bin("tribochaos");
    let search = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{search}", program.parent().expect("a folder").display());
    let mut failures = Vec::new();
    for command in commands {
        let short = shortened(command);
        let output = Command::new("sh")
            .args(["-c", &short])
            .env("PATH", &path)
            .current_dir(folder.path())
            .output()
            .expect("a shell");
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            failures.push(format!("{}: `{command}` (run as `{short}`): {said}", page.display()));
        }
    }
    failures
}

#[test]
fn no_link_of_the_readme_and_the_manual_is_broken() {
    for page in pages() {
        let text = fs::read_to_string(&page).expect("UTF-8");
        for rest in text.split("](").skip(1) {
            let target = rest.split(')').next().unwrap_or_default();
            let file = target.split('#').next().unwrap_or_default();
            let is_file = !file.is_empty() && !file.contains("://");
            let there = page.parent().expect("a folder").join(file);
            assert!(!is_file || there.exists(), "{}: {target}", page.display());
        }
    }
}

#[test]
fn the_readme_stays_short() {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("UTF-8");
    assert!(readme.lines().count() <= 150, "{} lines", readme.lines().count());
}
