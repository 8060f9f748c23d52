//! Midpoints of edges: turns a mesh of straight faces into one of curved faces on the surface that its vertices sample.
//!
//! Where the surface is known, midpoints lie on it; where it is not, they lie on surfaces fitted to the vertices around. Vertices stay
//! where they are. Whether the curved faces are sound is the business of [`super::validate`].

use super::{Mesh, Stars, Topology};
use nalgebra::{DMatrix, DVector, Unit, Vector3};

/// How near to the rim, relative to its radius, a vertex counts as lying on it.
const ON_RIM: f64 = 1e-9;
/// Vertices around a vertex that a fit asks for before it stops gathering, how many it takes at most, and from how many rings.
const ENOUGH: usize = 18;
const MOST: usize = 80;
const MOST_RINGS: usize = 4;
/// A fit that misses a vertex by more than this fraction of its neighbourhood's radius is no smooth surface.
const MISFIT: f64 = 0.03;
/// Singular values below this fraction of the largest count as zero.
const RANK: f64 = 1e-9;
/// Weight of a monomial by degree. Where vertices cannot tell two heights apart, the smallest coefficients are taken: then the ones of
/// lowest degree.
const BY_DEGREE: f64 = 1e-2;
/// Iterations allowed to a singular value decomposition; it needs a few dozen.
const DECOMPOSITION_STEPS: usize = 1000;

/// The surface on which edges have their midpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Flat faces: midpoints halve the straight edges.
    Plane,
    /// Flat, with circles around the z axis: mean distance from the axis and mean angle of the two ends, the short way round.
    Annulus,
    /// Flat, with a circular rim around the z axis: as [`Surface::Annulus`] for boundary edges with both ends on the rim, straight elsewhere.
    Disc {
        /// Radius of the rim [m].
        radius: f64,
    },
    /// Cylinder about the z axis: mean angle, the short way round, and mean height of the two ends.
    Cylinder {
        /// Radius [m].
        radius: f64,
    },
    /// Sphere around the origin: halfway along the great circle through the two ends.
    Sphere {
        /// Radius [m].
        radius: f64,
    },
    /// Unknown but smooth: cubic height functions are fitted to the vertices around each end of the edge (least squares, through that
    /// end), and the midpoint is the mean of the two heights above the middle of the straight edge.
    ///
    /// The error is of fourth order in the edge length, at the boundary too. A boundary keeps its straight edges where it is curved
    /// within the surface, as the rim of a flat disc is. Where a fit misses its vertices, as at a crease, it is left out; an edge without
    /// a fit stays straight.
    Smooth,
}

/// Fills [`Mesh::midpoints`], replacing any there are. The mesh must be valid otherwise ([`super::validate::check`]).
///
/// Where a direction is not defined, because the ends lie opposite each other or on the axis, the edge stays straight.
pub fn place(mesh: &mut Mesh, surface: Surface) {
    let topology = Topology::new(&mesh.faces);
    let patches = match surface {
        Surface::Smooth => patches(mesh),
        _ => Vec::new(),
    };
    let middle = |edge: usize| {
        let ends = topology.edges[edge];
        let [a, b] = ends.map(|v| mesh.vertices[v]);
        let straight = a.lerp(&b, 0.5);
        let radii = [a, b].map(|p| p.xy().norm());
        match surface {
            Surface::Plane => straight,
            Surface::Annulus => around(a, b, 0.5 * (radii[0] + radii[1])),
            Surface::Disc { radius } => {
                let on_rim = topology.is_boundary(edge) && radii.iter().all(|r| (r - radius).abs() <= ON_RIM * radius);
                if on_rim { around(a, b, radius) } else { straight }
            }
            Surface::Cylinder { radius } => around(a, b, radius),
            Surface::Sphere { radius } => (a + b).try_normalize(0.0).map_or(straight, |direction| radius * direction),
            Surface::Smooth => {
                let heights: Vec<Vector3<f64>> =
                    ends.iter().filter_map(|&v| patches[v].as_ref()).map(|patch| patch.lift(straight)).collect();
                if heights.is_empty() { straight } else { straight + heights.iter().sum::<Vector3<f64>>() / heights.len() as f64 }
            }
        }
    };
    mesh.midpoints = (0..topology.edges.len()).map(middle).collect();
}

/// The point at `radius` [m] from the z axis, at the mean angle (the short way round) and height of two points.
///
/// The sum of the directions halves the angle between them without a branch cut.
fn around(a: Vector3<f64>, b: Vector3<f64>, radius: f64) -> Vector3<f64> {
    let straight = a.lerp(&b, 0.5);
    let direction = |p: Vector3<f64>| p.xy().try_normalize(0.0);
    let middle = direction(a).zip(direction(b)).and_then(|(u, v)| (u + v).try_normalize(1e-9));
    middle.map_or(straight, |m| Vector3::new(radius * m.x, radius * m.y, straight.z))
}

