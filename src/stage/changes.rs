//! What of a scene has changed since its case was made, for messages about files that are out of date. Decides nothing: hashes do that.

use super::{Job, RECORD};
use crate::scene::{self, Scene};
use serde_json::Value;

/// Most changes that are told one by one.
const MOST: usize = 3;
/// Longest value that is told [characters].
const LONGEST: usize = 40;
/// Tables and keys on which no file of a case depends.
const OF_NO_EFFECT: [&str; 3] = ["title", "description", "report"];

/// The keys whose values differ from those that the case was made with, in words; none if the case does not tell.
pub fn since(job: &Job) -> Option<String> {
    let text = std::fs::read_to_string(job.case.join(RECORD)).ok()?;
    let (then, _) = scene::parse(RECORD, &text, &[]).ok()?;
    let value = |scene: &Scene| serde_json::to_value(scene).ok();
    let mut found = Vec::new();
    compare("", Some(&value(&then)?), Some(&value(&job.self_contained().ok()?)?), &mut found);
    let more = found.len().saturating_sub(MOST);
    found.truncate(MOST);
    found.extend((more > 0).then(|| format!("{more} more")));
    (!found.is_empty()).then(|| found.join("; "))
}

fn compare(key: &str, then: Option<&Value>, now: Option<&Value>, found: &mut Vec<String>) {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match (then, now) {
        _ if then == now || OF_NO_EFFECT.contains(&key) => {}
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
            names.for_each(|name| compare(&below(name), a.get(name), b.get(name), found));
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) if a.len() == b.len() => {
            (0..a.len()).for_each(|i| compare(&below(&i.to_string()), a.get(i), b.get(i), found));
        }
        _ => {
            let [then, now] = [then, now].map(|value| match value {
                None => "absent".to_owned(),
                Some(value) => Some(value.to_string()).filter(|text| text.len() <= LONGEST).unwrap_or_else(|| "another".into()),
            });
            found.push(format!("{key} was {then}, is {now}"));
        }
    }
}
