//! `check` and `schema` on the scenes that come with the program.

use super::pipeline_support::{DYNAMIC, Sandbox, with};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn configs(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            configs(&path, found);
        } else if path.extension().is_some_and(|e| e == "toml") {
            found.push(path);
        }
    }
}

fn all_configs() -> Vec<PathBuf> {
    let mut found = Vec::new();
    configs(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs"), &mut found);
    assert!(found.len() >= 3);
    found
}

#[test]
fn check_tells_parts_and_sizes_and_writes_nothing() {
    let sandbox = Sandbox::new(DYNAMIC);
    let (out, err) = sandbox.ok(&["check", "scene.toml"]);
    for line in [
        "rest      linear",
        "gravity   (0, 0, -9.80665) m/s2",
        "shell     linear free-tan, 0.001 m, 1e6 Pa, nu 0.3, 1000 kg/m3",
        "pin       left: x y z, clamped, moved",
        "size      21 vertices, 24 faces, 0.06 x 0.02 x 0 m",
        "unknowns  96 free, 11 held",
    ] {
        assert!(out.lines().any(|l| l == line), "{line} is not in\n{out}");
    }
    assert_eq!(err, "");
    assert_eq!(sandbox.names("."), ["scene.toml"]);
    // What the mesh is warned about, `check` warns about.
    let set = ["--set", "shell.director='average'", "--set", "mesh.rectangle.jitter=0.3"];
    let (out, err) = sandbox.ok(&[&["check", "scene.toml"][..], &set].concat());
    assert!(err.contains("warning: director = \"average\" does not converge on irregular meshes"), "{err}");
    // No angles: three coordinates a vertex, of which three vertices are held.
    assert!(out.contains("unknowns  54 free, 9 held"), "{out}");
    let (_, err) = sandbox.ok(&[&["mesh", "scene.toml", "-q"][..], &set].concat());
    assert!(err.contains("does not converge on irregular meshes"), "{err}");
}

#[test]
fn check_agrees_with_setup() {
    let sandbox = Sandbox::new(&with(DYNAMIC, "[gravity]\nfactor = \"cos(50 * t)\"", ""));
    let (out, _) = sandbox.ok(&["check", "scene.toml"]);
    assert!(!out.contains("gravity"));
    sandbox.ok(&["mesh", "scene.toml"]);
    let (_, err) = sandbox.ok(&["setup", "scene.toml"]);
    assert!(err.contains("96 free unknowns, 11 held") && out.contains("96 free, 11 held"), "{out}{err}");
}

#[test]
fn every_scene_that_comes_along_is_sound() {
    let sandbox = Sandbox::new(DYNAMIC);
    for config in all_configs() {
        let (out, _) = sandbox.ok(&["check", config.to_str().unwrap()]);
        assert!(out.contains("unknowns"), "{}: {out}", config.display());
    }
    assert_eq!(sandbox.names("."), ["scene.toml"]);
}

/// Checks a value against the part of JSON schema that the program's own schema uses. Errors: the path and what is wrong there.
fn validate(root: &Value, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root.pointer(reference.trim_start_matches('#')).ok_or(format!("{reference} leads nowhere"))?;
        validate(root, target, value, at)?;
    }
    for key in ["anyOf", "oneOf"] {
        if let Some(list) = schema[key].as_array() {
            let faults: Vec<String> = list.iter().filter_map(|s| validate(root, s, value, at).err()).collect();
            if faults.len() == list.len() {
                return Err(faults.join("; or "));
            }
        }
    }
    let name = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(n) if n.is_u64() || n.is_i64() => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let allows = |t: &str| t == name || (t == "number" && name == "integer");
    let typed = match &schema["type"] {
        Value::String(t) => allows(t),
        Value::Array(list) => list.iter().any(|t| t.as_str().is_some_and(allows)),
        _ => true,
    };
    if !typed {
        return Err(format!("{at} is {name}, expected {}", schema["type"]));
    }
    if schema.get("const").is_some_and(|c| c != value) || schema["enum"].as_array().is_some_and(|list| !list.contains(value)) {
        return Err(format!("{at} = {value} is not among the choices"));
    }
    if let Some(list) = value.as_array() {
        let bounds = [schema["minItems"].as_u64().unwrap_or(0), schema["maxItems"].as_u64().unwrap_or(u64::MAX)];
        if !(bounds[0]..=bounds[1]).contains(&(list.len() as u64)) {
            return Err(format!("{at} has {} entries", list.len()));
        }
        list.iter()
            .enumerate()
            .filter(|_| schema["items"].is_object())
            .try_for_each(|(i, v)| validate(root, &schema["items"], v, &format!("{at}.{i}")))?;
    }
    if let Some(table) = value.as_object() {
        if let Some(key) = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).find(|k| !table.contains_key(*k)) {
            return Err(format!("{at}.{key} is missing"));
        }
        for (key, v) in table {
            match schema["properties"].get(key) {
                Some(s) => validate(root, s, v, &format!("{at}.{key}"))?,
                None if schema["additionalProperties"] == false => return Err(format!("{at}.{key} is unknown")),
                None => {}
            }
        }
    }
    Ok(())
}

#[test]
fn the_schema_accepts_every_scene_that_comes_along() {
    let sandbox = Sandbox::new(DYNAMIC);
    let schema: Value = serde_json::from_str(&sandbox.ok(&["schema"]).0).unwrap();
    let read = |text: &str| serde_json::to_value(toml::from_str::<toml::Table>(text).unwrap()).unwrap();
    let mut texts: Vec<String> = all_configs().iter().map(|p| std::fs::read_to_string(p).unwrap()).collect();
    texts.push(include_str!("full.toml").into());
    for text in &texts {
        assert_eq!(validate(&schema, &schema, &read(text), "scene"), Ok(()));
    }
    // Misspelt keys at every depth, wrong types and missing keys are refused.
    for (from, to) in [
        ("title =", "titel ="),
        ("[dynamics]", "[dynamic]"),
        ("thickness =", "thicknes ="),
        ("thickness = 1e-3", "thickness = 'thick'"),
        ("cells = [6, 2]", "cells = [6]"),
        ("[mesh.rectangle]", "[mesh.square]"),
        ("m_plus =", "m_top ="),
        ("motion = { z", "motion = { w"),
        ("director = \"clamped\"", "director = \"glued\""),
        ("end = 0.04", ""),
    ] {
        assert!(validate(&schema, &schema, &read(&with(DYNAMIC, from, to)), "scene").is_err(), "{to}");
    }
    // No table accepts unknown keys.
    let mut open = Vec::new();
    for (name, definition) in schema["$defs"].as_object().unwrap() {
        if definition["properties"].is_object() && definition["additionalProperties"] != false {
            open.push(name.clone());
        }
    }
    assert!(schema["additionalProperties"] == false && open.is_empty(), "{open:?}");
}
