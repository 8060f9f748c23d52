//! What is prescribed to every model: loads and supports in time.

use super::step::StepFailure;
use crate::load::Load;
use nalgebra::Vector3;

/// Displacement of a held unknown in time [m, or rad for a director].
pub type Motion = Box<dyn Fn(f64) -> f64>;

/// A held unknown.
pub struct HeldUnknown {
    /// Its number among all unknowns.
    pub unknown: usize,
    /// Its initial value.
    pub start: f64,
    /// Its displacement, if it moves, and the key of that in the scene.
    pub motion: Option<(String, Motion)>,
}

/// A load that is applied.
pub struct AppliedLoad {
    /// Key of its factor in the scene.
    pub key: String,
    /// Its energy's column in the history; none for a load that has no energy.
    pub energy_name: Option<&'static str>,
    /// The load.
    pub potential: Box<dyn Load>,
    /// Factor in time, if that changes.
    pub factor: Option<Motion>,
}

impl HeldUnknown {
    /// Its displacement at a time and the law of that; none if it stays. `describe`: the unknown in words.
    ///
    /// # Errors
    /// [`StepFailure::Input`] where it is not finite.
    pub(super) fn displacement(&self, time: f64, describe: impl Fn(usize) -> String) -> Result<Option<(f64, &Motion)>, StepFailure> {
        let Some((key, motion)) = &self.motion else { return Ok(None) };
        let d = motion(time);
        if d.is_finite() {
            return Ok(Some((d, motion)));
        }
        let reason = format!("the motion of {} is {d} at t = {time}", describe(self.unknown));
        Err(StepFailure::Input { place: key.clone(), reason })
    }
}

/// A coordinate of a node in words. `positions`: initial ones [m].
pub(super) fn coordinate(positions: &[Vector3<f64>], unknown: usize) -> String {
    let p = positions[unknown / 3];
    format!("coordinate {} of node {} at ({:.4e}, {:.4e}, {:.4e}) m", ["x", "y", "z"][unknown % 3], unknown / 3, p.x, p.y, p.z)
}

/// Makes sure that loads are finite at a time.
///
/// # Errors
/// [`StepFailure::Input`] with the key at fault.
pub(super) fn check_loads(loads: &[AppliedLoad], time: f64) -> Result<(), StepFailure> {
    for load in loads {
        let factor = load.factor.as_ref().map_or(1.0, |factor| factor(time));
        if !factor.is_finite() {
            return Err(StepFailure::Input { place: load.key.clone(), reason: format!("is {factor} at t = {time}") });
        }
        if let Some((field, reason)) = load.potential.fault(time, factor) {
            return Err(StepFailure::Input { place: format!("{}{field}", load.key.trim_end_matches("factor")), reason });
        }
    }
    Ok(())
}

/// Sets the loads of a time.
pub(super) fn set_loads(loads: &mut [AppliedLoad], time: f64) {
    for load in loads {
        if let Some(factor) = &load.factor {
            load.potential.set_factor(factor(time));
        }
        load.potential.set_time(time);
    }
}

/// Adds the energies [J] that loads have at coordinates `x` [m] to those of the same columns of the history.
pub(super) fn add_energies(loads: &[AppliedLoad], x: &[f64], energies: &mut Vec<(&'static str, f64)>) {
    for load in loads {
        let Some(name) = load.energy_name else { continue };
        let energy = load.potential.energy(x);
        match energies.iter_mut().find(|(other, _)| *other == name) {
            Some((_, sum)) => *sum += energy,
            None => energies.push((name, energy)),
        }
    }
}
