//! The keys of a scene as a list to read: table by table, each key with its type, default and meaning. Knows JSON schema, not what a key is for.

use crate::error::{Error, Result};
use crate::scene::Scene;
use serde_json::Value;

/// Width of the text [characters].
const WIDTH: usize = 110;

/// The keys of a table (`shell`, `rest.linear`) and of the tables in it, or of all tables where `table` is empty.
///
/// # Errors
/// A table that scenes do not have.
pub fn list(table: &str) -> Result<String> {
    let root = serde_json::to_value(schemars::schema_for!(Scene)).map_err(|error| Error::input("schema", error.to_string()))?;
    let mut blocks = Vec::new();
    collect(&root, &root, "", "A scene.", &mut blocks);
    let known = blocks.iter().map(|(name, _)| name.as_str()).filter(|name| !name.is_empty() && !name.contains('.'));
    let known = known.collect::<Vec<_>>().join(", ");
    let is_meant = |name: &str| table.is_empty() || name == table || name.strip_prefix(table).is_some_and(|rest| rest.starts_with('.'));
    let chosen: Vec<&str> = blocks.iter().filter(|(name, _)| is_meant(name)).map(|(_, text)| text.as_str()).collect();
    if chosen.is_empty() {
        return Err(Error::input_with_help("schema --text", format!("there is no table '{table}'"), format!("there are: {known}")));
    }
    Ok(chosen.join("\n").trim_end().to_owned())
}

/// Adds the text of a table, then those of the tables in it.
fn collect(root: &Value, schema: &Value, name: &str, doc: &str, blocks: &mut Vec<(String, String)>) {
    let schema = resolved(root, schema);
    let keys = keys(root, schema);
    if keys.is_empty() {
        if schema["items"].is_object() {
            collect(root, &schema["items"], name, doc, blocks);
        }
        return;
    }
    let mut text = String::new();
    if !name.is_empty() {
        text += &format!("[{name}]  {}\n", first_sentence(doc));
    }
    let mut inner = Vec::new();
    for (key, value, doc) in keys {
        let default = value.get("default").filter(|d| !d.is_null() && !d.is_object()).map_or(String::new(), |d| format!(", default {d}"));
        text += &format!("  {key}: {}{default}\n", type_of(root, value));
        text += &wrapped(doc);
        inner.push((if name.is_empty() { key.to_owned() } else { format!("{name}.{key}") }, value, doc));
    }
    blocks.push((name.to_owned(), text));
    for (name, value, doc) in inner {
        collect(root, value, &name, doc, blocks);
    }
}

/// What a reference stands for, and what may be absent without that.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    if let Some(target) = schema["$ref"].as_str().and_then(|path| root.pointer(path.trim_start_matches('#'))) {
        return resolved(root, target);
    }
    let kinds: Vec<&Value> = choices(schema).filter(|kind| kind["type"] != "null").collect();
    match kinds.as_slice() {
        [one] => resolved(root, one),
        _ => schema,
    }
}

fn choices(schema: &Value) -> impl Iterator<Item = &Value> {
    ["anyOf", "oneOf"].into_iter().filter_map(|key| schema[key].as_array()).flatten()
}

/// The keys of a table with their meanings; of one that is one of several, those of all.
fn keys<'a>(root: &'a Value, schema: &'a Value) -> Vec<(&'a str, &'a Value, &'a str)> {
    // A choice of one key has its meaning beside it.
    let doc = |value: &'a Value| value["description"].as_str().or(schema["description"].as_str()).unwrap_or("");
    let own = schema["properties"].as_object().into_iter().flatten().map(|(name, value)| (name.as_str(), value, doc(value)));
    own.chain(choices(schema).flat_map(|kind| keys(root, resolved(root, kind)))).collect()
}

fn type_of(root: &Value, schema: &Value) -> String {
    let schema = resolved(root, schema);
    if let Some(value) = schema.get("const") {
        return value.to_string();
    }
    if let Some(values) = schema["enum"].as_array() {
        return values.iter().map(Value::to_string).collect::<Vec<_>>().join(" or ");
    }
    let mut kinds: Vec<String> = choices(schema).filter(|kind| kind["type"] != "null").map(|kind| type_of(root, kind)).collect();
    if !kinds.is_empty() {
        kinds.dedup();
        return kinds.join(" or ");
    }
    let name = match &schema["type"] {
        Value::String(name) => name.as_str(),
        Value::Array(names) => names.iter().filter_map(Value::as_str).find(|name| *name != "null").unwrap_or("any"),
        _ => "any",
    };
    match name {
        "object" => "table".to_owned(),
        "integer" => "whole number".to_owned(),
        "boolean" => "true or false".to_owned(),
        "string" => "text".to_owned(),
        "array" => {
            let of = type_of(root, &schema["items"]);
            match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
                (Some(least), Some(most)) if least == most => format!("array of {least} ({of})"),
                _ => format!("array ({of})"),
            }
        }
        other => other.to_owned(),
    }
}

fn first_sentence(doc: &str) -> String {
    let line = doc.replace('\n', " ");
    line.split_once(". ").map_or(line.clone(), |(first, _)| format!("{first}."))
}

/// A text in indented lines.
fn wrapped(doc: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in doc.split_whitespace() {
        match lines.last_mut().filter(|line| line.len() + word.len() + 7 <= WIDTH) {
            Some(line) => line.push_str(&format!(" {word}")),
            None => lines.push(word.to_owned()),
        }
    }
    lines.iter().map(|line| format!("      {line}\n")).collect()
}
