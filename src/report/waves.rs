//! Waves of a closed curve: how many there are and how high they stand over the plane that fits it best.

use crate::mesh::Region;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The strongest Fourier mode of a closed curve's heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waves {
    /// Number of waves around; 0 for a curve that is flat to rounding.
    pub number: usize,
    /// Amplitude of that mode [m], half of the height from trough to crest.
    pub amplitude: f64,
}

/// Heights below this fraction of the curve's length are rounding.
const FLAT: f64 = 1e-12;

/// The vertices of a region's edges in their order around. Midpoints of curved edges are left out: they may stand off the curve through
/// the vertices by the sag of an edge, as at the rim of a cap, and would be counted as waves.
///
/// # Errors
/// A region whose edges do not form one closed loop of at least three, in words.
pub fn closed_loop(region: &Region) -> Result<Vec<usize>, String> {
    let mut next: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &[a, b] in &region.edges {
        next.entry(a).or_default().push(b);
        next.entry(b).or_default().push(a);
    }
    let Some((&start, _)) = next.first_key_value() else {
        return Err("has no edges, and waves are counted along a closed loop of them".into());
    };
    if let Some((vertex, ends)) = next.iter().find(|(_, ends)| ends.len() != 2) {
        return Err(format!("is not a closed loop: {} of its edges meet at vertex {vertex}", ends.len()));
    }
    let mut around = Vec::new();
    let (mut before, mut at) = (usize::MAX, start);
    loop {
        around.push(at);
        let ends = &next[&at];
        let after = if ends[0] == before { ends[1] } else { ends[0] };
        (before, at) = (at, after);
        if at == start {
            break;
        }
    }
    if around.len() != next.len() {
        return Err("consists of several closed loops; name one of them".into());
    }
    Ok(around)
}

/// Waves of a closed curve through `now` [m], by the arc length of `initial` [m]: the same points in order around, at least three.
///
/// The plane is the one with the least squares of the heights, by arc length. Modes 1 to half the number of points are compared, each
/// by the trapezoidal rule around the curve, which is exact where points are evenly spaced. None if a coordinate is not finite or the
/// initial curve has no length.
pub fn waves(initial: &[Vector3<f64>], now: &[Vector3<f64>]) -> Option<Waves> {
    let n = initial.len().min(now.len());
    if n < 3 || initial.iter().chain(now).flatten().any(|x| !x.is_finite()) {
        return None;
    }
    let lengths: Vec<f64> = (0..n).map(|i| (initial[(i + 1) % n] - initial[i]).norm()).collect();
    let total: f64 = lengths.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let weights: Vec<f64> = (0..n).map(|i| 0.5 * (lengths[(i + n - 1) % n] + lengths[i]) / total).collect();
    let mut places = vec![0.0; n];
    for i in 1..n {
        places[i] = places[i - 1] + lengths[i - 1] / total;
    }
    let heights = heights(&now[..n], &weights);
    let size = heights.iter().fold(0.0, |m: f64, h| m.max(h.abs()));
    if size <= FLAT * total {
        return Some(Waves::default());
    }
    let mut best = Waves::default();
    for number in 1..=n / 2 {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for ((place, weight), height) in places.iter().zip(&weights).zip(&heights) {
            let angle = TAU * number as f64 * place;
            cosine += weight * height * angle.cos();
            sine += weight * height * angle.sin();
        }
        // The highest mode of an even number of points has no sine of its own.
        let factor = if 2 * number == n { 1.0 } else { 2.0 };
        let amplitude = factor * cosine.hypot(sine);
        if amplitude > best.amplitude {
            best = Waves { number, amplitude };
        }
    }
    Some(best)
}

/// Heights over the weighted best plane.
fn heights(points: &[Vector3<f64>], weights: &[f64]) -> Vec<f64> {
    let centre: Vector3<f64> = points.iter().zip(weights).map(|(p, w)| p * *w).sum();
    let size = points.iter().map(|p| (p - centre).amax()).fold(0.0, f64::max);
    if size == 0.0 {
        return vec![0.0; points.len()];
    }
    let spread: Matrix3<f64> = points.iter().zip(weights).map(|(p, w)| (p - centre) * (p - centre).transpose() * (*w / size / size)).sum();
    let eigen = SymmetricEigen::new(spread);
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    points.iter().map(|p| normal.dot(&(p - centre))).collect()
}
