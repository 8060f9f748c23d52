//! A run that was stopped and taken up again is, bit by bit, the run that was not.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use std::fs;

/// Runs the scene at once and in pieces of these numbers of steps, then to the end; both must leave the same.
fn assert_same(scene: &str, pieces: &[u32]) -> Sandbox {
    let whole = Sandbox::new(scene).prepared();
    whole.ok(&["run", "scene.toml"]);
    let parts = Sandbox::new(scene).prepared();
    for piece in pieces {
        parts.ok(&["run", "scene.toml", "--stop-after", &piece.to_string()]);
    }
    let (_, err) = parts.ok(&["run", "scene.toml"]);
    assert!(err.contains("going on from cases/scene/run/step_"), "{err}");
    let (a, b) = (whole.result(), parts.result());
    assert_eq!(a.2, b.2, "histories differ");
    assert_eq!(a.1, b.1, "checkpoints differ in name");
    assert!(a.0 == b.0, "the last checkpoint {} differs from {}", a.0.0, b.0.0);
    parts
}

#[test]
fn in_motion() {
    let parts = assert_same(DYNAMIC, &[10]);
    assert_eq!(parts.newest().0, "step_00000020.h5");
    assert_same(DYNAMIC, &[1, 1, 3]);
}

#[test]
fn in_statics() {
    assert_same(STATIC, &[4]);
    assert_same(STATIC, &[1, 2]);
}

#[test]
fn with_other_directors_and_masses() {
    for director in ["average", "free-sin"] {
        let director = format!("[shell]\ndirector = \"{director}\"\nmass = \"lumped\"");
        assert_same(&with(DYNAMIC, "[shell]", &director), &[7]);
        assert_same(&with(STATIC, "[shell]", &director), &[3]);
    }
}

#[test]
fn with_a_machine_direction() {
    let fibres = "mu = 0.01\nmu_perp = 0.03\n[machine-direction]\nangle = \"30 + 100 * x\"";
    assert_same(&with(DYNAMIC, "mu = 0.01", fibres), &[7]);
}

#[test]
fn between_output_times() {
    let scene = format!("{DYNAMIC}\n[output]\ninterval = 0.007\n");
    let parts = assert_same(&scene, &[5, 4]);
    assert!(parts.names("cases/scene/run").len() < 10);
    assert_same(&format!("{STATIC}\n[output]\ninterval = 0.3\n"), &[5]);
}

/// Few iterations make large steps fail, which are then halved and grow again.
#[test]
fn with_halved_steps() {
    let scene = with(&with(STATIC, "30 * t", "60 * t"), "steps = 8", "steps = 2") + "[solver]\nmax_iterations = 4\n";
    for pieces in [&[1][..], &[2], &[1, 1, 1]] {
        let parts = assert_same(&scene, pieces);
        let halved = parts.history().iter().skip(1).filter(|row| row.split(',').nth(3) != Some("0.0")).count();
        assert!(halved > 0, "no step was halved: {:?}", parts.history());
    }
}

#[test]
fn a_later_end_and_other_reports_resume() {
    let sandbox = Sandbox::new(DYNAMIC);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    sandbox.rewrite(&with(DYNAMIC, "end = 0.04", "end = 0.05"));
    let changes = [
        "dynamics.end=0.045",
        "title=new",
        "output.interval=0.01",
        "report.expect=[{name='n', measure='factorizations', reference=0, tolerance=1e6, source='none'}]",
    ];
    for change in changes {
        let (_, err) = sandbox.ok(&["run", "scene.toml", "--set", change]);
        assert!(err.contains("going on from cases/scene/run/step_0000002") && !err.contains("warning"), "{change}: {err}");
    }
    assert_eq!(sandbox.newest().0, "step_00000026.h5");
    // A shorter end does not throw away what is there; starting over does.
    let message = sandbox.fails(2, &["run", "scene.toml", "--set", "dynamics.end=0.02"]);
    assert!(message.contains("step_00000026.h5") && message.contains("past the end") && message.contains("--restart"), "{message}");
    sandbox.fails(2, &["report", "scene.toml", "--set", "dynamics.end=0.02"]);
    assert_eq!(sandbox.newest().0, "step_00000026.h5");
    sandbox.ok(&["all", "scene.toml", "-q", "--set", "dynamics.end=0.02"]);
    assert_eq!(sandbox.newest().0, "step_00000010.h5");
    assert_eq!(sandbox.history().len(), 11);
}

#[test]
fn restart_starts_over() {
    let sandbox = Sandbox::new(DYNAMIC).prepared();
    sandbox.ok(&["run", "scene.toml"]);
    let first = sandbox.result();
    sandbox.ok(&["run", "scene.toml", "--restart", "--stop-after", "3"]);
    assert_eq!(sandbox.names("cases/scene/run"), [0, 1, 2, 3].map(|n| format!("step_{n:08}.h5")));
    sandbox.ok(&["run", "scene.toml"]);
    assert_eq!(sandbox.result(), first);
    let (_, err) = sandbox.ok(&["run", "scene.toml"]);
    assert!(err.contains("going on") && sandbox.result() == first, "{err}");
}

/// A crash between the first checkpoint of a new start and its history leaves the history of another run.
#[test]
fn a_foreign_history_beside_the_first_checkpoint_is_replaced() {
    let sandbox = Sandbox::new(DYNAMIC).prepared();
    sandbox.ok(&["run", "scene.toml"]);
    let whole = sandbox.result();
    sandbox.ok(&["run", "scene.toml", "--restart", "--stop-after", "1"]);
    fs::remove_file(sandbox.case("run/step_00000001.h5")).unwrap();
    fs::write(sandbox.case("history.csv"), "step,other,wall_s\n1,2,3\n").unwrap();
    sandbox.ok(&["run", "scene.toml"]);
    assert_eq!(sandbox.result(), whole);
}
