//! The text of a scene: its overrides, and the way from a key back to a line and column.

use crate::error::{Error, Result, SceneError};
use miette::NamedSource;
use std::ops::Range;
use toml_edit::{Document, DocumentMut, Item, Value};

/// Most parts that the key of an override may have; no scene is deeper.
const KEY_LIMIT: usize = 16;

/// Something wrong at a key; keys of arrays are numbers from 0.
pub(super) struct Fault {
    pub key: Vec<String>,
    pub message: String,
    pub help: Option<String>,
    /// Whether the key itself is wrong, not its value.
    pub of_key: bool,
}

impl Fault {
    pub fn new(key: Vec<String>, message: impl Into<String>) -> Self {
        Fault { key, message: message.into(), help: None, of_key: false }
    }
}

/// A `--set key=value`.
#[derive(Clone, Debug)]
pub(super) struct Override {
    text: String,
    key: Vec<String>,
    value: Value,
    /// Where the value stands in the text.
    span: Range<usize>,
}

impl Override {
    pub fn parse(text: &str) -> Result<Self> {
        let fault = |message: &str, span: Range<usize>| {
            let help = Some("write --set shell.thickness=1e-4, --set pin.0.region=left or --set 'mesh.rectangle.cells=[20, 4]'".to_owned());
            placed("--set", text, Some(span), format!("--set {text}: {message}"), message.to_owned(), help)
        };
        let Some(equals) = text.find('=') else { return Err(fault("`key=value` expected", 0..text.len())) };
        let key: Vec<String> = text[..equals].split('.').map(|part| part.trim().to_owned()).collect();
        if key.iter().any(String::is_empty) || key.len() > KEY_LIMIT {
            return Err(fault("the key must be names joined by dots", 0..equals));
        }
        let span = equals + 1..text.len();
        let bare = text[span.clone()].trim();
        if bare.is_empty() {
            return Err(fault("there is no value after `=`", span));
        }
        let value = match bare.parse::<Value>() {
            Ok(value) => value,
            // A word, a path or an expression without quotes.
            Err(_) if !bare.starts_with(['"', '\'', '[', '{']) => Value::from(bare),
            Err(error) => return Err(fault(&one_line(error.message()), span)),
        };
        Ok(Override { text: text.to_owned(), key, value, span })
    }

    fn apply(&self, document: &mut DocumentMut) -> Result<()> {
        let mut item = document.as_item_mut();
        for (depth, part) in self.key.iter().enumerate() {
            let fault = |message: String| {
                let place = self.key[..depth].join(".");
                let span = Some(0..self.text.find('=').unwrap_or(self.text.len()));
                placed("--set", &self.text, span, format!("--set {}: `{place}` {message}", self.text), message, None)
            };
            let last = depth + 1 == self.key.len();
            if let Some(length) = length(item) {
                let index = part.parse().unwrap_or(usize::MAX);
                item = item
                    .get_mut(index)
                    .filter(|_| index < length)
                    .ok_or_else(|| fault(format!("has {length} entries, numbered from 0")))?;
            } else {
                let kind = item.type_name();
                let table = item.as_table_like_mut().ok_or_else(|| fault(format!("is a {kind}, it has no keys")))?;
                if !table.contains_key(part) {
                    let absent = if last { Item::Value(self.value.clone()) } else { Item::Table(toml_edit::Table::new()) };
                    table.insert(part, absent);
                }
                item = table.get_mut(part).ok_or_else(|| fault("cannot be set".to_owned()))?;
            }
        }
        // The surroundings of the old value (a comment behind it, a place in an array) stay as they are.
        let mut value = self.value.clone();
        if let Item::Value(old) = item {
            *value.decor_mut() = old.decor().clone();
        }
        *item = Item::Value(value);
        Ok(())
    }
}

/// Entries of an array or an array of tables.
fn length(item: &Item) -> Option<usize> {
    item.as_array().map(toml_edit::Array::len).or_else(|| item.as_array_of_tables().map(toml_edit::ArrayOfTables::len))
}

/// The text of a scene as it is on the disk, and as the overrides make it.
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    original: Document<String>,
    merged: Document<String>,
    overrides: Vec<Override>,
}

impl Source {
    pub(super) fn new(name: &str, text: &str, overrides: Vec<Override>) -> Result<Self> {
        let original = Document::parse(text.to_owned()).map_err(|error| {
            let message = one_line(error.message());
            placed(name, text, error.span(), format!("not valid TOML: {message}"), message, None)
        })?;
        let mut document = original.clone().into_mut();
        for entry in &overrides {
            entry.apply(&mut document)?;
        }
        let text = if overrides.is_empty() { text.to_owned() } else { document.to_string() };
        let merged = Document::parse(text)
            .map_err(|error| Error::input("--set", format!("the overrides do not leave a valid scene: {}", one_line(error.message()))))?;
        Ok(Source { name: name.to_owned(), original, merged, overrides })
    }