/// A height function over the tangent plane of a vertex.
struct Patch {
    origin: Vector3<f64>,
    /// Two tangents and the normal.
    frame: [Vector3<f64>; 3],
    /// Unit of length of the coefficients [m].
    radius: f64,
    coefficients: DVector<f64>,
}

impl Patch {
    /// Local coordinates of a point, in units of the radius.
    fn local(&self, point: Vector3<f64>) -> [f64; 3] {
        self.frame.map(|axis| axis.dot(&(point - self.origin)) / self.radius)
    }

    /// What carries a point along the normal onto the patch.
    fn lift(&self, point: Vector3<f64>) -> Vector3<f64> {
        let [x, y, z] = self.local(point);
        let height: f64 = monomials(x, y).iter().zip(&self.coefficients).map(|(m, c)| m * c).sum();
        self.frame[2] * (self.radius * (height - z))
    }
}

/// Monomials of first to third degree, weighted by degree, and such that the sum of squares of the coefficients does not depend on the
/// directions of x and y.
fn monomials(x: f64, y: f64) -> [f64; 9] {
    let (two, three) = (2f64.sqrt() * BY_DEGREE, 3f64.sqrt() * BY_DEGREE * BY_DEGREE);
    let (square, cube) = (BY_DEGREE, BY_DEGREE * BY_DEGREE);
    [x, y, square * x * x, two * x * y, square * y * y, cube * x * x * x, three * x * x * y, three * x * y * y, cube * y * y * y]
}

/// The surface fitted around each vertex, if there is one.
fn patches(mesh: &Mesh) -> Vec<Option<Patch>> {
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    (0..mesh.vertices.len()).map(|v| fit(mesh, &stars, v)).collect()
}

fn fit(mesh: &Mesh, stars: &Stars, vertex: usize) -> Option<Patch> {
    let origin = mesh.vertices[vertex];
    let normal = normal(mesh, stars, vertex)?;
    let around = neighbourhood(mesh, stars, vertex);
    let distance = |v: usize| (mesh.vertices[v] - origin).norm();
    let radius = around.iter().map(|&v| distance(v)).fold(0.0, f64::max);
    if !(radius > 0.0 && radius.is_finite()) {
        return None;
    }
    let first = Unit::new_normalize(normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
    let frame = [*first, normal.cross(&first), normal];
    let mut patch = Patch { origin, frame, radius, coefficients: DVector::zeros(9) };
    let places: Vec<[f64; 3]> = around.iter().map(|&v| patch.local(mesh.vertices[v])).collect();
    // Near vertices count more: the patch is used within half an edge.
    let weights: Vec<f64> = around.iter().map(|&v| radius / distance(v).max(1e-3 * radius)).collect();
    let matrix = DMatrix::from_fn(places.len(), 9, |i, j| weights[i] * monomials(places[i][0], places[i][1])[j]);
    let heights = DVector::from_fn(places.len(), |i, _| weights[i] * places[i][2]);
    let decomposition = matrix.try_svd(true, true, f64::EPSILON, DECOMPOSITION_STEPS)?;
    let largest = decomposition.singular_values.max();
    patch.coefficients = decomposition.solve(&heights, RANK * largest).ok()?;
    let misses = around.iter().map(|&v| patch.lift(mesh.vertices[v]).norm());
    misses.fold(0.0, f64::max).le(&(MISFIT * radius)).then_some(patch)
}

/// Vertex normal: faces weighted by the sine of their angle over the lengths of its sides (N. Max, Journal of Graphics Tools 4, 1999),
/// which is exact on spheres.
fn normal(mesh: &Mesh, stars: &Stars, vertex: usize) -> Option<Vector3<f64>> {
    let sum = stars.of(vertex).iter().filter_map(|&f| {
        let face = mesh.faces[f];
        let at = face.iter().position(|&v| v == vertex)?;
        let [u, v] = [1, 2].map(|k| mesh.vertices[face[(at + k) % 3]] - mesh.vertices[vertex]);
        Some((u / u.norm_squared()).cross(&(v / v.norm_squared())))
    });
    sum.sum::<Vector3<f64>>().try_normalize(0.0)
}

/// Vertices in rings of faces around a vertex, without itself: two rings, more until there are enough, at most [`MOST`].
fn neighbourhood(mesh: &Mesh, stars: &Stars, vertex: usize) -> Vec<usize> {
    let mut found = vec![vertex];
    let mut ring = 0..1;
    for count in 0..MOST_RINGS {
        if count >= 2 && found.len() > ENOUGH {
            break;
        }
        for k in ring.clone() {
            for &v in stars.of(found[k]).iter().flat_map(|&f| &mesh.faces[f]) {
                if found.len() > MOST {
                    break;
                }
                if !found.contains(&v) {
                    found.push(v);
                }
            }
        }
        ring = ring.end..found.len();
    }
    found.remove(0);
    found
}
