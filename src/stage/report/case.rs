//! A case that has run, and what of it is judged: states, history, cost.

use super::super::{Job, all, mesh as mesh_stage, run as run_stage, setup};
use super::path::Spot;
use crate::case::{Folder, History, history::Table};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Quality};
use crate::report::Cost;
use crate::scene::Measure;
use crate::snapshot::Snapshot;
use nalgebra::Vector3;

/// A moment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Its end.
    End,
    /// The checkpoint nearest to a time [s].
    Near(f64),
    /// The checkpoint of a step.
    Step(u64),
}

impl From<Option<f64>> for When {
    fn from(time: Option<f64>) -> Self {
        time.map_or(When::End, When::Near)
    }
}

/// A case that has run.
pub struct Case<'a> {
    pub job: &'a Job,
    pub mesh: Mesh,
    pub setup: setup::Setup,
    /// The state before the first step.
    pub start: Snapshot,
    folder: Folder,
    history: Table,
}

impl<'a> Case<'a> {
    pub fn load(job: &'a Job) -> Result<Self> {
        let mesh = mesh_stage::load(job)?;
        let (setup, start) = setup::load(job)?;
        let folder = Folder::new(&job.case, run_stage::inputs(job)?);
        if !run_stage::is_done(job)? {
            return Err(Error::Stale {
                path: job.case.join("run"),
                message: "the run is not at its end".into(),
                help: "finish it: thinshell run SCENE".into(),
            });
        }
        let history = History::read(&run_stage::history_path(job))?;
        Ok(Case { job, mesh, setup, start, folder, history })
    }

    /// What is said of the last equilibrium: that it is unstable, or stable where the scene asks for such. None in dynamics.
    pub fn stability(&self) -> Option<String> {
        self.job.scene.statics.as_ref()?;
        let negative = self.history.last("negative_pivots")?;
        match self.history.last("lowest_eigenvalue") {
            Some(lowest) if negative == 0.0 => Some(format!("The last equilibrium is stable: lowest eigenvalue {lowest:.4e} N/m3")),
            lowest => (negative > 0.0).then(|| format!("Warning: {}", run_stage::unstable(negative as usize, lowest))),
        }
    }

    /// Steps that left an unstable equilibrium, in words.
    pub fn switches(&self) -> Vec<String> {
        let column = |name| self.history.column(name).unwrap_or_default();
        let [times, totals, after, before] = ["time_s", "branch_switches", "lowest_eigenvalue", "lowest_eigenvalue_before"].map(column);
        let earlier = [0.0].into_iter().chain(totals.iter().copied());
        let steps = totals.iter().zip(earlier).enumerate().filter(|(_, (now, earlier))| *now > earlier);
        steps.map(|(i, _)| run_stage::switched(&self.job.moment(times[i]), before[i], after[i])).collect()
    }

    /// What is said of matrices that needed LU, in words; none where there was none.
    pub fn factored_by_lu(&self) -> Option<String> {
        let count = |name: &str| self.history.last(name);
        let (unsymmetric, indefinite) = (count("unsymmetric_matrices")?, count("indefinite_matrices")?);
        (unsymmetric + indefinite > 0.0).then(|| {
            let all = count("factorizations").unwrap_or_default();
            format!(
                "Of {all} matrices {unsymmetric} were not symmetric and {indefinite} symmetric but indefinite; these were factored by LU"
            )
        })
    }

    pub fn cost(&self) -> Result<Cost> {
        Ok(Cost {
            dofs: self.setup.free_unknowns,
            faces: self.mesh.faces.len(),
            wall_s: self.last("wall_s")?,
            newton_iterations: (self.last("newton_iterations")? + self.last("fallback_iterations")?) as u64,
            factorizations: self.last("factorizations")? as u64,
        })
    }

    /// The history.
    pub fn history(&self) -> &Table {
        &self.history
    }

    /// Columns of the history.
    pub fn columns(&self) -> &[String] {
        &self.history.columns
    }

    /// A column of the history, empty if there is none of that name.
    pub fn column(&self, name: &str) -> Vec<f64> {
        self.history.column(name).unwrap_or_default()
    }

    /// Last value of a column of the history.
    pub fn last(&self, column: &str) -> Result<f64> {
        if self.history.rows.is_empty() {
            return Ok(0.0);
        }
        self.history.last(column).ok_or_else(|| {
            Error::input_with_help(
                "report",
                format!("the history has no column '{column}'"),
                format!("it has: {}", self.history.columns.join(", ")),
            )
        })
    }

    /// The value of a column of the history at a step that is told, else the last; 0 before the first step.
    pub fn told(&self, column: &str, when: When) -> Result<f64> {
        let When::Step(step) = when else { return self.last(column) };
        self.last(column)?;
        let row = step.checked_sub(1).and_then(|row| self.history.column(column)?.get(row as usize).copied());
        Ok(row.unwrap_or(0.0))
    }

