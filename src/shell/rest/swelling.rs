//! Swelling that differs between the top and the bottom of the shell (seed A, section 3; PHYSICS A3, `linear`, `bilayer`, `machine-direction`).

use super::machine_direction::{MachineDirection, stretch, stretched};
use super::{Forms, Law, ScalarField, Site};

/// How swelling is distributed over the thickness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// It changes linearly from bottom to top.
    Linear,
    /// Two layers of equal thickness, each swelling as a whole.
    Bilayer,
}

/// Laws `linear` and `bilayer`, with or without a machine direction.
pub struct Swelling {
    /// Distribution over the thickness.
    pub profile: Profile,
    /// Additional moisture at the top and the bottom (of the two layers) [%].
    pub moisture: [ScalarField; 2],
    /// Relative change of length per percent of the top and the bottom, along the fibres if there are any.
    pub mu: [f64; 2],
    /// With a machine direction: the changes across the fibres, and the direction.
    pub fibres: Option<([f64; 2], MachineDirection)>,
}

/// Names of the sides in errors.
const SIDES: [&str; 2] = ["m_plus", "m_minus"];

impl Swelling {
    /// Metrics of the two sides: `(1 + m mu)^2 (a0 -+ z b0)`, `z` being twice their distance from the middle [m].
    fn sides(&self, site: &Site, time: f64, z: f64) -> Result<[[f64; 3]; 2], String> {
        let direction = self.fibres.as_ref().map(|(_, direction)| direction.at(site, time)).transpose()?;
        let mut sides = [[0.0; 3]; 2];
        for (side, metric) in sides.iter_mut().enumerate() {
            let m = (self.moisture[side])(site, time);
            let factor = |mu: f64| {
                let s = 1.0 + m * mu;
                if s > 0.0 && s.is_finite() {
                    Ok(s)
                } else {
                    Err(format!("{} = {m} % makes 1 + m mu = {s}, which must be > 0", SIDES[side]))
                }
            };
            let sign = [1.0, -1.0][side];
            let start: [f64; 3] = std::array::from_fn(|i| site.initial.a[i] - sign * z * site.initial.b[i]);
            let along = factor(self.mu[side])?;
            *metric = match (&self.fibres, direction) {
                (Some((across, _)), Some(d)) => stretched(&start, &stretch(&site.initial.a, d, [along, factor(across[side])?])),
                _ => start.map(|v| along * along * v),
            };
        }
        Ok(sides)
    }
}

impl Law for Swelling {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, String> {
        let h = site.thickness;
        // Of a metric that is linear in z, and of one that jumps in the middle: half the sum, and the slope that fits best.
        let (z, slope) = match self.profile {
            Profile::Linear => (h, 0.5 / h),
            Profile::Bilayer => (2.0 / 3.0 * h, 0.75 / h),
        };
        let [top, bottom] = self.sides(site, time, z)?;
        Ok(Forms { a: std::array::from_fn(|i| 0.5 * (top[i] + bottom[i])), b: std::array::from_fn(|i| slope * (bottom[i] - top[i])) })
    }
}
