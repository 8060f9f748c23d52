//! Surfaces of curved faces: the Hausdorff distance between two, and how far a shape is from the one it should have.
//!
//! Where a face is curved, so is it here: a point's distance is that from the quadratic face itself, not from a flat piece of it. What is
//! left of the sampling is that the largest distance is looked for at many points, not everywhere. No rest shape and no element is known.

use super::distance::Tree;
use crate::math::quadrature::{quadratic_shape, quadratic_slopes};
use crate::math::rigid_fit;
use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A surface of quadratic triangles.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Nodes [m].
    nodes: Vec<Vector3<f64>>,
    /// Corners 0, 1, 2, then the midpoints of the edges opposite them.
    faces: Vec<[usize; 6]>,
}

/// Faces that a surface should have at least, and pieces along each edge of a mesh's face that make them: so many that a smooth surface is
/// met to the third order of a length well below the mesh's.
const ENOUGH: f64 = 8000.0;
const PIECES: [usize; 2] = [3, 8];

/// Corners of the reference triangle.
const CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

impl Surface {
    /// The image of the surface that a mesh's nodes at `nodes` [m] span: each face is cut into smaller ones, whose nodes are mapped.
    ///
    /// `nodes`: in the order of [`Mesh::nodes`], as many as those; faces are curved where the mesh has midpoints. With the identity for
    /// `map` it is that surface; with another map the image up to an error of third order in the size of the pieces.
    pub fn new(mesh: &Mesh, nodes: &[Vector3<f64>], map: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Self {
        let topology = Topology::new(&mesh.faces);
        let pieces = (ENOUGH / mesh.faces.len().max(1) as f64).sqrt().ceil().clamp(PIECES[0] as f64, PIECES[1] as f64) as usize;
        let (places, patches) = lattice(pieces);
        let (mut surface, vertices) = (Surface::default(), mesh.vertices.len());
        for (face, edges) in mesh.faces.iter().zip(&topology.face_edges) {
            let corners = face.map(|v| nodes[v]);
            let middle = |i: usize| match nodes.get(vertices + edges[i]) {
                Some(middle) => *middle,
                None => 0.5 * (corners[(i + 1) % 3] + corners[(i + 2) % 3]),
            };
            let patch = [corners[0], corners[1], corners[2], middle(0), middle(1), middle(2)];
            let first = surface.nodes.len();
            surface.nodes.extend(places.iter().map(|place| map(combine(&patch, &quadratic_shape(*place)))));
            surface.faces.extend(patches.iter().map(|p| p.map(|node| first + node)));
        }
        surface
    }

    /// Whether all nodes are finite.
    pub fn is_finite(&self) -> bool {
        self.nodes.iter().flatten().all(|x| x.is_finite())
    }

    /// Hausdorff distance [m]: the largest distance of a node of either surface from the other surface. NaN if a node is not finite,
    /// infinite if one of them has no faces.
    pub fn hausdorff(&self, other: &Surface) -> f64 {
        if !(self.is_finite() && other.is_finite()) {
            return f64::NAN;
        }
        self.farthest(&other.nodes).max(other.farthest(&self.nodes))
    }

    /// Largest distance [m] of points from the surface. 0 without points; infinite if there are points but no faces. All coordinates
    /// must be finite.
    pub fn farthest(&self, points: &[Vector3<f64>]) -> f64 {
        let faces = self.flat();
        let tree = Tree::new(&self.nodes, &faces);
        let sag = self.sag();
        points.iter().fold(0.0, |farthest: f64, p| farthest.max(self.distance_squared(&tree, sag, p, farthest))).sqrt()
    }

    /// Each face as four flat ones on its nodes.
    fn flat(&self) -> Vec<[usize; 3]> {
        self.faces.iter().flat_map(|&[a, b, c, d, e, f]| [[a, f, e], [f, b, d], [e, d, c], [d, e, f]]).collect()
    }

    /// How far a curved face can lie from the flat ones on its nodes [m]: a quadratic is at most a sixth of its largest second difference
    /// along an edge away from its linear interpolant, and the edges here are half of the face's.
    fn sag(&self) -> f64 {
        let of = |face: &[usize; 6]| {
            let [x0, x1, x2, x3, x4, x5] = face.map(|node| self.nodes[node]);
            [x0 + x1 - x5 * 2.0, x1 + x2 - x3 * 2.0, x2 + x0 - x4 * 2.0].iter().map(|d| 4.0 * d.norm()).fold(0.0, f64::max) / 24.0
        };
        self.faces.iter().map(of).fold(0.0, f64::max)
    }

    /// Square of the distance of a point [m^2]; where that is no more than `enough`, anything up to it: who looks for the largest of many
    /// need not know the others.
    fn distance_squared(&self, tree: &Tree, sag: f64, p: &Vector3<f64>, enough: f64) -> f64 {
        let (first, best) = tree.nearest(p);
        let distance = best.sqrt();
        if (distance + sag).powi(2) <= enough {
            return 0.0;
        }
        let on_curved = |flat: usize| {
            let start = match flat % 4 {
                3 => [1.0 / 3.0; 2],
                corner => CORNERS[corner].map(|c| 1.0 / 6.0 + 0.5 * c),
            };
            patch_distance_squared(p, &self.faces[flat / 4].map(|node| self.nodes[node]), start, enough)
        };
        if best.is_finite() && on_curved(first) <= enough {
            return 0.0;
        }
        // The nearest curved face need not be that of the nearest flat piece.
        let reach = distance + 2.0 * sag;
        let mut nearest = f64::INFINITY;
        for flat in tree.within(p, reach * reach) {
            nearest = nearest.min(on_curved(flat));
            if nearest <= enough {
                break;
            }
        }
        if nearest.is_finite() { nearest } else { best }
    }
}

/// Nodes on the reference triangle of its cut into `pieces` triangles along each edge, and the six nodes of each of these.
fn lattice(pieces: usize) -> (Vec<[f64; 2]>, Vec<[usize; 6]>) {
    let rows = 2 * pieces;
    // Row j, of constant y, has rows + 1 - j nodes.
    let node = |i: usize, j: usize| j * (2 * rows + 3 - j) / 2 + i;
    let place = |(i, j): (usize, usize)| [i as f64 / rows as f64, j as f64 / rows as f64];
    let places = (0..=rows).flat_map(|j| (0..=rows - j).map(move |i| (i, j))).map(place).collect();
    let mut patches = Vec::with_capacity(pieces * pieces);
    for j in (0..rows).step_by(2) {
        for i in (0..rows - j).step_by(2) {
            patches.push([node(i, j), node(i + 2, j), node(i, j + 2), node(i + 1, j + 1), node(i, j + 1), node(i + 1, j)]);
            if i + j + 2 < rows {
                let [a, b, c] = [node(i + 2, j + 2), node(i, j + 2), node(i + 2, j)];
                patches.push([a, b, c, node(i + 1, j + 1), node(i + 2, j + 1), node(i + 1, j + 2)]);
            }
        }
    }
    (places, patches)
}

fn combine(patch: &[Vector3<f64>; 6], factors: &[f64; 6]) -> Vector3<f64> {
    patch.iter().zip(factors).map(|(x, n)| x * *n).sum()
}

/// Square of the distance from a point to a quadratic triangle [m^2], by Newton's method from `start`; never less than the true one. It stops
/// where it is no more than `enough`.
fn patch_distance_squared(p: &Vector3<f64>, patch: &[Vector3<f64>; 6], start: [f64; 2], enough: f64) -> f64 {
    let squared = |place: [f64; 2]| (combine(patch, &quadratic_shape(place)) - p).norm_squared();
    let [x0, x1, x2, x3, x4, x5] = patch;
    let second = [(x0 + x1 - x5 * 2.0) * 4.0, (x0 + x3 - x4 - x5) * 4.0, (x0 + x2 - x4 * 2.0) * 4.0];
    let local = |place: [f64; 2]| {
        let off = combine(patch, &quadratic_shape(place)) - p;
        let r = quadratic_slopes(place).map(|slopes| combine(patch, &slopes));
        let bend = second.map(|s| s.dot(&off));
        (Vector2::new(r[0].dot(&off), r[1].dot(&off)), [r[0].norm_squared(), r[0].dot(&r[1]), r[1].norm_squared()], bend)
    };
    let mut best = (start, squared(start));
    for _ in 0..50 {
        if best.1 <= enough {
            break;
        }
        let (slope, first, bend) = local(best.0);
        let matrix = |share: f64| {
            let [a, b, c] = [0, 1, 2].map(|i| first[i] + share * bend[i]);
            Matrix2::new(a, b, b, c)
        };
        // Where the point is farther than the centre of curvature, the distance is not convex: Gauss and Newton's matrix is.
        let cholesky = matrix(1.0).cholesky().or_else(|| matrix(0.0).cholesky());
        let full = cholesky.map_or(Vector2::zeros(), |c| -c.solve(&slope));
        // At the border the full step may lead nowhere. Where no step along an edge's direction comes nearer either, none does.
        let along = |[a, b]: [usize; 2]| {
            let direction = Vector2::from(CORNERS[b]) - Vector2::from(CORNERS[a]);
            let curvature = |m: Matrix2<f64>| direction.dot(&(m * direction));
            let curvature = Some(curvature(matrix(1.0))).filter(|c| *c > 0.0).unwrap_or_else(|| curvature(matrix(0.0)));
            let corners = [1.0 - best.0[0] - best.0[1], best.0[0], best.0[1]].map(|c| c.max(0.0));
            let step = (-slope.dot(&direction) / curvature).clamp(-corners[b], corners[a]);
            if step.is_finite() { direction * step } else { Vector2::zeros() }
        };
        let steps = [full, along([1, 2]), along([2, 0]), along([0, 1])];
        // Steps are halved until they come nearer; a place outside is moved back into the triangle.
        let nearer = |step: Vector2<f64>| {
            (0..8).find_map(|halving| {
                let place = inside([0, 1].map(|i| best.0[i] + 0.5f64.powi(halving) * step[i]));
                Some((place, squared(place))).filter(|(_, value)| *value < best.1)
            })
        };
        let Some(next) = steps.into_iter().filter_map(nearer).min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        best = next;
    }
    best.1
}

/// The place, moved into the reference triangle if it is outside.
fn inside([x, y]: [f64; 2]) -> [f64; 2] {
    let (x, y) = (x.clamp(0.0, 1.0), y.clamp(0.0, 1.0));
    let excess = (0.5 * (x + y - 1.0)).max(0.0);
    let x = (x - excess).clamp(0.0, 1.0);
    [x, (y - excess).clamp(0.0, 1.0 - x)]
}

/// The rigid motion, after a reflection if that counts too and fits better, that brings points nearest to others in the mean square.
fn fit(from: &[Vector3<f64>], to: &[Vector3<f64>], mirror: bool) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + use<> {
    let motion = |sign: f64| {
        let reflection = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign));
        let reflected: Vec<_> = from.iter().map(|p| reflection * p).collect();
        let (rotation, translation) = rigid_fit(&reflected, to);
        let matrix = rotation.matrix() * reflection;
        let misfit: f64 = from.iter().zip(to).map(|(p, q)| (matrix * p + translation - q).norm_squared()).sum();
        (matrix, translation, misfit)
    };
    let (straight, mirrored) = (motion(1.0), if mirror { motion(-1.0) } else { motion(1.0) });
    let (matrix, translation, _) = if mirrored.2 < straight.2 { mirrored } else { straight };
    move |p| matrix * p + translation
}

