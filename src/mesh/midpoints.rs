//! Midpoints of edges: turns a mesh of straight faces into one of curved faces on the surface that its vertices sample.
//!
//! Where the surface is known, midpoints lie on it; where it is not, they lie on surfaces fitted to the vertices around. Vertices stay
//! where they are. Whether the curved faces are sound is the business of [`super::validate`].

use super::{Mesh, Stars, Topology};
use nalgebra::{SMatrix, SVector, Vector3};

/// How near to the rim, relative to the radius, a vertex counts as lying on it.
const ON_RIM: f64 = 1e-9;
/// Rings of faces whose vertices a fit takes, at least and at most, and vertices from which on it takes no more.
const RINGS: [usize; 2] = [2, 4];
const MOST: usize = 80;
/// A fit that misses a vertex by more than this fraction of its neighbourhood's radius is no smooth surface.
const MISFIT: f64 = 0.03;
/// Penalty on the square of a coefficient of first, second and third degree. Where vertices cannot tell two heights apart, it takes the
/// one of lower degree; elsewhere it is too small to matter.
const PENALTY: [f64; 3] = [1e-12, 1e-10, 1e-8];
/// A fit is determined if no pivot of its normal equations is below this fraction of the largest.
const DETERMINED: f64 = 5e-3;

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
    /// Cap of a sphere around the origin with its rim around the z axis: halfway along the great circle through the two ends, for edges of
    /// the rim along the rim.
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

/// Fills [`Mesh::midpoints`], replacing any there are; fields of the nodes get the mean of the two ends there. The mesh must be valid otherwise ([`super::validate::check`]).
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
            Surface::Sphere { radius } => {
                let on_rim = topology.is_boundary(edge) && (a.z - b.z).abs() <= ON_RIM * radius;
                if on_rim { around(a, b, radii[0]) } else { (a + b).try_normalize(0.0).map_or(straight, |direction| radius * direction) }
            }
            Surface::Smooth => {
                let heights: Vec<Vector3<f64>> =
                    ends.iter().filter_map(|&v| patches[v].as_ref()).map(|patch| patch.lift(straight)).collect();
                if heights.is_empty() { straight } else { straight + heights.iter().sum::<Vector3<f64>>() / heights.len() as f64 }
            }
        }
    };
    let midpoints = (0..topology.edges.len()).map(middle).collect();
    mesh.drop_midpoints();
    mesh.node_fields().for_each(|field| topology.edges.iter().for_each(|ends| field.push_mean(*ends)));
    mesh.midpoints = midpoints;
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
    coefficients: SVector<f64, 9>,
}

impl Patch {
    /// Local coordinates of a point, in units of the radius.
    fn local(&self, point: Vector3<f64>) -> [f64; 3] {
        self.frame.map(|axis| axis.dot(&(point - self.origin)) / self.radius)
    }

    /// What carries a point along the normal onto the patch.
    fn lift(&self, point: Vector3<f64>) -> Vector3<f64> {
        let [x, y, z] = self.local(point);
        let height = monomials(x, y).dot(&self.coefficients);
        self.frame[2] * (self.radius * (height - z))
    }
}

/// Monomials of first to third degree, weighted such that the sum of squares of the coefficients of one degree does not depend on the
/// directions of x and y.
fn monomials(x: f64, y: f64) -> SVector<f64, 9> {
    let (two, three) = (2f64.sqrt(), 3f64.sqrt());
    [x, y, x * x, two * x * y, y * y, x * x * x, three * x * x * y, three * x * y * y, y * y * y].into()
}

/// The surface fitted around each vertex, if there is one.
fn patches(mesh: &Mesh) -> Vec<Option<Patch>> {
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    (0..mesh.vertices.len()).map(|v| fit(mesh, &stars, v)).collect()
}

/// Takes vertices from more and more rings until they determine a cubic, as few do at a boundary.
fn fit(mesh: &Mesh, stars: &Stars, vertex: usize) -> Option<Patch> {
    let normal = normal(mesh, stars, vertex)?;
    let first = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let frame = [first, normal.cross(&first), normal];
    let mut found = vec![vertex];
    let mut ring = 0..1;
    let mut best = None;
    for count in 1..=RINGS[1] {
        for k in ring.clone() {
            for &v in stars.of(found[k]).iter().flat_map(|&f| &mesh.faces[f]) {
                if found.len() < MOST && !found.contains(&v) {
                    found.push(v);
                }
            }
        }
        ring = ring.end..found.len();
        if ring.is_empty() {
            break;
        }
        if count >= RINGS[0] || found.len() == MOST {
            let (patch, determined) = regress(mesh, &found, frame)?;
            best = Some(patch);
            if determined {
                break;
            }
        }
    }
    // A mesh of one ring: what it has must do.
    let patch = best.or_else(|| regress(mesh, &found, frame).map(|(patch, _)| patch))?;
    let misses = found.iter().map(|&v| patch.lift(mesh.vertices[v]).norm());
    misses.fold(0.0, f64::max).le(&(MISFIT * patch.radius)).then_some(patch)
}

/// Least squares through the first vertex of `found`, and whether they determine all coefficients.
fn regress(mesh: &Mesh, found: &[usize], frame: [Vector3<f64>; 3]) -> Option<(Patch, bool)> {
    let (origin, around) = (mesh.vertices[found[0]], &found[1..]);
    let distance = |v: usize| (mesh.vertices[v] - origin).norm();
    let radius = around.iter().map(|&v| distance(v)).fold(0.0, f64::max);
    if !(radius > 0.0 && radius.is_finite()) {
        return None;
    }
    let mut patch = Patch { origin, frame, radius, coefficients: SVector::zeros() };
    let penalty = |k: usize| PENALTY[usize::from(k > 1) + usize::from(k > 4)];
    let mut matrix = SMatrix::<f64, 9, 9>::from_diagonal(&SVector::from_fn(|k, _| penalty(k)));
    let mut right = SVector::<f64, 9>::zeros();
    for &v in around {
        let [x, y, z] = patch.local(mesh.vertices[v]);
        // Near vertices count more: the patch is used within half an edge.
        let weight = (radius / distance(v).max(1e-3 * radius)).powi(2);
        let row = monomials(x, y);
        matrix += row * row.transpose() * weight;
        right += row * (z * weight);
    }
    let factor = matrix.cholesky()?;
    let pivots = factor.l_dirty().diagonal().map(|l| l * l);
    patch.coefficients = factor.solve(&right);
    Some((patch, pivots.min() > DETERMINED * pivots.max()))
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