    /// The text with the overrides put in.
    pub fn text(&self) -> &str {
        self.merged.raw()
    }

    /// The overrides, `key=value` each.
    pub fn overrides(&self) -> impl Iterator<Item = &str> {
        self.overrides.iter().map(|entry| entry.text.as_str())
    }

    /// Gives an error whose place is a key of this scene the line and column of that key; returns others as they are.
    pub fn locate(&self, error: Error) -> Error {
        let Error::Input { place, message, help } = error else { return error };
        let key: Vec<String> = place.split('.').map(str::to_owned).collect();
        match lookup(self.merged.as_item(), &key[..1]) {
            Some(_) => self.error(Fault { key, message, help, of_key: false }),
            None => Error::Input { place, message, help },
        }
    }

    pub(super) fn merged(&self) -> &Document<String> {
        &self.merged
    }

    /// The fault as an error that shows its place: in the override that set the key, or else in the file.
    pub(super) fn error(&self, fault: Fault) -> Error {
        let Fault { key, message, help, of_key } = fault;
        let mut what = key.join(".");
        if let Some(Item::Value(value)) = lookup(self.merged.as_item(), &key).filter(|_| !of_key) {
            let value = value.to_string();
            if !value.trim().contains('\n') && value.len() <= 80 {
                what += &format!(" = {}", value.trim());
            }
        }
        let absent = lookup(self.original.as_item(), &key).is_none();
        let setter = |entry: &&Override| key.starts_with(&entry.key) || absent && !key.is_empty() && entry.key.starts_with(&key);
        if let Some(entry) = self.overrides.iter().rev().find(setter) {
            let span = if of_key { 0..entry.span.start.saturating_sub(1) } else { entry.span.clone() };
            return placed("--set", &entry.text, Some(span), format!("{what} (from --set): {message}"), message, help);
        }
        let shown = if what.is_empty() { message.clone() } else { format!("{what}: {message}") };
        placed(&self.name, self.original.raw(), Some(span(self.original.as_item(), &key, of_key)), shown, message, help)
    }
}

fn placed(name: &str, text: &str, span: Option<Range<usize>>, message: String, label: String, help: Option<String>) -> Error {
    let span = span.map(|span| {
        let start = span.start.min(text.len());
        (start, span.end.clamp(start, text.len()) - start).into()
    });
    Error::Scene(Box::new(SceneError { message, text: NamedSource::new(name, text.to_owned()), span, label, help }))
}

pub(super) fn one_line(message: &str) -> String {
    message.trim().replace('\n', ", ")
}

fn child<'a>(item: &'a Item, part: &str) -> Option<&'a Item> {
    if length(item).is_some() { item.get(part.parse::<usize>().ok()?) } else { item.get(part) }
}

fn lookup<'a>(root: &'a Item, key: &[String]) -> Option<&'a Item> {
    key.iter().try_fold(root, |item, part| child(item, part))
}

/// Bytes of the value at `key`, or of the key; of the nearest table around it, if it is not there.
fn span(root: &Item, key: &[String], of_key: bool) -> Range<usize> {
    let mut best = 0..0;
    let mut item = root;
    for part in key {
        let Some(next) = child(item, part) else { break };
        let of_name = item.as_table_like().and_then(|table| table.key(part)).and_then(toml_edit::Key::span);
        let of_value = next.span().filter(|span| !span.is_empty());
        best = if of_key { of_name.or(of_value) } else { of_value.or(of_name) }.unwrap_or(best);
        item = next;
    }
    best
}

/// The deepest key whose name, value or header lies around `span`.
pub(super) fn locate(root: &Item, span: &Range<usize>) -> Vec<String> {
    let around =
        |outer: Option<Range<usize>>| outer.filter(|outer| outer.start <= span.start && span.end <= outer.end).map(|outer| outer.len());
    let mut best = (usize::MAX, Vec::new());
    let mut waiting = vec![(root, Vec::new())];
    while let Some((item, key)) = waiting.pop() {
        let mut offer = |size: Option<usize>, key: &[String]| {
            if size.is_some_and(|size| size < best.0 || size == best.0 && key.len() > best.1.len()) {
                best = (size.unwrap_or(usize::MAX), key.to_vec());
            }
        };
        offer(around(item.span()).filter(|_| !key.is_empty()), &key);
        let below = |part: String| key.iter().cloned().chain([part]).collect::<Vec<_>>();
        if let Some(length) = length(item) {
            waiting.extend((0..length).filter_map(|index| Some((item.get(index)?, below(index.to_string())))));
        } else if let Some(table) = item.as_table_like() {
            for (name, value) in table.iter() {
                let key = below(name.to_owned());
                offer(around(table.key(name).and_then(toml_edit::Key::span)), &key);
                waiting.push((value, key));
            }
        }
    }
    best.1
}
