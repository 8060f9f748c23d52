//! Table `[[report.sweep]]`: a scene run with several values of one or two of its keys.

use super::{Measure, Passage};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene run with several values of a key, or with all pairs of values of two keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Name in the report.
    pub name: String,
    /// Key of the scene, as on the command line: `shell.thickness`, `mesh.rectangle.cells.0`, `pin.0.region`.
    pub key: String,
    /// Its values. Exactly one of `values` and `logarithmic` must be given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<SweepValue>,
    /// Its values, evenly spaced by their logarithms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub logarithmic: Option<Logarithmic>,
    /// Other keys that change along with it, each with as many values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<Tied>,
    /// Another key, for a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second: Option<SecondKey>,
    /// Changes of the scene that hold for all runs, as behind `--set`: `"cosserat.scheme=strong-form"`, `"dynamics.end=2"`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// What is measured of each run.
    pub measures: Vec<SweepMeasure>,
    /// How far the shapes of successive runs are from each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes: Option<Shapes>,
    /// Up to which value of the second key a measure suffices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<Largest>,
    /// A law fitted to one of the measures, for each value of the second key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<Fit>,
}

/// The second key of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SecondKey {
    /// Key of the scene.
    pub key: String,
    /// Its values. Exactly one of `values` and `logarithmic` must be given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<SweepValue>,
    /// Its values, evenly spaced by their logarithms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub logarithmic: Option<Logarithmic>,
}

impl Sweep {
    /// The values of the first key.
    pub fn list(&self) -> Vec<SweepValue> {
        self.logarithmic.map_or_else(|| self.values.clone(), |table| table.values())
    }
}

impl SecondKey {
    /// The values.
    pub fn list(&self) -> Vec<SweepValue> {
        self.logarithmic.map_or_else(|| self.values.clone(), |table| table.values())
    }
}

/// A key that changes along with another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tied {
    /// Key of the scene.
    pub key: String,
    /// Its values, one for each of the other key.
    pub values: Vec<SweepValue>,
}

/// Two more columns: the distance of each run's shape from that of the value of the first key before, root mean square and largest over the
/// nodes that all runs have in the same initial places. Shapes that converge come ever closer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shapes {
    /// Time of the checkpoints to compare [s]; the nearest kept ones are taken. Absent: the last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
}

/// One more table: for each value of the first key the largest value of the second with which, and with all smaller ones, a measure is large
/// enough, as the largest stable time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Largest {
    /// Name of the measure.
    pub measure: String,
    /// Its smallest value that suffices, in its unit.
    pub least: f64,
}

/// Numbers evenly spaced by their logarithms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Logarithmic {
    /// First value, > 0, in the key's unit.
    pub from: f64,
    /// Last value, > 0.
    pub to: f64,
    /// How many there are, 2 to 1000, both ends included.
    pub count: usize,
}

impl Logarithmic {
    /// The values.
    pub fn values(&self) -> Vec<SweepValue> {
        let at = |i: usize| match i {
            0 => self.from,
            i if i + 1 == self.count => self.to,
            i => self.from * (self.to / self.from).powf(i as f64 / (self.count - 1) as f64),
        };
        (0..self.count).map(|i| SweepValue::Number(at(i))).collect()
    }
}

/// A value of a key: a number, true or false, or a text as it would stand on the command line behind `--set key=`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum SweepValue {
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// True or false.
    Truth(bool),
    /// A text, an expression, an array: `"free-tan"`, `"[20, 4]"`.
    Text(String),
}

impl SweepValue {
    /// As it stands on the command line.
    pub fn text(&self) -> String {
        match self {
            SweepValue::Whole(value) => value.to_string(),
            SweepValue::Number(value) => format!("{value:?}"),
            SweepValue::Truth(value) => value.to_string(),
            SweepValue::Text(text) => text.clone(),
        }
    }

    /// As a number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            SweepValue::Whole(value) => Some(*value as f64),
            SweepValue::Number(value) => Some(*value),
            SweepValue::Truth(_) | SweepValue::Text(_) => None,
        }
    }
}

impl<'de> Deserialize<'de> for SweepValue {
    // By hand, because an untagged enum would lose the place of a wrong value in the file.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = SweepValue;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, true, false or a text")
            }
            fn visit_f64<E>(self, v: f64) -> Result<SweepValue, E> {
                Ok(SweepValue::Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<SweepValue, E> {
                Ok(SweepValue::Whole(v))
            }
            fn visit_bool<E>(self, v: bool) -> Result<SweepValue, E> {
                Ok(SweepValue::Truth(v))
            }
            fn visit_str<E>(self, v: &str) -> Result<SweepValue, E> {
                Ok(SweepValue::Text(v.to_owned()))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A measure of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepMeasure {
    /// Name in the table.
    pub name: String,
    /// What is measured at the end of each run, or at `time`, `limit-point` or `passage`.
    pub measure: Measure,
    /// Time of the checkpoint to measure [s]; the nearest kept one is taken. Absent: the last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Number of a limit point, from 1, on a path by arc length.
    #[serde(default, rename = "limit-point", skip_serializing_if = "Option::is_none")]
    pub limit_point: Option<usize>,
    /// Where another measure comes to a value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passage: Option<Passage>,
    /// Smallest value that passes, in the measure's unit. A limit needs a `source`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Largest value that passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// Where the limits come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// A law `measure = prefactor * key^exponent`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Name of the measure.
    pub measure: String,
    /// Name of a measure: for each value of the first key only that run of the second key's values counts which has the lowest value of it, as
    /// the energy of one of several equilibria. Absent: one law for each value of the second key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lowest: Option<String>,
    /// Kind of law.
    #[serde(default)]
    pub kind: FitKind,
    /// What the exponent should be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<FitExpectation>,
}

/// Kind of a fitted law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FitKind {
    /// A power law, by least squares of the logarithms. Values of the key must be numbers > 0.
    #[default]
    Power,
}

/// What is expected of a law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitExpectation {
    /// Exponent [1].
    pub exponent: f64,
    /// Largest distance from it that passes [1], >= 0.
    pub tolerance: f64,
    /// Where it comes from.
    pub source: String,
}
