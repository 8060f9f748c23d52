//! The tables of a report: exactly the promised keys, and nothing that is not a number passes.

use serde_json::{Value, json};
use thinshell::report::{Cost, ExpectationResult, LadderRow, Outcome, ladder};

const COST: Cost = Cost { dofs: 416, faces: 32, wall_s: 0.25, newton_iterations: 20, factorizations: 21 };

#[test]
fn report_has_exactly_these_keys() {
    let expectations = vec![
        ExpectationResult::new("tip", 3.5, 3.25, 0.5, "elastica"),
        ExpectationResult::new("lost | found", f64::NAN, 1.0, f64::INFINITY, "by hand"),
    ];
    let outcome = Outcome::new("strip", expectations, COST);
    let expected = json!({
        "scene": "strip", "passed": false,
        "expectations": [
            {"name": "tip", "value": 3.5, "reference": 3.25, "error": 0.25, "tolerance": 0.5, "passed": true, "source": "elastica"},
            {"name": "lost | found", "value": null, "reference": 1.0, "error": null, "tolerance": null, "passed": false, "source": "by hand"},
        ],
        "dofs": 416, "faces": 32, "wall_s": 0.25, "newton_iterations": 20, "factorizations": 21,
    });
    assert_eq!(serde_json::from_str::<Value>(&outcome.to_json()).unwrap(), expected);
    let markdown = outcome.to_markdown();
    assert!(markdown.starts_with("# strip: missed\n"), "{markdown}");
    assert!(markdown.contains("lost \\| found") && markdown.contains("416 unknowns on 32 faces"), "{markdown}");
    let rows: Vec<_> = markdown.lines().filter(|l| l.starts_with('|')).collect();
    assert_eq!(rows.len(), 4);
    assert!(rows.iter().all(|r| r.replace("\\|", "").matches('|').count() == 8), "{markdown}");
}

#[test]
fn only_finite_values_within_the_tolerance_pass() {
    let passed = |value, reference, tolerance| ExpectationResult::new("", value, reference, tolerance, "").passed;
    assert!(passed(1.5, 1.0, 0.5) && passed(0.5, 1.0, 0.5) && passed(1.0, 1.0, 0.0));
    assert!(!passed(1.6, 1.0, 0.5) && !passed(0.4, 1.0, 0.5));
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!passed(odd, 1.0, f64::INFINITY) && !passed(1.0, odd, f64::INFINITY) && !passed(odd, odd, 1.0));
    }
    assert!(!passed(1.0, 1.0, f64::NAN));
    let met = Outcome::new("a", vec![ExpectationResult::new("x", 1.0, 1.0, 0.1, "")], COST);
    assert!(met.passed && met.to_markdown().starts_with("# a: passed\n"));
    let none = Outcome::new("a", vec![], COST);
    assert!(none.passed && none.to_markdown().starts_with("# a: expects nothing\n"));
}

fn row(director: &str, thickness: f64, faces: usize, error: Option<f64>) -> LadderRow {
    LadderRow {
        director: director.into(),
        mesh: "jittered".into(),
        thickness,
        faces,
        longest_edge: (faces as f64).powf(-0.5),
        dofs: 3 * faces,
        error,
        ..Default::default()
    }
}

#[test]
fn orders_compare_runs_of_one_kind() {
    // Errors of order 2 and 1 in h, interleaved; four times the faces is half of h.
    let mut rows = vec![
        row("free-tan", 1e-3, 100, Some(0.16)),
        row("average", 1e-3, 100, Some(0.2)),
        row("free-tan", 1e-3, 400, Some(0.04)),
        row("average", 1e-3, 400, Some(0.1)),
        row("free-tan", 1e-4, 400, Some(0.04)),
        row("free-tan", 1e-3, 1600, None),
        row("free-tan", 1e-3, 6400, Some(0.01)),
        row("average", 1e-3, 1600, Some(0.0)),
    ];
    ladder::orders(&mut rows);
    let orders: Vec<_> = rows.iter().map(|r| r.order.map(|o| (o * 1e9).round() / 1e9)).collect();
    assert_eq!(orders, [None, None, Some(2.0), Some(1.0), None, None, None, None]);
}

#[test]
fn orders_of_steps_are_by_the_step() {
    let of = |method, step, error| LadderRow { method: Some(method), step: Some(step), ..row("free-tan", 1e-3, 100, Some(error)) };
    let mut rows = [of("bdf2", 0.1, 0.16), of("implicit-euler", 0.1, 0.16), of("bdf2", 0.05, 0.04), of("implicit-euler", 0.05, 0.08)];
    ladder::orders(&mut rows);
    let orders: Vec<_> = rows.iter().map(|r| r.order.map(|o| (o * 1e9).round() / 1e9)).collect();
    assert_eq!(orders, [None, None, Some(2.0), Some(1.0)]);
    let markdown = ladder::to_markdown(&rows);
    assert!(markdown.contains("| step [s] |") && markdown.contains("| implicit-euler |"), "{markdown}");
    assert!(rows[2].kind().ends_with("bdf2, steps of 0.05 s"), "{}", rows[2].kind());
}

#[test]
fn ladder_has_exactly_these_keys() {
    let mut failed = row("average", 1e-3, 400, None);
    failed.failure = Some("no | convergence\nat step 3".into());
    let rows = [row("free-tan", 1e-3, 100, Some(3.2e-4)), failed, row("free-sin", 1e-3, 100, Some(f64::NAN))];
    let expected = json!([
        {"director": "free-tan", "mesh": "jittered", "thickness": 1e-3, "faces": 100, "longest_edge": 0.1, "dofs": 300, "error": 3.2e-4, "order": null,
            "fitted_order": null, "wall_s": 0.0, "gflop": 0.0, "factorizations": 0},
        {"director": "average", "mesh": "jittered", "thickness": 1e-3, "faces": 400, "longest_edge": 0.05, "dofs": 1200, "error": null, "order": null,
            "fitted_order": null, "wall_s": 0.0, "gflop": 0.0, "factorizations": 0, "failure": "no | convergence\nat step 3"},
        {"director": "free-sin", "mesh": "jittered", "thickness": 1e-3, "faces": 100, "longest_edge": 0.1, "dofs": 300, "error": null, "order": null,
            "fitted_order": null, "wall_s": 0.0, "gflop": 0.0, "factorizations": 0},
    ]);
    assert_eq!(serde_json::from_str::<Value>(&ladder::to_json(&rows)).unwrap(), expected);
    let text = ladder::to_csv(&rows);
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    let records: Vec<csv::StringRecord> = table.records().map(|r| r.unwrap()).collect();
    let of = |row: usize, name: &str| records[row][header.iter().position(|h| h == name).unwrap()].to_owned();
    assert_eq!((of(0, "director"), of(0, "error"), of(0, "order")), ("free-tan".into(), "0.00032".into(), String::new()));
    assert_eq!((of(1, "error"), of(1, "failure")), (String::new(), "no | convergence\nat step 3".into()));
    // Every key is a column.
    for key in expected[1].as_object().unwrap().keys() {
        assert!(header.contains(key), "{key}");
    }
    let markdown = ladder::to_markdown(&rows);
    assert_eq!(markdown.lines().count(), 5, "{markdown}");
    assert!(markdown.contains("failed: no \\| convergence at step 3") && markdown.contains("3.200e-4"), "{markdown}");
    let widths: Vec<_> = markdown.lines().map(|l| l.chars().count()).collect();
    assert!(widths.iter().all(|w| *w == widths[0]), "{markdown}");
}
