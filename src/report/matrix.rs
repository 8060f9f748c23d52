//! What became of a scene at the ends of what its keys may be: `matrix.json` and its table.

use super::{cell, number, table};
use serde::Serialize;
use serde_json::Value;

/// One run of a matrix.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MatrixCell {
    /// Name of the scene.
    pub scene: String,
    /// Name of the part.
    pub part: String,
    /// Keys and their values.
    pub values: Vec<(String, Value)>,
    /// How it ended: 0 in a solution, else the exit code of the error that says why it did not.
    pub exit: u8,
    /// That error.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub message: String,
    /// What is wrong with it; empty for a cell that passes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<String>,
    /// Work and result of a run that converged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solution: Option<MatrixSolution>,
    /// Run time of everything, files and judgement included [s].
    pub wall_s: f64,
}

/// Work and result of a run that converged.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MatrixSolution {
    /// Number of faces.
    pub faces: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Accepted steps.
    pub steps: usize,
    /// Mixed iterations.
    pub newton_iterations: u64,
    /// Descent iterations.
    pub fallback_iterations: u64,
    /// Numeric factorisations.
    pub factorizations: u64,
    /// Steps that were halved.
    pub halvings: u64,
    /// Median of the iterations of a step.
    pub median_iterations: f64,
    /// Negative pivots at the end.
    pub negative_pivots: u64,
    /// Largest residual of a step, over the largest stiffness times the diameter [1].
    pub residual: f64,
    /// Elastic energy over the sum of E h A [1].
    pub energy: f64,
    /// Gain of energy [1], where it has a meaning. Statics: the potential energy at the end less that of the initial shape under the loads and
    /// with the rest shape of the end. Motion: the largest total energy after a step less that at the start. Over the larger of both, in motion
    /// over the largest sum of the sizes of its parts; at most round-off for what descends from where it started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Share of that scale which motion has lost at the end, to the integrator and to viscosity [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<f64>,
    /// Momentum at the end less that at the start and what gravity brought, over the sum of mass times speed at the start and what gravity
    /// brought [1], where no support takes any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<f64>,
    /// What was measured: name and value, in the measure's unit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<(String, Option<f64>)>,
}

/// Contents of `matrix.json`.
pub fn to_json(cells: &[MatrixCell]) -> String {
    let passed = cells.iter().all(|cell| cell.faults.is_empty());
    super::outcome::json(&serde_json::json!({ "passed": passed, "cells": cells }))
}

/// The table as Markdown, then what is wrong.
pub fn to_markdown(cells: &[MatrixCell]) -> String {
    let header = [
        "scene",
        "part",
        "cell",
        "ended",
        "measured",
        "passed",
        "steps",
        "iterations",
        "of descent",
        "factorisations",
        "halvings",
        "per step",
        "residual",
        "energy over E h A",
        "gain",
        "lost",
        "momentum",
        "time [s]",
    ];
    let row = |c: &MatrixCell| -> Vec<String> {
        let verdict = if c.faults.is_empty() { "yes" } else { "**no**" };
        let ended = if c.exit == 0 { "converged".into() } else { format!("refused ({}): {}", c.exit, cell(&c.message)) };
        let texts = [cell(&c.scene), cell(&c.part), place(c), ended];
        let s = c.solution.as_ref();
        let count = |of: &dyn Fn(&MatrixSolution) -> u64| s.map_or("-".into(), |s| of(s).to_string());
        let value = |of: &dyn Fn(&MatrixSolution) -> Option<f64>| s.and_then(of).map_or("-".into(), number);
        let measured = s.map_or(String::new(), |s| {
            let one = |(name, v): &(String, Option<f64>)| format!("{} {}", cell(name), v.map_or("-".into(), number));
            s.measures.iter().map(one).collect::<Vec<_>>().join(", ")
        });
        let numbers = [
            count(&|s| s.steps as u64),
            count(&|s| s.newton_iterations),
            count(&|s| s.fallback_iterations),
            count(&|s| s.factorizations),
            count(&|s| s.halvings),
            value(&|s| Some(s.median_iterations)),
            value(&|s| Some(s.residual)),
            value(&|s| Some(s.energy)),
            value(&|s| s.gain),
            value(&|s| s.lost),
            value(&|s| s.momentum),
            format!("{:.2}", c.wall_s),
        ];
        texts.into_iter().chain([measured, verdict.into()]).chain(numbers).collect()
    };
    let mut text = table(&header, 6, &cells.iter().map(row).collect::<Vec<_>>());
    let converged = cells.iter().filter(|c| c.exit == 0).count();
    let bad = cells.iter().filter(|c| !c.faults.is_empty()).count();
    text += &format!("\n{} cells: {converged} converged, {} refused, {bad} with faults.\n", cells.len(), cells.len() - converged);
    if bad > 0 {
        text += "\nFaults:\n\n";
        for c in cells {
            c.faults.iter().for_each(|fault| text += &format!("- {}: {fault}\n", title(c)));
        }
    }
    text
}

/// A cell in words.
pub fn title(c: &MatrixCell) -> String {
    format!("{}, {}, {}", cell(&c.scene), cell(&c.part), place(c))
}

fn place(c: &MatrixCell) -> String {
    let value = |(key, value): &(String, Value)| format!("{} {}", cell(key.rsplit('.').next().unwrap_or(key)), super::sweep::word(value));
    c.values.iter().map(value).collect::<Vec<_>>().join(", ")
}
