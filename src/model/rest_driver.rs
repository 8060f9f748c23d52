//! How the rest forms change in time.

use crate::shell::rest::{Forms, Impossible, Interpolation, Law, admissible};

/// Share of the law in force at a time.
pub type Ramp = Box<dyn Fn(f64) -> f64>;

/// What materials cannot be at rest. Errors: face and reason.
pub type Limit = Box<dyn Fn(&[Forms]) -> Result<(), String>>;

/// A growth law, its share in time, and the forms it starts from. Evaluates only what changes.
pub struct RestDriver {
    law: Box<dyn Law>,
    law_changes: bool,
    interpolation: Box<dyn Interpolation>,
    ramp: Option<Ramp>,
    initial: Vec<Forms>,
    limit: Option<Limit>,
    /// The law's forms, where they do not change.
    constant: Option<Vec<Forms>>,
}

impl RestDriver {
    /// `law_changes`: whether the law depends on time. `interpolation`: of the element. `ramp`: share of the law in time, none for all of it
    /// at once. `initial`: forms of the initial shape, per integration point.
    pub fn new(
        law: Box<dyn Law>,
        law_changes: bool,
        interpolation: Box<dyn Interpolation>,
        ramp: Option<Ramp>,
        initial: Vec<Forms>,
    ) -> Self {
        RestDriver { law, law_changes, interpolation, ramp, initial, limit: None, constant: None }
    }

    /// From now on forms that the materials cannot have at rest are refused.
    pub fn set_limit(&mut self, limit: Limit) {
        self.limit = Some(limit);
    }

    /// Whether the forms change in time at all.
    pub fn changes(&self) -> bool {
        self.law_changes || self.ramp.is_some()
    }

    /// Rest forms at a time [s]. Errors: the law that is at fault, where and when.
    pub fn forms(&mut self, time: f64) -> Result<Vec<Forms>, Impossible> {
        let forms = self.mixed(time)?;
        self.limit.as_ref().map_or(Ok(()), |limit| limit(&forms)).map_err(|e| format!("{e} (at t = {time})"))?;
        Ok(forms)
    }

    /// The initial forms and those of the law by its share.
    fn mixed(&mut self, time: f64) -> Result<Vec<Forms>, Impossible> {
        let evaluate = || self.interpolation.forms(&*self.law, time);
        let law = if self.law_changes {
            evaluate()?
        } else {
            match &self.constant {
                Some(forms) => forms.clone(),
                None => self.constant.insert(evaluate()?).clone(),
            }
        };
        let Some(ramp) = &self.ramp else { return Ok(law) };
        let share = ramp(time);
        if !share.is_finite() {
            return Err(format!("the ramp is {share} at t = {time}").into());
        }
        let mixed = self.initial.iter().zip(&law).map(|(a, b)| a.mix(b, share)).collect();
        admissible(&*self.interpolation, mixed, time).map_err(|e| format!("{} where the ramp is {share}", e.reason).into())
    }
}
