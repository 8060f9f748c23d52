//! How far shapes of one body on several meshes are from each other, and a shape from its mirror image.

use nalgebra::Vector3;
use std::collections::{HashMap, HashSet};

/// The nodes of a mesh at the start and later [m].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Where they were at the start.
    pub places: Vec<Vector3<f64>>,
    /// Where they are.
    pub positions: Vec<Vector3<f64>>,
}

/// Cells of space far larger than round-off and far smaller than any edge: the same place is in the same cell.
struct Cells {
    /// Length of their edges [m].
    edge: f64,
}

impl Cells {
    /// Cells for the places of a mesh [m].
    fn new(places: &[Vector3<f64>]) -> Self {
        let all = |of: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| places.iter().copied().reduce(|a, b| of(&a, &b));
        let size = all(|a, b| a.sup(b)).zip(all(|a, b| a.inf(b))).map_or(0.0, |(high, low)| (high - low).norm());
        Cells { edge: 1e-6 * size }
    }

    /// That of a place. Borders are where no round number is, so round-off does not put one place into two cells.
    fn of(&self, place: &Vector3<f64>) -> [i64; 3] {
        <[f64; 3]>::from(*place).map(|x| (x / self.edge + std::f64::consts::FRAC_1_PI).floor() as i64)
    }

    /// Which node is where.
    fn nodes(&self, shape: &Shape) -> HashMap<[i64; 3], usize> {
        shape.places.iter().enumerate().map(|(n, place)| (self.of(place), n)).collect()
    }
}

/// Largest distance [m] of a node from the mirror image of that which was at the start in the mirror image of its place; NaN where a node has no such
/// partner. The mirror is the plane at `at` [m] across an axis, by its number.
pub fn asymmetry(shape: &Shape, axis: usize, at: f64) -> f64 {
    let cells = Cells::new(&shape.places);
    let nodes = cells.nodes(shape);
    let image = |mut p: Vector3<f64>| {
        p[axis] = 2.0 * at - p[axis];
        p
    };
    let partner = |place: &Vector3<f64>| nodes.get(&cells.of(&image(*place)));
    let distance =
        |(place, p): (&Vector3<f64>, &Vector3<f64>)| partner(place).map_or(f64::NAN, |n| (image(shape.positions[*n]) - p).norm());
    let distances = shape.places.iter().zip(&shape.positions).map(distance);
    distances.fold(0.0, |m, d| if d.is_nan() || m.is_nan() { f64::NAN } else { d.max(m) })
}

/// Names of the two distances.
pub const SHAPE_DISTANCES: [&str; 2] =
    ["distance from the shape before, root mean square [m]", "distance from the shape before, largest [m]"];

/// Root mean square and largest distance [m] of each shape from that `apart` shapes before it, over the nodes that all shapes have in the same
/// initial places, so that all distances are of the same points. None where there is no shape before, where one of both is missing, and without such nodes.
pub fn shape_distances(shapes: &[Option<Shape>], apart: usize) -> Vec<[Option<f64>; 2]> {
    let cells = Cells::new(shapes.iter().flatten().next().map_or(&[], |first| &first.places));
    let nodes: Vec<Option<HashMap<[i64; 3], usize>>> = shapes.iter().map(|shape| shape.as_ref().map(|shape| cells.nodes(shape))).collect();
    let sets = nodes.iter().flatten().map(|nodes| nodes.keys().copied().collect::<HashSet<_>>());
    let mut common: Vec<[i64; 3]> = sets.reduce(|a, b| &a & &b).unwrap_or_default().into_iter().collect();
    // In one order, so that sums are the same bits in every run.
    common.sort_unstable();
    let at = |run: usize, cell: &[i64; 3]| Some(shapes[run].as_ref()?.positions[*nodes[run].as_ref()?.get(cell)?]);
    let of = |run: usize| {
        let Some(before) = run.checked_sub(apart) else { return [None; 2] };
        let squares: Option<Vec<f64>> = common.iter().map(|cell| Some((at(run, cell)? - at(before, cell)?).norm_squared())).collect();
        let Some(squares) = squares.filter(|squares| !squares.is_empty()) else { return [None; 2] };
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        [mean.sqrt(), squares.iter().copied().fold(0.0, f64::max).sqrt()].map(|d| Some(d).filter(|d| d.is_finite()))
    };
    (0..shapes.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of `n` cells, lifted by `height` at its end and by the square of the way there before.
    fn strip(n: usize, height: f64) -> Shape {
        let places: Vec<_> = (0..=n).map(|i| Vector3::new(0.6 * i as f64 / n as f64, 0.0, 0.0)).collect();
        let positions = places.iter().map(|p| p + Vector3::z() * (height * (p.x / 0.6) * (p.x / 0.6))).collect();
        Shape { places, positions }
    }

    #[test]
    fn shapes_are_compared_where_all_have_nodes() {
        // Of 4, 6 and 10 cells the ends and the middle are common.
        let shapes = [strip(4, 0.1), strip(6, 0.3), strip(10, 0.7)].map(Some);
        let found = shape_distances(&shapes, 1);
        assert_eq!(found[0], [None; 2]);
        for (found, height) in found[1..].iter().zip([0.2, 0.4]) {
            let rms = height * ((1.0 + 1.0 / 16.0) / 3.0f64).sqrt();
            let [a, b] = found.map(Option::unwrap);
            assert!((a - rms).abs() < 1e-12 && (b - height).abs() < 1e-12, "{found:?}");
        }
        let found = shape_distances(&shapes, 2);
        assert!(found[1] == [None; 2] && (found[2][1].unwrap() - 0.6).abs() < 1e-12, "{found:?}");
        // Runs that failed have no shape, and none is compared with them.
        assert_eq!(shape_distances(&[Some(strip(4, 0.1)), None, Some(strip(4, 0.2))], 1), [[None; 2]; 3]);
        let elsewhere = Shape { places: strip(4, 0.1).places.iter().map(|p| p + Vector3::y()).collect(), ..strip(4, 0.1) };
        assert_eq!(shape_distances(&[Some(strip(4, 0.1)), Some(elsewhere)], 1), [[None; 2]; 2]);
    }

    #[test]
    fn asymmetry_is_that_of_places_and_their_partners() {
        // About its middle the square of the way differs most between the ends.
        let whole = strip(6, 0.3);
        assert!((asymmetry(&whole, 0, 0.3) - 0.3).abs() < 1e-12);
        assert!(asymmetry(&whole, 0, 0.2).is_nan());
        // In the plane of a mirror a node is its own partner, and off it by twice its height.
        assert_eq!(asymmetry(&whole, 1, 0.0), 0.0);
        assert!((asymmetry(&whole, 2, 0.0) - 0.6).abs() < 1e-12);
        let even = Shape { positions: whole.places.iter().map(|p| p + Vector3::z() * (p.x - 0.3).powi(2)).collect(), ..whole };
        assert!(asymmetry(&even, 0, 0.3) < 1e-15);
    }
}
