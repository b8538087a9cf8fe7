//! Rules of the source text that a paragraph could not keep: which crates are named where, who prints, and that no layer
//! of the library uses one above it.

use std::fs;
use std::path::{Path, PathBuf};

/// Every Rust source file: its path below `src`, with `/` between the parts, and its code without comments.
fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a source folder") {
            let path: PathBuf = entry.expect("a source file").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let parts: Vec<_> = path
                    .strip_prefix(&root)
                    .unwrap()
                    .iter()
                    .map(|part| part.to_string_lossy())
                    .collect();
                let code = fs::read_to_string(&path)
                    .expect("UTF-8")
                    .lines()
                    .map(without_comment)
                    .collect();
                sources.push((parts.join("/"), code));
            }
        }
    }
    assert!(!sources.is_empty());
    sources
}

/// The line, ended by a newline, up to a comment. A `//` within a string ends it too; no rule here looks behind one.
fn without_comment(line: &str) -> String {
    format!("{}\n", line.split("//").next().unwrap_or_default())
}

fn is_identifier(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Where `name` stands as a whole word: what comes before it and what comes after it.
fn occurrences<'a>(code: &'a str, name: &'a str) -> impl Iterator<Item = (&'a str, &'a str)> {
    code.match_indices(name)
        .map(move |(at, _)| (&code[..at], &code[at + name.len()..]))
        .filter(|(before, after)| !before.ends_with(is_identifier) && !after.starts_with(is_identifier))
}

/// Whether the code names a crate: at the head of a path or in a `use`, not as the tail of another path. A module of this
/// project with the crate's name, imported by its path, is not the crate.
fn names_crate(code: &str, name: &str) -> bool {
    let own_module = code.split("use ").skip(1).any(|rest| {
        let import = rest.split(';').next().unwrap_or_default();
        let is_own = ["tribochaos::", "crate::", "super::"]
            .iter()
            .any(|root| import.starts_with(root));
        is_own && occurrences(import, name).next().is_some()
    });
    !own_module
        && occurrences(code, name)
            .any(|(before, after)| !before.ends_with("::") && (after.starts_with("::") || before.ends_with("use ")))
}

/// Whether the code calls a macro.
fn calls(code: &str, name: &str) -> bool {
    occurrences(code, name).any(|(_, after)| after.starts_with('!'))
}

fn assert_only_in(places: &[&str], what: &str, breaks_in: impl Fn(&str) -> bool) {
    for (file, code) in sources() {
        let allowed = places.iter().any(|place| file.starts_with(place));
        assert!(
            allowed || !breaks_in(&code),
            "{what} in src/{file}, but its place is {places:?}"
        );
    }
}

const SHELL: [&str; 2] = ["cli/", "main.rs"];

#[test]
fn only_the_command_line_knows_its_crates() {
    for name in [
        "clap",
        "clap_complete",
        "clap_mangen",
        "anyhow",
        "indicatif",
        "humantime",
        "signal_hook",
        "libc",
    ] {
        assert_only_in(&SHELL, name, |code| names_crate(code, name));
    }
}

#[test]
fn only_the_gpu_backend_knows_wgpu() {
    for name in ["wgpu", "pollster"] {
        assert_only_in(&["backend/gpu/"], name, |code| names_crate(code, name));
    }
}

#[test]
fn only_the_output_knows_the_crates_of_images_and_stores() {
    for name in ["image", "png", "resvg", "zarrs", "palette", "dejavu"] {
        assert_only_in(&["output/"], name, |code| names_crate(code, name));
    }
}

#[test]
fn the_library_prints_nothing() {
    for name in ["println", "eprintln", "print", "eprint", "dbg"] {
        assert_only_in(&SHELL, name, |code| calls(code, name));
    }
}

/// The layers in the order in which the crate's documentation lists them, the lowest first.
fn documented_layers() -> Vec<String> {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).expect("UTF-8");
    lib.lines()
        .filter_map(|line| line.strip_prefix("//! - "))
        .flat_map(|line| line.split("[`").skip(1).filter_map(|rest| rest.split("`]").next()))
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_documented_list_of_layers_is_complete() {
    let layers = documented_layers();
    let (_, lib) = sources()
        .into_iter()
        .find(|(file, _)| file == "lib.rs")
        .expect("the library's root");
    let modules: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert_eq!(modules.len(), layers.len());
    for module in modules {
        assert!(
            layers.iter().any(|layer| layer == module),
            "{module} is no documented layer: {layers:?}"
        );
    }
}

#[test]
fn no_layer_uses_one_above_it() {
    let layers = documented_layers();
    let height = |name: &str| layers.iter().position(|layer| layer == name);
    for (file, code) in sources() {
        let layer = file.split(['/', '.']).next().expect("split gives at least one part");
        // the library's root and the program on top of it may use everything
        let Some(own_height) = height(layer) else {
            continue;
        };
        for (_, after) in occurrences(&code, "crate") {
            let Some(path) = after.strip_prefix("::") else {
                continue;
            };
            let used: String = path.chars().take_while(|&c| is_identifier(c)).collect();
            let Some(used_height) = height(&used) else {
                panic!("src/{file} uses crate::{path:.20}: name the module, so that this test sees its layer");
            };
            assert!(
                used_height <= own_height,
                "src/{file} uses crate::{used}, which is above it"
            );
        }
    }
}