    /// Steps that have a checkpoint, the way along the path [m] there, or the time where there is none, and the load factor or time.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn steps(&self) -> Result<(Vec<u64>, Vec<f64>, Vec<f64>)> {
        // Those that stay: others are there for a crash, and by chance.
        let steps = Folder::new(&self.job.case, run_stage::inputs(self.job)?).kept()?;
        let of = |name: &str| -> Option<Vec<f64>> {
            let column = self.history.column(name)?;
            Some(
                steps
                    .iter()
                    .map(|step| step.checked_sub(1).map_or(0.0, |row| column.get(row as usize).copied().unwrap_or(f64::NAN)))
                    .collect(),
            )
        };
        let times = of("time_s").unwrap_or_default();
        let ways = of("arc_length_m").unwrap_or_else(|| times.clone());
        Ok((steps, ways, times))
    }

    /// The snapshot of a moment.
    pub fn snapshot(&self, when: When) -> Result<Snapshot> {
        let time = match when {
            When::End => {
                let newest = self.folder.newest_valid()?.snapshot;
                return newest.ok_or_else(|| Error::Stale {
                    path: self.job.case.join("run"),
                    message: "has no checkpoint".into(),
                    help: "make some: thinshell run SCENE".into(),
                });
            }
            When::Step(step) => return self.folder.read(step),
            When::Near(time) => time,
        };
        // By the times of the history, so that no other checkpoint has to be whole, or is read.
        let times = self.history.column("time_s").unwrap_or_default();
        let distance =
            |step: &u64| (step.checked_sub(1).map_or(0.0, |row| times.get(row as usize).copied().unwrap_or(f64::INFINITY)) - time).abs();
        let nearest = self.folder.list()?.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        self.folder.read(nearest.ok_or_else(|| Error::input("report", "there is no checkpoint"))?)
    }

    /// Positions of the nodes [m].
    pub fn positions(&self, when: When) -> Result<Vec<Vector3<f64>>> {
        let snapshot = self.snapshot(when)?;
        let field = snapshot.field("position").filter(|f| f.data.len() == 3 * (self.mesh.vertices.len() + self.mesh.midpoints.len()));
        let field = field.ok_or_else(|| Error::input("checkpoint", "it has no positions of this mesh"))?;
        Ok(field.data.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect())
    }
}

/// A run whose equations could not be solved any more.
pub struct Stopped {
    /// Why.
    pub reason: String,
    /// Its history up to there.
    history: Table,
}

impl Stopped {
    /// What can be said of a measure all the same.
    pub fn measure(&self, measure: &Measure) -> Option<f64> {
        match measure {
            Measure::TimeReached => Some(self.history.last("time_s").unwrap_or(0.0)),
            Measure::TimeWithin { column, least, most } => Some(time_within(&self.history, column, [*least, *most])),
            _ => None,
        }
    }
}

/// Time [s], or load factor, of the last step of a history up to which all values of a column are within bounds; 0 without one.
pub fn time_within(history: &Table, column: &str, [least, most]: [f64; 2]) -> f64 {
    let [values, times] = [column, "time_s"].map(|name| history.column(name).unwrap_or_default());
    let sound = values.iter().take_while(|value| (least..=most).contains(*value)).count();
    sound.checked_sub(1).and_then(|last| times.get(last).copied()).unwrap_or(0.0)
}

/// What a case that was run for a table gave: measures, where it could be run, and its cost.
pub struct Trial {
    /// One per measure, none where it is not finite; or where and why the run stopped.
    pub values: std::result::Result<Vec<Option<f64>>, Stopped>,
    /// Cost; of a run that failed, up to there.
    pub cost: Cost,
    /// Longest edge of the mesh [m].
    pub longest_edge: f64,
}

/// Runs a case and takes measures at their places. Equations that cannot be solved are a result; other errors are errors.
pub fn attempt(job: &Job, measures: &[(&Measure, Spot)]) -> Result<Trial> {
    match all::until_run(job) {
        Ok(()) => {
            let case = Case::load(job)?;
            let values = measures.iter().map(|(m, spot)| Ok(Some(case.measure_at(m, *spot)?).filter(|v| v.is_finite())));
            Ok(Trial {
                values: Ok(values.collect::<Result<_>>()?),
                cost: case.cost()?,
                longest_edge: Quality::of(&case.mesh).edge_length[2],
            })
        }
        Err(Error::Numerical { message, .. }) => {
            let mesh = mesh_stage::load(job)?;
            let path = run_stage::history_path(job);
            let history = if path.exists() { History::read(&path)? } else { Table::default() };
            let last = |column: &str| history.last(column).unwrap_or(0.0);
            let cost = Cost {
                faces: mesh.faces.len(),
                dofs: setup::load(job)?.0.free_unknowns,
                wall_s: last("wall_s"),
                newton_iterations: (last("newton_iterations") + last("fallback_iterations")) as u64,
                factorizations: last("factorizations") as u64,
            };
            Ok(Trial { values: Err(Stopped { reason: message, history }), cost, longest_edge: Quality::of(&mesh).edge_length[2] })
        }
        Err(e) => Err(e),
    }
}
