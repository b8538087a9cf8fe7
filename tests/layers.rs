//! Rules of the source text that a paragraph could not keep: which crates are named where, who prints, that no layer of the
//! library uses one above it, and that the files of a folder use each other in one direction.

use std::collections::{BTreeMap, BTreeSet};
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

const SHELL: [&str; 1] = ["cli/"];

#[test]
fn only_the_command_line_knows_its_crates() {
    for name in [
        "clap",
        "clap_complete",
        "clap_mangen",
        "anyhow",
        "indicatif",
        "pulldown_cmark",
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
fn only_the_store_knows_the_crates_of_stores() {
    for name in ["zarrs", "fs4"] {
        assert_only_in(&["store/"], name, |code| names_crate(code, name));
    }
}

#[test]
fn only_the_outputs_know_the_crate_of_parquet() {
    assert_only_in(&["output/parquet.rs"], "parquet", |code| names_crate(code, "parquet"));
}

#[test]
fn only_the_pictures_know_the_crates_of_images() {
    for name in ["image", "png", "resvg", "palette", "dejavu"] {
        assert_only_in(&["picture/"], name, |code| names_crate(code, name));
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

/// The module of a source file, as its path from the crate's root.
fn module_of(file: &str) -> Vec<String> {
    let mut parts: Vec<String> = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if ["mod", "lib"].contains(&parts[parts.len() - 1].as_str()) {
        parts.pop();
    }
    parts
}

/// A name that a file uses.
struct Used {
    /// From the crate's root.
    path: Vec<String>,
    /// What the name is within the file, where it is imported.
    imported_as: Option<String>,
}

/// The paths of a tree such as `a::{b, c::d as e}`, each with the name by which it is known where it is imported.
fn branches(tree: &str) -> Vec<(Vec<String>, String)> {
    let tree = tree.trim_start();
    if let Some(group) = tree.strip_prefix('{') {
        let mut found = Vec::new();
        let (mut depth, mut start) = (0, 0);
        for (at, c) in group.char_indices() {
            if depth == 0 && [',', '}'].contains(&c) {
                let branch = group[start..at].trim();
                if !branch.is_empty() {
                    found.extend(branches(branch));
                }
                start = at + 1;
            }
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                _ => {}
            }
        }
        return found;
    }
    let identifier = |text: &str| -> String { text.chars().take_while(|&c| is_identifier(c)).collect() };
    let first = identifier(tree);
    let rest = &tree[first.len()..];
    if let Some(rest) = rest.strip_prefix("::")
        && rest.starts_with(|c| is_identifier(c) || ['{', '*'].contains(&c))
    {
        let ends = branches(rest).into_iter().map(|(end, name)| {
            let path = [first.clone()].into_iter().chain(end).collect();
            (path, if name == "self" { first.clone() } else { name })
        });
        return ends.collect();
    }
    let name = rest
        .trim_start()
        .strip_prefix("as ")
        .map_or_else(|| first.clone(), identifier);
    // `*` and `self` stand for what is before them
    let path = if ["", "self"].contains(&first.as_str()) {
        Vec::new()
    } else {
        vec![first]
    };
    vec![(path, name)]
}

/// The modules within a file: where each begins and ends, and its name. They end with a brace as far to the right as their
/// first line.
fn inline_modules(code: &str) -> Vec<(std::ops::Range<usize>, String)> {
    let mut found = Vec::new();
    let mut at = 0;
    for line in code.split_inclusive('\n') {
        let declaration = line.trim_start();
        if let Some(name) = declaration
            .strip_prefix("pub ")
            .unwrap_or(declaration)
            .strip_prefix("mod ")
            .and_then(|rest| rest.trim_end().strip_suffix(" {"))
        {
            let indent = &line[..line.len() - declaration.len()];
            let end = code[at..].find(&format!("\n{indent}}}\n")).expect("a module ends");
            found.push((at..at + end, name.to_owned()));
        }
        at += line.len();
    }
    found
}

/// All that a file uses of its crate.
fn uses(file: &str, code: &str) -> Vec<Used> {
    let inline = inline_modules(code);
    let children: Vec<&str> = code
        .lines()
        .filter_map(|line| line.split("mod ").nth(1)?.trim_end().strip_suffix(';'))
        .collect();
    let mut found = Vec::new();
    for root in ["crate", "super", "self"].into_iter().chain(children) {
        for (before, after) in occurrences(code, root) {
            if before.ends_with("::") || !after.starts_with("::") {
                continue;
            }
            let within = inline.iter().filter(|(range, _)| range.contains(&before.len()));
            let within: Vec<String> = within.map(|(_, name)| name.clone()).collect();
            let here = match root {
                "crate" => Vec::new(),
                _ => [module_of(file), within.clone()].concat(),
            };
            let statement = before.trim_end().strip_suffix("use").map(str::trim_end);
            for (branch, name) in branches(&code[before.len()..]) {
                let mut path = here.clone();
                for part in branch {
                    match part.as_str() {
                        "crate" | "self" => {}
                        "super" => drop(path.pop()),
                        _ => path.push(part),
                    }
                }
                found.push(Used {
                    path,
                    imported_as: statement.filter(|_| within.is_empty()).map(|_| name),
                });
            }
        }
    }
    found
}

/// Which file each file uses, as modules. A name that a module imports belongs to the module where it comes from.
fn edges() -> Vec<(Vec<String>, Vec<String>)> {
    let modules: BTreeMap<Vec<String>, Vec<Used>> = sources()
        .iter()
        .filter(|(file, _)| file != "main.rs")
        .map(|(file, code)| (module_of(file), uses(file, code)))
        .collect();
    let owner = |path: &[String]| {
        let mut path = path.to_vec();
        // an import leads to the next
        for _ in 0..9 {
            let depth = (0..=path.len())
                .rev()
                .find(|&depth| modules.contains_key(&path[..depth]))
                .expect("the root is a module");
            let import = path.get(depth).and_then(|name| {
                let imports = modules[&path[..depth]].iter();
                imports.clone().find(|used| used.imported_as.as_ref() == Some(name))
            });
            match import {
                Some(import) => path = [&import.path[..], &path[depth + 1..]].concat(),
                None => return path[..depth].to_vec(),
            }
        }
        panic!("{path:?} is imported from itself")
    };
    let all = modules
        .iter()
        .flat_map(|(module, uses)| uses.iter().map(|used| (module.clone(), owner(&used.path))));
    all.collect()
}

/// The circles among the files of each folder: a folder, and those of its files and folders that use each other, directly or
/// in a longer circle. The folder's own file does not count: it holds what its parts share, and names the parts.
fn circles() -> BTreeSet<(String, Vec<String>)> {
    let edges = edges();
    let folders: BTreeSet<&[String]> = edges
        .iter()
        .filter(|(module, _)| !module.is_empty())
        .map(|(module, _)| &module[..module.len() - 1])
        .collect();
    let mut circles = BTreeSet::new();
    for folder in folders {
        let node = |module: &[String]| module.strip_prefix(folder)?.first().cloned();
        let mut reached: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, to) in &edges {
            if let (Some(from), Some(to)) = (node(from), node(to))
                && from != to
            {
                reached.entry(from).or_default().insert(to);
            }
        }
        // as many rounds as the longest way can have steps
        for _ in 0..reached.len() {
            let before = reached.clone();
            for found in reached.values_mut() {
                let next = found.iter().filter_map(|node| before.get(node)).flatten();
                *found = next.chain(found.iter()).cloned().collect();
            }
        }
        let meet = |one: &str, other: &str| reached.get(one).is_some_and(|found| found.contains(other));
        for one in reached.keys().filter(|one| meet(one, one)) {
            let circle = reached.keys().filter(|other| meet(one, other) && meet(other, one));
            circles.insert((folder.join("/"), circle.cloned().collect()));
        }
    }
    circles
}

#[test]
fn no_files_of_a_folder_use_each_other_in_a_circle() {
    let circles = circles();
    assert!(
        circles.is_empty(),
        "files that use each other in a circle: {circles:#?}"
    );
}

#[test]
fn paths_in_groups_and_modules_in_files_are_seen() {
    let code = "use super::{a::B, c::{self, D as E}};\nmod child;\nfn f() { child::g() }\n\
                mod tests {\n    use super::*;\n    use super::super::F;\n}\n";
    let found: Vec<String> = uses("x/y.rs", code).iter().map(|used| used.path.join("::")).collect();
    assert_eq!(found, ["x::a::B", "x::c", "x::c::D", "x::y", "x::F", "x::y::child::g"]);
}
