//! Disks that are full, folders that cannot be written: one clear error, and the last checkpoint is whole.

use super::pipeline_support::{DYNAMIC, Sandbox, text};
use std::fs;
use std::process::Command;

/// Two hundred numbers more a checkpoint than the smallest scene has, so that disks fill up soon.
const SCENE: &str = DYNAMIC;

/// What is left in the case lets a run go on to the same end as one that never met a full disk.
fn goes_on(sandbox: &Sandbox) {
    let whole = Sandbox::new(SCENE).prepared();
    whole.ok(&["run", "scene.toml", "-q"]);
    sandbox.ok(&["run", "scene.toml", "-q"]);
    assert!(whole.result() == sandbox.result());
}

fn assert_one_error(err: &str, words: &[&str]) {
    assert_eq!(err.matches("error: ").count(), 1, "{err}");
    assert!(!err.contains("panicked"), "{err}");
    assert!(words.iter().any(|w| err.contains(w)), "{words:?}: {err}");
}

/// A limit on the size of files stands for a full disk where nobody may mount one.
#[test]
fn files_that_cannot_grow() {
    let sandbox = Sandbox::new(SCENE).prepared();
    sandbox.ok(&["run", "scene.toml", "-q", "--stop-after", "3"]);
    let before = sandbox.result();
    for blocks in ["1", "4"] {
        let run = format!("trap '' XFSZ; ulimit -f {blocks}; exec {} run scene.toml -q", env!("CARGO_BIN_EXE_thinshell"));
        let output = Command::new("sh").args(["-c", &run]).current_dir(sandbox.path("")).output().unwrap();
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{err}");
        assert_one_error(&err, &["File too large"]);
        assert!(err.contains("case.toml") || err.contains("step_") || err.contains("history.csv"), "names the file: {err}");
        assert!(sandbox.newest() == before.0, "{blocks}: the last checkpoint is another one");
    }
    goes_on(&sandbox);
}

/// Runs a script in a name space of its own, where it may mount; false, with a message, where the system forbids that.
fn in_own_mounts(sandbox: &Sandbox, script: &str) -> bool {
    let probe = |arguments: &[&str]| Command::new("unshare").args(arguments).output().is_ok_and(|o| o.status.success());
    let options = ["-m", "-rm"].into_iter().find(|options| {
        fs::create_dir_all(sandbox.path("probe")).unwrap();
        let mount = format!("mount -t tmpfs none {}", sandbox.path("probe").display());
        probe(&[options, "sh", "-c", &mount])
    });
    let Some(options) = options else {
        eprintln!("skipped: this user may not mount file systems");
        return false;
    };
    let output = Command::new("unshare").args([options, "sh", "-euc", script]).current_dir(sandbox.path("")).output().unwrap();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    true
}

/// A case on a small disk of its own; `meet` runs there, and what it leaves is copied back.
fn on_a_small_disk(meet: &str) -> Option<(Sandbox, String)> {
    let sandbox = Sandbox::new(SCENE).prepared();
    sandbox.ok(&["run", "scene.toml", "-q", "--stop-after", "3"]);
    let script = format!(
        "thinshell={}
        mkdir disk; mount -t tmpfs -o size=600k none disk
        cp -r cases/. disk/; rm -r cases
        {meet}
        cp -r disk cases",
        env!("CARGO_BIN_EXE_thinshell")
    );
    if !in_own_mounts(&sandbox, &script) {
        return None;
    }
    let err = fs::read_to_string(sandbox.path("err")).unwrap();
    Some((sandbox, err))
}

#[test]
fn full_disks() {
    let fill = "dd if=/dev/zero of=disk/ballast bs=1k 2>/dev/null || true
        rm -f disk/freed; code=0
        $thinshell run scene.toml --case disk/scene -q 2>err || code=$?
        test $code = 2
        rm disk/ballast";
    let Some((sandbox, err)) = on_a_small_disk(fill) else { return };
    assert_one_error(&err, &["No space left on device"]);
    goes_on(&sandbox);
}

/// The disk fills up during the run.
#[test]
fn disks_that_fill_up() {
    let fill = "dd if=/dev/zero of=disk/ballast bs=1k 2>/dev/null || true
        truncate -s -40k disk/ballast; code=0
        $thinshell run scene.toml --case disk/scene -q 2>err || code=$?
        test $code = 2
        rm disk/ballast";
    let Some((sandbox, err)) = on_a_small_disk(fill) else { return };
    assert_one_error(&err, &["No space left on device"]);
    assert!(sandbox.names("cases/scene/run").len() > 3, "nothing was written before the disk was full");
    goes_on(&sandbox);
}

#[test]
fn folders_that_cannot_be_written() {
    let forbid = "mount -o remount,ro disk; code=0
        $thinshell run scene.toml --case disk/scene -q 2>err || code=$?
        test $code = 2
        $thinshell status scene.toml --case disk/scene
        mount -o remount,rw disk";
    let Some((sandbox, err)) = on_a_small_disk(forbid) else { return };
    assert_one_error(&err, &["Read-only file system"]);
    goes_on(&sandbox);
}
