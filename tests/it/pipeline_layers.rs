//! Imports point one way: down the table of layers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// From top to bottom; modules of one row never import each other.
///
/// [`thinshell::snapshot`] is plain data that models and files share, so it lies on the ground beside the errors.
const LAYERS: [&[&str]; 12] = [
    &["main"],
    &["cli"],
    &["stage"],
    &["case"],
    &["report"],
    &["model"],
    &["solve"],
    &["shell", "load", "moisture", "cosserat", "contact"],
    &["mesh"],
    &["sparse"],
    &["scene"],
    &["math"],
];
const GROUND: [&str; 2] = ["snapshot", "error"];

/// Only these read scenes.
const READERS: [&str; 3] = ["cli", "stage", "scene"];

/// Importers that may not see certain modules although those lie below.
const BLIND: [(&str, &[&str]); 2] = [
    ("case", &["report", "model", "solve", "shell", "load", "moisture", "sparse"]),
    ("report", &["model", "solve", "shell", "load", "moisture", "sparse"]),
];

fn height(module: &str) -> Option<usize> {
    if GROUND.contains(&module) {
        return Some(0);
    }
    LAYERS.iter().rev().position(|row| row.contains(&module)).map(|n| n + 1)
}

/// What is wrong with an import, if anything is.
fn fault(from: &str, to: &str) -> Option<String> {
    let (Some(high), Some(low)) = (height(from), height(to)) else { return Some(format!("{from} or {to} is not in the table of layers")) };
    let blind = BLIND.iter().any(|(module, hidden)| *module == from && hidden.contains(&to));
    let reads = to == "scene" && !READERS.contains(&from);
    let up = from != to && high <= low;
    (blind || reads || up).then(|| format!("{from} imports {to}"))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The module of the first level that a source file belongs to.
fn module_of(src: &Path, file: &Path) -> String {
    let first = file.strip_prefix(src).unwrap().components().next().unwrap().as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// Modules of the first level that a text names after `crate::`, also in lists, without comments. Names re-exported at the root are errors.
fn imports(text: &str, root: &str) -> BTreeSet<String> {
    let code: String = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
    let mut found = BTreeSet::new();
    for rest in code.split(&format!("{root}::")).skip(1) {
        let names = match rest.strip_prefix('{') {
            Some(list) => list.split('}').next().unwrap_or("").split(',').map(str::trim).collect(),
            None => vec![rest],
        };
        for name in names {
            let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            found.insert(if ["Error", "Result"].contains(&name.as_str()) { "error".to_owned() } else { name });
        }
    }
    found.remove("");
    found
}

#[test]
fn imports_point_down() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let (mut faults, mut arrows) = (Vec::new(), 0);
    for file in &files {
        let from = module_of(&src, file);
        if from == "lib" {
            continue;
        }
        let text = std::fs::read_to_string(file).unwrap();
        for to in imports(&text, if from == "main" { "thinshell" } else { "crate" }) {
            arrows += 1;
            faults.extend(fault(&from, &to).map(|f| format!("{}: {f}", file.display())));
        }
    }
    assert!(arrows > 50, "only {arrows} imports were found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn wrong_arrows_are_found() {
    for (from, to) in [
        ("error", "mesh"),
        ("mesh", "shell"),
        ("shell", "scene"),
        ("case", "model"),
        ("report", "solve"),
        ("shell", "load"),
        ("shell", "news"),
    ] {
        assert!(fault(from, to).is_some(), "{from} to {to}");
    }
    for (from, to) in [("stage", "scene"), ("model", "snapshot"), ("case", "mesh"), ("scene", "math"), ("cli", "stage"), ("mesh", "mesh")] {
        assert!(fault(from, to).is_none(), "{from} to {to}");
    }
    let names = imports("use crate::{mesh::Mesh, solve};\n// crate::stage\nlet x: crate::case::History = crate::Result::Ok(1);", "crate");
    assert!(names.iter().map(String::as_str).eq(["case", "error", "mesh", "solve"]), "{names:?}");
}
