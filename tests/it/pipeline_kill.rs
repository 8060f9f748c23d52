//! Runs that are killed, interrupted, or started twice.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, names, text, with};
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::process::Child;
use std::time::{Duration, Instant};

/// Two hundred steps, so that there is time to strike.
fn long() -> String {
    with(DYNAMIC, "dt = 2e-3", "dt = 2e-4") + "[output]\ninterval = 0.001\n"
}

/// So long that it does not end by itself.
fn endless() -> String {
    with(&with(DYNAMIC, "dt = 2e-3", "dt = 1e-5"), "end = 0.04", "end = 100.0") + "[output]\ninterval = 1.0\n"
}

/// Waits until the run has done some steps.
fn wait_for_steps(sandbox: &Sandbox, child: &mut Child) {
    let deadline = Instant::now() + Duration::from_secs(20);
    while fs::metadata(sandbox.case("history.csv")).map_or(0, |m| m.len()) < 2000 {
        assert!(Instant::now() < deadline && child.try_wait().unwrap().is_none(), "the run does not come along");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn signal(child: &Child, number: &str) {
    let status = std::process::Command::new("kill").args([number, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

fn leftovers(sandbox: &Sandbox) -> Vec<String> {
    [names(&sandbox.case("")), names(&sandbox.case("run"))].concat().into_iter().filter(|n| n.contains(".tmp-")).collect()
}

/// Kills runs at random moments until so many were alive when it struck; whenever one ends, its files must be those of a run that was
/// never killed, and the next begins. Returns how many ended.
fn strike(scene: &str, threads: &str, kills: u32, mut seed: u64) -> u32 {
    let whole = Sandbox::new(scene).prepared();
    let started = Instant::now();
    whole.ok(&["run", "scene.toml"]);
    let duration = started.elapsed().as_micros() as u64;
    let run = ["run", "scene.toml", "--threads", threads];
    let (mut killed, mut ended) = (0, 0);
    while killed < kills {
        let sandbox = Sandbox::new(scene).prepared();
        loop {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let mut child = sandbox.spawn(&run);
            std::thread::sleep(Duration::from_micros((seed >> 33) % (duration / 3)));
            child.kill().unwrap();
            match child.wait().unwrap() {
                status if status.signal() == Some(9) => killed += 1,
                status => assert!(status.success()),
            }
            if killed >= kills || sandbox.ok(&["status", "scene.toml"]).0.contains("run     done") {
                break;
            }
        }
        sandbox.ok(&run);
        let (a, b) = (whole.result(), sandbox.result());
        assert_eq!(a.2, b.2);
        assert_eq!(a.1, b.1);
        assert!(a.0 == b.0, "the last checkpoint differs");
        assert_eq!(leftovers(&sandbox), Vec::<String>::new());
        ended += 1;
    }
    ended
}

#[test]
fn killed_at_any_moment() {
    strike(&long(), "1", 8, 20_240_229);
}

/// More of the same on command, `KILLS` times in all, with everything that a checkpoint may hold:
///
///     KILLS=200 cargo test --release --test it pipeline_kill::killed_very_often -- --ignored --nocapture
#[test]
#[ignore = "kills as often as KILLS says"]
fn killed_very_often() {
    let kills: u32 = std::env::var("KILLS").ok().and_then(|v| v.parse().ok()).unwrap_or(20);
    let quadratic = with(&with(DYNAMIC, "element = \"linear\"", "element = \"quadratic\""), "dt = 2e-3", "dt = 5e-4");
    let growth = "[rest.linear]\nm_plus = \"3 * sin(40 * t + 30 * x)\"\nm_minus = \"-2 * t\"\nmu = 0.01\n";
    let moisture = "[moisture]\nlayers = 4\nscheme = \"sdirk2\"\ndiffusivity = { through = 1e-6, along = 1e-5 }\n\
                    [[moisture.boundary]]\nside = \"top\"\nvalue = 10\n[rest.linear]\nmu = 1e-3\n";
    let moist = with(&with(&quadratic, growth, moisture), "[rest]\nramp = \"min(1, 20 * t)\"\n", "");
    let load_steps = with(STATIC, "steps = 8", "steps = 60");
    let scenes = [("motion", long()), ("quadratic", quadratic), ("moisture", moist), ("statics", load_steps)];
    for (k, (name, scene)) in scenes.iter().enumerate() {
        let share = kills / 4 + u32::from(kills % 4 > k as u32);
        let ended = strike(scene, ["1", "2"][k % 2], share, 77 + k as u64);
        println!("{name}: {share} kills in {ended} runs, each of which ended with the same bits as the one that was not killed");
    }
}

#[test]
fn interrupted_and_taken_up_again() {
    for (name, number, code) in [("-INT", 2, 130), ("-TERM", 15, 143)] {
        let sandbox = Sandbox::new(&endless()).prepared();
        let mut child = sandbox.spawn(&["run", "scene.toml"]);
        wait_for_steps(&sandbox, &mut child);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{err}");
        assert!(err.contains(&format!("error: stopped by signal {number} after a last checkpoint")), "{err}");
        let (newest, _) = sandbox.newest();
        assert!(err.contains(&newest), "{err}");
        // The history ends with the step of the checkpoint.
        let step: u64 = newest.trim_start_matches("step_").trim_end_matches(".h5").parse().unwrap();
        assert_eq!(sandbox.history().len() as u64, step + 1);
        assert_eq!(leftovers(&sandbox), Vec::<String>::new());
        let (_, err) = sandbox.ok(&["run", "scene.toml", "--stop-after", "1"]);
        assert!(err.contains(&newest), "{err}");
        assert_eq!(sandbox.newest().0, format!("step_{:08}.h5", step + 1));
    }
}

#[test]
fn interrupted_equals_uninterrupted() {
    let whole = Sandbox::new(&long()).prepared();
    whole.ok(&["run", "scene.toml"]);
    let sandbox = Sandbox::new(&long()).prepared();
    let mut child = sandbox.spawn(&["run", "scene.toml"]);
    wait_for_steps(&sandbox, &mut child);
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    sandbox.ok(&["run", "scene.toml"]);
    assert!(whole.result() == sandbox.result());
}

#[test]
fn all_and_ladders_stop_too() {
    let sandbox = Sandbox::new(&endless());
    let mut child = sandbox.spawn(&["all", "scene.toml"]);
    wait_for_steps(&sandbox, &mut child);
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(!sandbox.case("vtk").exists() && !sandbox.case("report.json").exists());

    let sandbox = Sandbox::new(&(endless() + "[report.ladder]\nmeasure = \"factorizations\"\nresolutions = [1]\n"));
    let child = sandbox.spawn(&["report", "--ladder", "scene.toml"]);
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "-INT");
    let status = child.wait_with_output().unwrap().status;
    // Before the first run begins, a signal ends the program as it does any other.
    assert!(status.code() == Some(130) || status.signal() == Some(2), "{status}");
    assert!(!sandbox.case("ladder.json").exists());
}

#[test]
fn a_second_process_is_refused() {
    let sandbox = Sandbox::new(&endless()).prepared();
    let mut child = sandbox.spawn(&["run", "scene.toml"]);
    wait_for_steps(&sandbox, &mut child);
    for arguments in [
        &["run", "scene.toml"][..],
        &["run", "scene.toml", "--restart"],
        &["all", "scene.toml"],
        &["mesh", "scene.toml"],
        &["setup", "scene.toml"],
    ] {
        let message = sandbox.fails(2, arguments);
        assert!(message.contains("another process is at work on this case"), "{arguments:?}: {message}");
    }
    sandbox.ok(&["status", "scene.toml"]);
    assert!(child.try_wait().unwrap().is_none());
    child.kill().unwrap();
    child.wait().unwrap();
    sandbox.ok(&["run", "scene.toml", "--stop-after", "1"]);
}

#[test]
fn a_closed_standard_error_does_not_stop_a_run() {
    let sandbox = Sandbox::new(DYNAMIC).prepared();
    let closed = || std::io::pipe().map(|(_, writer)| writer).unwrap();
    let status = sandbox.command(&["run", "scene.toml", "-vv"]).stdout(closed()).stderr(closed()).status().unwrap();
    assert_eq!(status.code(), Some(0));
    assert_eq!(sandbox.newest().0, "step_00000020.h5");
}

/// The log tells each step once, in order.
#[test]
fn verbose_runs_tell_each_step() {
    let sandbox = Sandbox::new(DYNAMIC).prepared();
    let mut child = sandbox.spawn(&["run", "scene.toml", "-v"]);
    let lines: Vec<String> =
        BufReader::new(child.stderr.take().unwrap()).lines().map(|l| l.unwrap()).filter(|l| l.starts_with("step ")).collect();
    child.wait().unwrap();
    assert_eq!(lines.len(), 20);
    assert!(lines.iter().enumerate().all(|(i, l)| l.starts_with(&format!("step {}: ", i + 1))), "{lines:?}");
}
