//! From a file and `--set` overrides to a checked [`Scene`], and back to text.

use super::{Director, Element};
use super::{
    Scene,
    source::{Fault, Override, Source, locate, one_line},
    validate,
};
use crate::error::{Error, Result};
use serde::Deserialize;
use std::io::Read;
use std::path::{Path, PathBuf};
use toml_edit::{Document, Item, de};

/// Largest scene file that is read [bytes].
const SIZE_LIMIT: u64 = 10 * 1024 * 1024;
/// Tables that may be there several times.
const LISTS: &[&str] = &[
    "region",
    "boundary",
    "pin",
    "expect",
    "meshes",
    "force",
    "edge-load",
    "surface-load",
    "body-force",
    "wind",
    "moment",
    "normal-force",
    "pressure",
    "part",
    "sweep",
    "measures",
];

/// A scene together with where it came from.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The checked scene.
    pub scene: Scene,
    /// The file.
    pub path: PathBuf,
    /// The file's text and the overrides.
    pub source: Source,
}

/// Reads and checks a scene file; each of `overrides` is a `key=value` with a dotted key, applied in this order.
///
/// # Errors
/// [`Error::Io`] or [`Error::Input`] if the file cannot be read as text, [`Error::Scene`] with the first fault in it.
pub fn read(path: &Path, overrides: &[String]) -> Result<SceneFile> {
    let text = read_text(path)?;
    let (scene, source) = parse(&path.display().to_string(), &text, overrides)?;
    Ok(SceneFile { scene, path: path.to_path_buf(), source })
}

/// [`read`] for a text; `name` is how messages call it. Returns the scene and its source.
///
/// # Errors
/// [`Error::Scene`] with the first fault.
pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<(Scene, Source)> {
    let overrides = overrides.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>>>()?;
    let source = Source::new(name, text, overrides)?;
    let scene = deserialize(source.merged()).map_err(|fault| source.error(fault))?;
    validate::scene(&scene).map_err(|fault| source.error(fault))?;
    Ok((scene, source))
}

/// The scene as a TOML text with every default written out; [`parse`] makes an equal scene of it.
///
/// # Panics
/// If a whole number exceeds `i64::MAX`, which no file can say.
pub fn to_toml(scene: &Scene) -> String {
    toml_edit::ser::to_string_pretty(scene).expect("a scene is made of tables, arrays and numbers that TOML has")
}

fn read_text(path: &Path) -> Result<String> {
    let refuse = |message: String| Err(Error::input(path.display().to_string(), message));
    let metadata = std::fs::metadata(path).map_err(|source| Error::io("read", path, source))?;
    if metadata.is_dir() {
        return refuse("this is a folder, a scene file is expected".to_owned());
    }
    if !metadata.is_file() {
        return refuse("this is not a regular file".to_owned());
    }
    let mut bytes = Vec::new();
    // The limit is put on what is read, because a file may grow between the look at its size and its reading.
    let file = std::fs::File::open(path).map_err(|source| Error::io("read", path, source))?;
    file.take(SIZE_LIMIT + 1).read_to_end(&mut bytes).map_err(|source| Error::io("read", path, source))?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return refuse(format!("larger than the {} MB that a scene file may have", SIZE_LIMIT >> 20));
    }
    if bytes.contains(&0) {
        return refuse("this is a binary file, a scene in TOML is expected".to_owned());
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let line = error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
            return refuse(format!("not UTF-8 text, first on line {line} (byte {at})"));
        }
    };
    if text.trim().is_empty() {
        return refuse("the file is empty, a scene in TOML is expected".to_owned());
    }
    Ok(text)
}

fn deserialize(document: &Document<String>) -> Result<Scene, Fault> {
    let read = Scene::deserialize(de::Deserializer::from(document.clone())).map_err(|error| {
        let key = error.span().map(|span| locate(document.as_item(), &span)).unwrap_or_default();
        explain(error.message(), key)
    });
    // Serde takes `[[gravity]]` for the fields of gravity one after the other. A name that is not there at all is the first thing to say.
    if !read.as_ref().is_err_and(|fault| fault.of_key) {
        single_tables(document.as_item(), &[])?;
    }
    let mut scene = read?;
    // The one default that depends on another key.
    let named = document.get("shell").is_some_and(|shell| shell.get("element").is_some());
    if !named && scene.shell.director == Director::Average {
        scene.shell.element = Element::Linear;
    }
    Ok(scene)
}

/// Refuses double brackets around tables that are there once.
fn single_tables(item: &Item, key: &[String]) -> Result<(), Fault> {
    for (name, value) in item.as_table().into_iter().flat_map(|table| table.iter()) {
        let key: Vec<String> = key.iter().cloned().chain([name.to_owned()]).collect();
        if value.is_array_of_tables() && !LISTS.contains(&name) {
            return Err(Fault::new(key, "expected a table in single brackets, found double brackets"));
        }
        single_tables(value, &key)?;
    }
    Ok(())
}

/// Turns serde's words into ours, for the part of the file at `key`.
fn explain(message: &str, mut key: Vec<String>) -> Fault {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if let (true, [wrong, allowed @ ..]) = (message.starts_with("unknown field"), quoted.as_slice()) {
        Fault { help: Some(advise(wrong, allowed)), of_key: true, ..Fault::new(key, "unknown key") }
    } else if let Some((wrong, allowed)) = unexpected_keys(message) {
        Fault { help: Some(advise(wrong, &allowed)), of_key: true, ..Fault::new(key, "unknown key") }
    } else if let (true, [wrong, allowed @ ..]) = (message.starts_with("unknown variant"), quoted.as_slice()) {
        Fault { help: Some(advise(wrong, allowed)), ..Fault::new(key, format!("`{wrong}` is not a choice here")) }
    } else if let (true, Some(missing)) = (message.starts_with("missing field"), quoted.first()) {
        key.push((*missing).to_owned());
        Fault::new(key, "this key is missing")
    } else if message.starts_with("wanted exactly 1 element") {
        Fault::new(key, "exactly one kind must be given here")
    } else {
        Fault::new(key, reword(message))
    }
}

/// Wrong and allowed keys of a table that is one choice of several, for which serde has words of its own.
fn unexpected_keys(message: &str) -> Option<(&str, Vec<&str>)> {
    let (wrong, allowed) = message.strip_prefix("unexpected keys in table: ")?.split_once(", available keys: ")?;
    Some((wrong.split(", ").next()?, allowed.split(", ").collect()))
}

fn advise(wrong: &str, allowed: &[&str]) -> String {
    let nearest = allowed.iter().map(|name| (strsim::osa_distance(wrong, name), *name)).min();
    let near = nearest.filter(|(distance, name)| 3 * distance <= name.len().max(3) && *distance < name.len());
    let advice = near.map(|(_, name)| format!("did you mean `{name}`? ")).unwrap_or_default();
    format!("{advice}allowed here: {}", allowed.join(", "))
}

/// `invalid type: string "a", expected f64` becomes `expected a number, found string "a"`.
fn reword(message: &str) -> String {
    let message = one_line(message);
    let told = ["invalid type: ", "invalid value: "].iter().find_map(|start| message.strip_prefix(start)?.split_once(", expected "));
    let Some((found, expected)) = told else { return message };
    let found = match found {
        "sequence" => "an array",
        "map" => "a table",
        other => other,
    };
    let expected = match expected {
        "f64" => "a number",
        "usize" | "u64" => "a whole number >= 0",
        "a sequence" => "an array",
        other if other.starts_with("struct ") => "a table",
        other => other,
    };
    format!("expected {expected}, found {found}")
}
