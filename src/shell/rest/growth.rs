//! Growth that is the same through the thickness: factors on the lengths there are (Chen et al. 2018, section 5.1).

use super::machine_direction::{MachineDirection, stretch, stretched};
use super::{Forms, Impossible, Law, ScalarField, Site};

/// Law `isotropic`: `abar = e^(2s) a0`, `bbar = b0`.
pub struct Isotropic {
    /// Logarithm `s` of the factor on lengths [1].
    pub s: ScalarField,
}

impl Law for Isotropic {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let s = (self.s)(site, time);
        let square = (2.0 * s).exp();
        if !(square.is_finite() && square > 0.0) {
            return Err(format!("s = {s} makes the factor e^(2s) = {square}, which must be positive and finite").into());
        }
        Ok(Forms { a: site.initial.a.map(|a| square * a), b: site.initial.b })
    }
}

/// Law `orthotropic`: lengths along a direction and across it grow by factors of their own, `F = Q diag(f1, f2) Q^-1`,
/// `abar = F^T a0 F`, `bbar = F^T b0 F`: the form that `linear` takes where both faces swell alike.
pub struct Orthotropic {
    /// Factors along the direction and across it [1], > 0.
    pub factors: [ScalarField; 2],
    /// The direction.
    pub direction: MachineDirection,
}

impl Law for Orthotropic {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let factors = self.factors.each_ref().map(|f| f(site, time));
        if let Some(f) = factors.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
            return Err(format!("the growth factor {f} must be positive and finite").into());
        }
        let f = stretch(&site.initial.a, self.direction.at(site, time)?, factors);
        Ok(Forms { a: stretched(&site.initial.a, &f), b: stretched(&site.initial.b, &f) })
    }
}
