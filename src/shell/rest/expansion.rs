//! Expansion by a quantity that varies through the thickness: moisture or heat that diffuses (Chen et al. 2018, section 3).
//!
//! Each height `z` (from the middle, along the normal) would have the metric `gbar(z) = F^T (a0 - 2 z b0) F`, with `F` the stretch by
//! `1 + u(z) mu` along and `1 + u(z) mu_perp` across the fibres. The forms are those of the linear metric of least distance,
//! `abar = 1/h int gbar dz`, `bbar = -6/h^3 int z gbar dz`, or, where layers have moduli of their own, of least energy. With `u` linear between
//! its levels the integrals are exact. How `u` came about is not known here.

use super::super::layered::{Bilayer, Layer, LayerMetric, rest_forms};
use super::machine_direction::{MachineDirection, axes};
use super::{Forms, Impossible, Law, Site};
use crate::math::quadrature::GAUSS;
use nalgebra::Matrix2;

/// Value of a quantity at a site, on one of its levels.
pub type LevelField = Box<dyn Fn(&Site, usize) -> f64>;

/// Law `linear`, `bilayer` or `thermal` by all of a quantity's profile.
pub struct Expansion {
    /// Name of the quantity and its unit, for errors.
    pub quantity: [&'static str; 2],
    /// Heights at which it is known, as fractions of the thickness from 0 at the bottom to 1 at the top; it is linear in between.
    pub levels: Vec<f64>,
    /// Its values there.
    pub value: LevelField,
    /// Relative change of length per unit of it in the top and the bottom layer, along the fibres if there are any. Equal: no layers.
    pub mu: [f64; 2],
    /// With a machine direction: the changes across the fibres, and the direction.
    pub fibres: Option<([f64; 2], MachineDirection)>,
    /// The layers of each face, or of none at all, where they have thicknesses and moduli of their own; else the layers are two equal halves.
    pub layers: Vec<Option<Bilayer>>,
}

/// `int (f_i f_j - 1) z^p dz` for `ij` = 11, 12, 22 and `p` = 0, 1, 2, with `f` the stretches along and across. Without the 1, so that what does not
/// swell keeps its forms to the last digit.
#[derive(Clone, Copy, Default)]
struct Moments([[f64; 3]; 3]);

impl Moments {
    /// Adds the part between two heights [m], over which the changes of length `e = f - 1` are linear.
    fn add(&mut self, z: [f64; 2], e: [[f64; 2]; 2]) {
        for (s, weight) in GAUSS {
            let at = |pair: [f64; 2]| (1.0 - s) * pair[0] + s * pair[1];
            let (height, along, across) = (at(z), at([e[0][0], e[1][0]]), at([e[0][1], e[1][1]]));
            let mut factor = weight * (z[1] - z[0]);
            for p in 0..3 {
                for (sum, (e, f)) in self.0.iter_mut().zip([(along, along), (along, across), (across, across)]) {
                    sum[p] += factor * (e + f + e * f);
                }
                factor *= height;
            }
        }
    }

    /// `int (gbar - g0) dz` and `int z (gbar - g0) dz`, `g0 = a0 - 2 z b0`, in the frame where `a0` is the identity and `b0` is `b`.
    fn of_metric(&self, b: [f64; 3]) -> [[f64; 3]; 2] {
        [0, 1].map(|p| std::array::from_fn(|c| [1.0, 0.0, 1.0][c] * self.0[c][p] - 2.0 * b[c] * self.0[c][p + 1]))
    }
}

impl Expansion {
    /// Relative changes of length along and across for a value of the quantity, in the top (0) or the bottom (1) layer.
    fn changes(&self, u: f64, layer: usize) -> Result<[f64; 2], String> {
        let across = self.fibres.as_ref().map_or(self.mu, |(across, _)| *across);
        let changes = [self.mu, across].map(|mu| u * mu[layer]);
        match changes.iter().find(|e| !(e.is_finite() && **e > -1.0)) {
            Some(e) => {
                let ([name, unit], factor) = (self.quantity, 1.0 + e);
                Err(format!("a {name} of {u} {unit} changes lengths by the factor 1 + u mu = {factor}, which must be > 0"))
            }
            None => Ok(changes),
        }
    }

    /// Moments of the top and the bottom layer, which meet at the height `interface` [m].
    fn moments(&self, site: &Site, interface: f64) -> Result<[Moments; 2], String> {
        let mut moments = [Moments::default(); 2];
        let height = |level: usize| (self.levels[level] - 0.5) * site.thickness;
        let mut low = (height(0), (self.value)(site, 0));
        for level in 1..self.levels.len() {
            let high = (height(level), (self.value)(site, level));
            let at = |z: f64| low.1 + (high.1 - low.1) * ((z - low.0) / (high.0 - low.0));
            let mut add = |layer: usize, from: f64, to: f64| -> Result<(), String> {
                if to > from {
                    moments[layer].add([from, to], [self.changes(at(from), layer)?, self.changes(at(to), layer)?]);
                }
                Ok(())
            };
            add(1, low.0, high.0.min(interface))?;
            add(0, low.0.max(interface), high.0)?;
            low = high;
        }
        Ok(moments)
    }
}

impl Law for Expansion {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let (start, h) = (&site.initial, site.thickness);
        let direction = self.fibres.as_ref().map_or(Ok([1.0, 0.0]), |(_, direction)| direction.at(site, time))?;
        let q = axes(&start.a, direction);
        let matrix = |m: [f64; 3]| Matrix2::new(m[0], m[1], m[1], m[2]);
        let b0 = q.transpose() * matrix(start.b) * q;
        let b0 = [b0[(0, 0)], b0[(0, 1)], b0[(1, 1)]];
        let own = self.layers.get(site.face).copied().flatten().map(|layers| layers.layers(h));
        let interface = own.map_or(0.0, |[top, _]| 0.5 * h - top.thickness);
        let moments = self.moments(site, interface)?.map(|moments| moments.of_metric(b0));
        // Forms depend on the metrics of the layers linearly, and those of the start have the forms of the start.
        let forms = match own {
            Some(layers) => rest_forms(&layers, &[0, 1].map(|k| layer_metric(&layers, k, &moments[k])), [1.0, 0.0, 1.0]),
            None => {
                let sum = |p: usize, c: usize| moments[0][p][c] + moments[1][p][c];
                Forms { a: std::array::from_fn(|c| sum(0, c) / h), b: std::array::from_fn(|c| -6.0 / h.powi(3) * sum(1, c)) }
            }
        };
        // Columns of Q are orthonormal in a0, so Q^-1 = Q^T a0.
        let inverse = q.transpose() * matrix(start.a);
        let back = |m: [f64; 3]| {
            let m = inverse.transpose() * matrix(m) * inverse;
            [m[(0, 0)], 0.5 * (m[(0, 1)] + m[(1, 0)]), m[(1, 1)]]
        };
        let (a, b) = (back(forms.a), back(forms.b));
        Ok(Forms { a: std::array::from_fn(|c| start.a[c] + a[c]), b: std::array::from_fn(|c| start.b[c] + b[c]) })
    }
}

/// The linear change of metric nearest to that of a layer, from its moments.
fn layer_metric(layers: &[Layer; 2], layer: usize, [whole, first]: &[[f64; 3]; 2]) -> LayerMetric {
    let thickness = layers[layer].thickness;
    let middle = [0.5 * layers[1].thickness, -0.5 * layers[0].thickness][layer];
    LayerMetric {
        middle: whole.map(|m| m / thickness),
        slope: std::array::from_fn(|c| 12.0 / thickness.powi(3) * (first[c] - middle * whole[c])),
    }
}
