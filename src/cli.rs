//! The command line: verbs and flags, and which stage each of them calls. Computes nothing.

mod keys;

use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::stage::{self, Job};
use clap::{ArgAction, Args, Parser, Subcommand};
use log::LevelFilter;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Target of log records that go to the file of `--log` but not to standard error, which shows them in another form.
pub const FILE_ONLY: &str = "file-only";

/// Simulates thin shells whose rest shape changes: paper that takes up water, leaves that grow, sheets that curl.
///
/// A scene is a TOML file. Stages turn it into a case, a folder of files; each stage reads what the one before it wrote.
#[derive(Debug, Parser)]
#[command(
    version,
    max_term_width = 110,
    arg_required_else_help = true,
    after_help = "\
Example:
  thinshell all configs/analytic/strip_curl.toml    everything, into cases/strip_curl
  thinshell report cases/strip_curl                 what the scene expects, and what came out

Exit codes:
  0    done
  1    done, but an expectation of the scene was missed
  2    bad input or stale file; nothing was written
  3    the equations could not be solved; the last good checkpoint is kept
  130  stopped by Ctrl-C after a last checkpoint (143: by a request to terminate)"
)]
pub struct CommandLine {
    #[command(subcommand)]
    verb: Verb,
    /// Say more; twice: everything.
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet")]
    verbose: u8,
    /// Say only what is wrong, and show no progress.
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Also append all messages to this file, with the time since the start.
    #[arg(long, global = true, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Threads to work with; results are the same for any number [default: that of THINSHELL_THREADS, or of processors].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

/// Where the number of threads stands if no flag says it.
const THREADS: &str = "THINSHELL_THREADS";

#[derive(Debug, Subcommand)]
enum Verb {
    /// Check a scene and print which parts it has; write nothing.
    ///
    /// Example: thinshell check scene.toml --set shell.thickness=1e-4
    Check(SceneArgs),
    /// Make the mesh (mesh.h5).
    ///
    /// Example: thinshell mesh scene.toml --set 'mesh.rectangle.cells=[40, 8]'
    Mesh(SceneArgs),
    /// Make rest forms, materials, supports and the first state (setup.h5).
    ///
    /// Example: thinshell setup scene.toml
    Setup(SceneArgs),
    /// Simulate, from the newest valid checkpoint on (run/, history.csv).
    ///
    /// Example: thinshell run scene.toml --restart
    Run {
        #[command(flatten)]
        scene: SceneArgs,
        #[command(flatten)]
        options: stage::run::Options,
    },
    /// Find the lowest modes of vibration or buckling about the last equilibrium (modes.h5, modes.json), where the scene has [modes].
    ///
    /// Example: thinshell modes scene.toml --set modes.count=8
    Modes(SceneArgs),
    /// Write the checkpoints as VTK files (vtk/).
    ///
    /// Example: thinshell export scene.toml
    Export(SceneArgs),
    /// Compare results with what their scenes expect (report.json, report.md); or tabulate error against run time, what changes over the values
    /// of a key, or how a scene ends where it is hard.
    ///
    /// Examples:
    ///   thinshell report cases/strip_curl cases/wetted_strip --json all.json
    ///   thinshell report --ladder scene.toml
    ///   thinshell report --sweep scene.toml
    ///   thinshell report --matrix configs/stress/*.toml
    #[command(verbatim_doc_comment)]
    Report(ReportArgs),
    /// Print which stages of a case are done, stale or missing.
    ///
    /// Example: thinshell status scene.toml
    Status(SceneArgs),
    /// Do every stage that is out of date, from mesh to report.
    ///
    /// Example: thinshell all scene.toml --case /tmp/try-1
    All(SceneArgs),
    /// Print the JSON schema of scene files, for editors that complete and check them.
    ///
    /// Examples:
    ///   thinshell schema > scene.schema.json
    ///   thinshell schema --text shell        the keys of [shell] and of the tables in it
    #[command(verbatim_doc_comment)]
    Schema {
        /// Print a list to read instead: each key with its type, default and meaning; of this table, or of all.
        #[arg(long, value_name = "TABLE", num_args = 0..=1, default_missing_value = "")]
        text: Option<String>,
    },
}

#[derive(Debug, Args)]
struct SceneArgs {
    /// The scene file, or the folder of a case, which keeps the scene it was made from.
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Folder of the case [default: cases/<name of the scene file>].
    #[arg(long, value_name = "DIR")]
    case: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

#[derive(Debug, Args)]
struct Overrides {
    /// Another value for a key of the scene: shell.thickness=1e-4, pin.0.region=left. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Debug, Args)]
struct ReportArgs {
    /// Folders of cases, or scene files, which stand for cases/<name of the scene file>.
    #[arg(value_name = "CASE_OR_SCENE", required_unless_present_any = ["ladder", "sweep", "matrix"])]
    targets: Vec<PathBuf>,
    /// Run this scene at the resolutions of its [report.ladder] and tabulate error against run time.
    #[arg(long, value_name = "SCENE.toml", conflicts_with = "targets")]
    ladder: Option<PathBuf>,
    /// Run this scene at the values of its [[report.sweep]] and tabulate what is measured.
    #[arg(long, value_name = "SCENE.toml", conflicts_with_all = ["targets", "ladder"])]
    sweep: Option<PathBuf>,
    /// Run these scenes at all cells of their [report.matrix] and judge how each ends (cases/matrix).
    #[arg(long, value_name = "SCENE.toml", num_args = 1.., conflicts_with_all = ["targets", "ladder", "sweep"])]
    matrix: Vec<PathBuf>,
    #[command(flatten)]
    cells: stage::report::MatrixOptions,
    /// Also write everything as JSON to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

impl CommandLine {
    /// Calls the stage.
    ///
    /// # Errors
    /// The stage's own.
    pub fn run(&self) -> Result<()> {
        self.start_threads()?;
        match &self.verb {
            Verb::Check(scene) => self.at(scene, stage::check::run),
            Verb::Mesh(scene) => self.at(scene, stage::mesh::run),
            Verb::Setup(scene) => self.at(scene, stage::setup::run),
            Verb::Run { scene, options } => self.at(scene, |job| stage::run::run(job, options)),
            Verb::Modes(scene) => self.at(scene, stage::modes::run),
            Verb::Export(scene) => self.at(scene, stage::export::run),
            Verb::Report(ReportArgs { ladder: Some(scene), json, overrides, .. }) => {
                explained(Job::read(scene, None, &overrides.set, self.quiet)?, |job| stage::report::ladder(job, json.as_deref()))
            }
            Verb::Report(ReportArgs { sweep: Some(scene), json, overrides, .. }) => {
                explained(Job::read(scene, None, &overrides.set, self.quiet)?, |job| stage::report::sweep(job, json.as_deref()))
            }
            Verb::Report(ReportArgs { matrix, cells, json, overrides, .. }) if !matrix.is_empty() => {
                stage::report::matrix(matrix, cells, &overrides.set, json.as_deref(), self.quiet)
            }
            Verb::Report(ReportArgs { targets, json, overrides, .. }) => {
                stage::report::run(targets, &overrides.set, json.as_deref(), self.quiet)
            }
            Verb::Status(scene) => self.at(scene, stage::status::run),
            Verb::All(scene) => self.at(scene, stage::all::run),
            Verb::Schema { text: None } => schema(),
            Verb::Schema { text: Some(table) } => stage::print(&keys::list(table)?),
        }
    }

