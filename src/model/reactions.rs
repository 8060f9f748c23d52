//! What supports exert on a shell: the total gradient at held unknowns, inertia and damping included.

use super::ShellModel;
use super::shell_model::{Parts, potentials};
use crate::error::Result;
use crate::snapshot::{Association, Field, Snapshot};
use crate::solve::Newton;
use crate::sparse::{Numbering, Pattern, System};

/// Reactions of the last step, and what finds them.
pub(super) struct Reactions {
    /// With no unknown held.
    numbering: Numbering,
    pattern: Pattern,
    /// Over all unknowns: force [N] on each held coordinate, moment [N m] on each held angle; 0 for the free.
    values: Vec<f64>,
    /// The time [s] that they are of.
    pub(super) time: f64,
}

/// Names of the fields that keep them.
const FORCE: &str = "reaction";
const MOMENT: &str = "reaction_moment";

/// The number of a checkpoint that says of what time [s] they are, where that is not its own.
pub(super) const REACTION_TIME: &str = "reaction_time";

impl Reactions {
    /// Finds those of the state that the potentials are in, at `time` [s]. The potentials are bound to all unknowns for that, and back again.
    pub(super) fn update(&mut self, parts: &mut Parts, newton: &Newton, x: &[f64], time: f64) {
        let mut system = System::new(&self.pattern);
        let held: Vec<usize> = parts.held.iter().map(|h| h.unknown).collect();
        let mut list = potentials(parts);
        list.iter_mut().for_each(|p| p.bind(&self.numbering, &self.pattern));
        list.iter().for_each(|p| {
            p.gradient(x, &mut system);
        });
        newton.bind(&mut list);
        self.time = time;
        self.values.fill(0.0);
        held.into_iter().for_each(|unknown| self.values[unknown] = system.gradient[unknown]);
    }

    /// The fields of a checkpoint; the first `lengths` unknowns are coordinates.
    pub(super) fn fields(&self, lengths: usize) -> Vec<Field> {
        let field = |name: &str, association, components, unit: &str, data: &[f64]| Field {
            name: name.into(),
            association,
            components,
            unit: unit.into(),
            data: data.to_vec(),
        };
        let (forces, moments) = self.values.split_at(lengths);
        let mut fields = vec![field(FORCE, Association::Node, 3, "N", forces)];
        if !moments.is_empty() {
            fields.push(field(MOMENT, Association::Director, 1, "N m", moments));
        }
        fields
    }

    /// Takes them back from a checkpoint. Error: fields that are missing or of another size.
    pub(super) fn take(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        let found = [FORCE, MOMENT].iter().filter_map(|name| snapshot.field(name));
        let values: Vec<f64> = found.flat_map(|field| field.data.iter().copied()).collect();
        if values.len() != self.values.len() {
            return Err(format!("its reactions have {} numbers instead of {}", values.len(), self.values.len()));
        }
        self.values = values;
        self.time = snapshot.number(REACTION_TIME).unwrap_or(snapshot.time);
        Ok(())
    }
}

impl ShellModel {
    /// From now on reactions are found after each step, and checkpoints keep them: fields `reaction` [N] of the nodes, and `reaction_moment`
    /// [N m] of the directors, about the edge from its lower vertex to its higher.
    ///
    /// # Errors
    /// Too many unknowns.
    pub fn keep_reactions(&mut self) -> Result<()> {
        let numbering = Numbering::new(&vec![false; self.x.len()]);
        let list = potentials(&mut self.parts);
        let pattern = Pattern::new(&numbering, &mut |visit| list.iter().for_each(|p| p.stencils(visit)))?;
        drop(list);
        self.reactions = Some(Reactions { values: vec![0.0; self.x.len()], time: self.time, numbering, pattern });
        Ok(())
    }
}
