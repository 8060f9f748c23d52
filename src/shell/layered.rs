//! Two layers through the thickness, each isotropic St. Venant-Kirchhoff in plane stress (classical lamination theory).
//!
//! The reference surface is the middle of the whole shell, `z` counts from it along the normal, and the top layer is that at positive `z`.
//! With `E(z) = (a - abar)/2 - z (b - bbar)` the energy `1/2 int E:Q:E dz` couples membrane and bending where the layers differ. Materials
//! that vary within a layer are not here.

use super::material::{Stiffness, lame, norm_matrix};
use super::rest::Forms;

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Thickness [m].
    pub thickness: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
}

/// Two layers: the top one and the bottom one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bilayer {
    /// Thickness of the top layer [m]; the rest of the shell's is the bottom layer.
    pub top_thickness: f64,
    /// Young's moduli [Pa]: top, bottom.
    pub youngs_moduli: [f64; 2],
    /// Poisson's ratios: top, bottom.
    pub poissons_ratios: [f64; 2],
}

impl Bilayer {
    /// The layers of a shell of this thickness [m]: top, bottom.
    pub fn layers(&self, thickness: f64) -> [Layer; 2] {
        let parts = [self.top_thickness, thickness - self.top_thickness];
        std::array::from_fn(|k| Layer {
            thickness: parts[k],
            youngs_modulus: self.youngs_moduli[k],
            poissons_ratio: self.poissons_ratios[k],
        })
    }

    /// Young's modulus [Pa] and Poisson's ratio, means over the thickness [m].
    pub fn means(&self, thickness: f64) -> [f64; 2] {
        let share = self.top_thickness / thickness;
        [self.youngs_moduli, self.poissons_ratios].map(|[top, bottom]| share * top + (1.0 - share) * bottom)
    }
}

/// `int dz`, `int z dz`, `int z^2 dz` over each of two layers.
fn moments(top: f64, bottom: f64) -> [[f64; 3]; 2] {
    // The layers meet at (bottom - top) / 2, and their middles lie half the other's thickness off the shell's.
    [(top, 0.5 * bottom), (bottom, -0.5 * top)].map(|(t, middle)| [t, t * middle, t * (middle * middle + t * t / 12.0)])
}

/// Second derivatives of `weight sqrt(det abar) 1/2 int E:Q:E dz` in the changes of the forms: `A/4`, `-B/2`, `D`.
pub(super) fn stiffness(material: &Bilayer, thickness: f64, abar: [f64; 3], weight: f64) -> Stiffness {
    let layers = material.layers(thickness);
    let mut sums = [[0.0; 6]; 3];
    for (layer, moments) in layers.iter().zip(moments(layers[0].thickness, layers[1].thickness)) {
        let c = norm_matrix(abar, lame(layer.youngs_modulus, layer.poissons_ratio), weight);
        for ((sum, factor), moment) in sums.iter_mut().zip([0.25, -0.5, 1.0]).zip(moments) {
            sum.iter_mut().zip(&c).for_each(|(s, c)| *s += factor * moment * c);
        }
    }
    sums
}

/// Metric that a layer would have by itself: `middle + (z - z_k) slope`, `z_k` the middle of the layer; by components 11, 12, 22.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerMetric {
    /// At the middle of the layer [m2].
    pub middle: [f64; 3],
    /// Derivative along the normal [m].
    pub slope: [f64; 3],
}

/// Forms of least energy for layers (top, bottom) that would have the metrics `own` (top, bottom) each by itself, of a shell that may take any
/// forms. `a0`: the initial metric [m2], in which strains are measured.
///
/// Trace and deviator in `a0` separate, each with two equations for its parts of `abar` and `bbar`. Layers of equal moduli and
/// thickness, without slopes: `abar = (g+ + g-)/2`, `bbar = 3/(4h) (g- - g+)`.
pub fn rest_forms(layers: &[Layer; 2], own: &[LayerMetric; 2], a0: [f64; 3]) -> Forms {
    let det = a0[0] * a0[2] - a0[1] * a0[1];
    let trace = |m: &[f64; 3]| (a0[2] * m[0] - 2.0 * a0[1] * m[1] + a0[0] * m[2]) / det;
    let spherical = |m: &[f64; 3]| a0.map(|a| 0.5 * trace(m) * a);
    let moments = moments(layers[0].thickness, layers[1].thickness);
    let mut forms = Forms::default();
    for deviator in [false, true] {
        let part = |m: &[f64; 3]| {
            let s = spherical(m);
            if deviator { std::array::from_fn(|i| m[i] - s[i]) } else { s }
        };
        // Sums over the layers of c int dz, c int z dz, c int z^2 dz, and of c int gbar dz, c int z gbar dz.
        let (mut left, mut right) = ([0.0; 3], [[0.0; 3]; 2]);
        for k in 0..2 {
            let [alpha, beta] = lame(layers[k].youngs_modulus, layers[k].poissons_ratio);
            let c = if deviator { 2.0 * beta } else { alpha + beta };
            let (middle, slope): ([f64; 3], [f64; 3]) = (part(&own[k].middle), part(&own[k].slope));
            let [length, first, _] = moments[k];
            let inertia = length * length * length / 12.0;
            for i in 0..3 {
                left[i] += c * moments[k][i];
                right[0][i] += c * length * middle[i];
                right[1][i] += c * (first * middle[i] + inertia * slope[i]);
            }
        }
        // int Q (a - 2 z b - gbar) dz = 0 and int z Q (a - 2 z b - gbar) dz = 0.
        let [a, b, d] = left;
        let determinant = a * d - b * b;
        for i in 0..3 {
            forms.a[i] += (d * right[0][i] - b * right[1][i]) / determinant;
            forms.b[i] += 0.5 * (b * right[0][i] - a * right[1][i]) / determinant;
        }
    }
    forms
}