/// Largest distance of a node from its own place in a target shape after the best rigid fit of all nodes, each counting the same [m].
///
/// `target`, `now`: the same nodes [m]. `mirror`: whether the target's mirror image is as good. NaN if a node is not finite or the lists
/// differ in length.
pub fn nodes_distance(target: &[Vector3<f64>], now: &[Vector3<f64>], mirror: bool) -> f64 {
    if target.len() != now.len() || target.iter().chain(now).flatten().any(|x| !x.is_finite()) {
        return f64::NAN;
    }
    let fitted = fit(target, now, mirror);
    target.iter().zip(now).map(|(t, p)| (fitted(t) - p).norm()).fold(0.0, f64::max)
}

/// Hausdorff distance [m] between a target surface and the present one, after the rigid fit of [`nodes_distance`].
///
/// A surface is given by its nodes, which correspond, and as a whole.
pub fn surface_distance(target: (&[Vector3<f64>], &Surface), now: (&[Vector3<f64>], &Surface), mirror: bool) -> f64 {
    if nodes_distance(target.0, now.0, mirror).is_nan() {
        return f64::NAN;
    }
    let fitted = fit(target.0, now.0, mirror);
    let moved = Surface { nodes: target.1.nodes.iter().map(fitted).collect(), faces: target.1.faces.clone() };
    moved.hausdorff(now.1)
}