    fn at(&self, arguments: &SceneArgs, stage: impl FnOnce(&Job) -> Result<()>) -> Result<()> {
        explained(Job::read(&arguments.scene, arguments.case.as_deref(), &arguments.overrides.set, self.quiet)?, stage)
    }

    /// Starts threads beside this one, which works with them.
    fn start_threads(&self) -> Result<()> {
        let number = match (self.threads, std::env::var(THREADS)) {
            (Some(number), _) => usize::from(number),
            (None, Ok(text)) => match text.parse::<u16>() {
                Ok(number) if number > 0 => usize::from(number),
                _ => return Err(Error::input(THREADS, format!("`{text}` is not a number of threads: expected 1 to {}", u16::MAX))),
            },
            (None, Err(_)) => std::thread::available_parallelism().map_or(1, usize::from),
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(number).use_current_thread().build_global();
        pool.map_err(|error| Error::input("threads", format!("{number} threads cannot be started: {error}")))
    }

    /// Sends log records to standard error, and to the file of `--log`.
    ///
    /// # Errors
    /// [`Error::Io`] if that file cannot be opened.
    pub fn start_log(&self) -> Result<()> {
        let level = match (self.quiet, self.verbose) {
            (true, _) => LevelFilter::Warn,
            (false, 0) => LevelFilter::Info,
            (false, 1) => LevelFilter::Debug,
            (false, _) => LevelFilter::Trace,
        };
        // Written by hand: a broken standard error must not stop the run.
        let stderr = fern::Output::call(|record| {
            let mark = match record.level() {
                log::Level::Error => "error: ",
                log::Level::Warn => "warning: ",
                _ => "",
            };
            let _ = writeln!(std::io::stderr(), "{mark}{}", record.args());
        });
        let stderr = fern::Dispatch::new().level(level).filter(|metadata| metadata.target() != FILE_ONLY).chain(stderr);
        let mut log = fern::Dispatch::new().chain(stderr);
        if let Some(path) = &self.log {
            let file = fern::log_file(path).map_err(|source| Error::io("open", path, source))?;
            let start = Instant::now();
            let form = move |out: fern::FormatCallback, message: &std::fmt::Arguments, record: &log::Record| {
                out.finish(format_args!("{:10.3} s {:5} {message}", start.elapsed().as_secs_f64(), record.level()));
            };
            log = log.chain(fern::Dispatch::new().level(level.max(LevelFilter::Debug)).format(form).chain(file));
        }
        log.apply().map_err(|error| Error::input("log", error.to_string()))
    }
}

/// Runs a stage; its errors say what the job knows about them.
fn explained(job: Job, stage: impl FnOnce(&Job) -> Result<()>) -> Result<()> {
    stage(&job).map_err(|error| job.explain(error))
}

fn schema() -> Result<()> {
    let schema = serde_json::to_string_pretty(&schemars::schema_for!(Scene)).map_err(|error| Error::input("schema", error.to_string()))?;
    stage::print(&schema)
}
