//! Swelling that differs between the top and the bottom of the shell (Chen et al. 2018, section 3).

use super::super::layered::{Bilayer, LayerMetric, rest_forms};
use super::machine_direction::{MachineDirection, stretch, stretched};
use super::{Forms, Impossible, Law, ScalarField, Site};
use nalgebra::Matrix2;

/// How swelling is distributed over the thickness.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// It changes linearly from bottom to top.
    Linear,
    /// Two layers, each swelling as a whole. Of each face, or of none at all: its layers where they have thicknesses and moduli of their
    /// own; the others are two equal halves.
    Bilayer(Vec<Option<Bilayer>>),
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
    /// Whether the moisture is prescribed, and so refused where it is drier than bone dry. What diffuses answers for itself.
    pub prescribed: bool,
}

/// Moisture of what has given off all its water [%].
const BONE_DRY: f64 = -100.0;

/// Names of the sides in errors.
const SIDES: [&str; 2] = ["m_plus", "m_minus"];

impl Swelling {
    /// Stretch of tangent vectors at the two sides, in barycentric components.
    fn stretches(&self, site: &Site, time: f64) -> Result<[Matrix2<f64>; 2], String> {
        let direction = self.fibres.as_ref().map(|(_, direction)| direction.at(site, time)).transpose()?;
        let mut sides = [Matrix2::identity(); 2];
        for (side, f) in sides.iter_mut().enumerate() {
            let m = (self.moisture[side])(site, time);
            // Expressions reach the limit with some round-off.
            if self.prescribed && m < BONE_DRY * (1.0 + 1e-9) {
                return Err(format!("{} = {m} %, but {BONE_DRY} % is bone dry already", SIDES[side]));
            }
            let factor = |mu: f64| {
                let s = 1.0 + m * mu;
                if s > 0.0 && s.is_finite() {
                    Ok(s)
                } else {
                    Err(format!("{} = {m} % makes 1 + m mu = {s}, which must be > 0", SIDES[side]))
                }
            };
            let along = factor(self.mu[side])?;
            *f = match (&self.fibres, direction) {
                (Some((across, _)), Some(d)) => stretch(&site.initial.a, d, [along, factor(across[side])?]),
                _ => *f * along,
            };
        }
        Ok(sides)
    }
}

/// Forms of sides that swell as `sides` say: metrics `F^T (a0 -+ z b0) F`, of which `abar` is the mean, and `bbar` is `slope` times the
/// difference of the bottom and the top.
fn alike(start: &Forms, sides: &[Matrix2<f64>; 2], z: f64, slope: f64) -> Forms {
    let metric = |z: f64| std::array::from_fn(|i| start.a[i] - z * start.b[i]);
    let (top, bottom) = (stretched(&metric(z), &sides[0]), stretched(&metric(-z), &sides[1]));
    Forms { a: std::array::from_fn(|i| 0.5 * (top[i] + bottom[i])), b: std::array::from_fn(|i| slope * (bottom[i] - top[i])) }
}

/// Forms of least energy of layers that would have the metrics `F^T (a0 - 2 z b0) F` by themselves, `z` counting from the middle of the shell.
fn layered(start: &Forms, sides: &[Matrix2<f64>; 2], layers: &Bilayer, thickness: f64) -> Forms {
    let layers = layers.layers(thickness);
    let middles = [0.5 * layers[1].thickness, -0.5 * layers[0].thickness];
    let own = std::array::from_fn(|k| LayerMetric {
        middle: stretched(&std::array::from_fn(|i| start.a[i] - 2.0 * middles[k] * start.b[i]), &sides[k]),
        slope: stretched(&start.b.map(|b| -2.0 * b), &sides[k]),
    });
    rest_forms(&layers, &own, start.a)
}

impl Law for Swelling {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let (start, h, sides) = (&site.initial, site.thickness, self.stretches(site, time)?);
        Ok(match &self.profile {
            Profile::Linear => alike(start, &sides, h, 0.5 / h),
            Profile::Bilayer(layers) => match layers.get(site.face).copied().flatten() {
                Some(layers) => layered(start, &sides, &layers, h),
                // Of a metric that jumps in the middle: half the sum, and the slope that fits best.
                None => alike(start, &sides, 2.0 / 3.0 * h, 0.75 / h),
            },
        })
    }
}
