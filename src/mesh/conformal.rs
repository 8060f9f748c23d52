//! Conformal maps of surfaces that are discs to the plane: boundary first flattening (R. Sawhney and K. Crane, ACM Transactions on Graphics
//! 37(1), 2017).
//!
//! A conformal map scales the metric by `e^(2u)`. That the plane has no curvature is the Yamabe equation, with the cotangent Laplacian `L`,
//! the angle defects `K` of inner vertices and the exterior angles `k` of boundary vertices
//!
//! ```text
//! (L u)_i = -K_i  inside,   k'_i = k_i + (L u)_i  on the boundary,
//! ```
//!
//! where `k'` are the exterior angles of the flat boundary: `u` on the boundary gives `k'` (Dirichlet to Neumann) and the other way round.
//! Lengths `e^((u_i + u_j) / 2) l_ij` and angles `k'` lay out the boundary, and both coordinates are extended inwards as harmonic functions,
//! which keeps faces upright where the boundary is convex and the weights of `L` are positive. (The other way that the paper has, conjugate
//! harmonic coordinates, is nearer to conformal on coarse meshes, but does not keep the boundary where it was laid out.)
//!
//! [`Onto::Natural`]: `u = 0` on the boundary, which distorts areas least. Angles and lengths do not quite close the curve, so lengths `l`
//! are changed least, with weights `1 / l`, until they do; they are not changed where the surface is flat already.
//!
//! [`Onto::Disc`]: exterior angles in proportion to the flat lengths around each vertex, which makes a circle. The paper's iteration (angles
//! give `u`, `u` gives lengths, lengths give angles) lowers `u . L u / 2 + K . u + k . u - 2 pi ln(length)` in every step and halves the error
//! once near; only the conformal maps of the disc onto itself are left open by it. They are fixed in every step: the mean of all vertices,
//! each weighted by a third of the area of its original faces, goes to the centre. That mean is a weighted mean of the boundary vertices, with
//! weights that one solve gives.
//!
//! Both maps are turned so that the flat vertices fit best to the projection of the surface along its mean normal; a flat surface in the xy
//! plane is not turned. Errors are of second order in the edge length where surface and boundary are smooth.

mod circle;
mod laplacian;

use super::validate::fans;
use super::{FieldOn, Mesh, MeshField, Quality, Stars, Topology};
use crate::error::{Error, Result};
use laplacian::{Factor, Laplacian};
use nalgebra::{Complex, Matrix2, Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// Change of an arc of the boundary circle [rad] from which on the iteration has converged.
const CONVERGED: f64 = 1e-12;
/// Steps of the iteration; each halves the error.
const STEPS: usize = 400;
/// Least ratio of a flat face's area to the square of its longest edge.
const LEAST_AREA: f64 = 1e-12;
/// Name of the field with the logarithm of the scale.
pub const FACTOR: &str = "conformal_factor";
/// Name of the field with the original shape.
pub const POSITION: &str = "original_position";

/// What a surface is flattened onto.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onto {
    /// The boundary that leaves lengths there as they are.
    Natural,
    /// A disc.
    Disc {
        /// Radius [m], > 0.
        radius: f64,
    },
}

/// A surface in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Flattened {
    /// Places of the nodes [m]: the vertices, then the midpoints if faces are curved. Their mean, weighted by the original areas around, is the
    /// origin.
    pub nodes: Vec<Vector2<f64>>,
    /// Per node `s` with (original metric) = `e^(2s)` (flat metric); no unit.
    pub log_scale: Vec<f64>,
}

/// Flattens a valid mesh with one boundary and no holes or handles. A curved face counts as the four straight ones between its nodes, so that
/// growth by the factor and the curved image of a face agree within the face too, not only from face to face.
///
/// Errors: a mesh that is no disc; a radius that is not positive; faces too thin; a boundary that cannot be closed or made a circle; a boundary
/// vertex with half of the weight in the mean or more; faces that the map turns over, by number.
pub fn flatten(mesh: &Mesh, onto: Onto) -> Result<Flattened> {
    if let Onto::Disc { radius } = onto
        && !(radius > 0.0 && radius.is_finite())
    {
        return Err(Error::input("flatten.radius", format!("{radius} is not usable: must be > 0 [m]")));
    }
    let divided = (!mesh.midpoints.is_empty()).then(|| mesh.divided());
    let straight = divided.as_ref().unwrap_or(mesh);
    let mut surface = SurfaceData::new(straight)?;
    let flat = match onto {
        Onto::Natural => surface.natural()?,
        Onto::Disc { radius } => surface.disc(radius)?,
    };
    let parts = straight.faces.len() / mesh.faces.len();
    check_upright(straight, parts, &flat.nodes)?;
    Ok(flat)
}

/// Faces with two sides on the boundary. On a disc the corner between the sides has almost a half turn, so they come out as slivers.
pub fn corner_faces(mesh: &Mesh) -> Vec<usize> {
    let topology = Topology::new(&mesh.faces);
    let outer = |face: &usize| topology.face_edges[*face].iter().filter(|e| topology.is_boundary(**e)).count();
    (0..mesh.faces.len()).filter(|face| outer(face) > 1).collect()
}

impl Mesh {
    /// Replaces the shape by its flat image in the xy plane, normal +z, and keeps regions and fields.
    ///
    /// The fields `conformal_factor` ([`Flattened::log_scale`]) and `original_position` [m] of the nodes are added. Errors: those of [`flatten`], a
    /// field of one of these names.
    pub fn flatten(&mut self, onto: Onto) -> Result<()> {
        if let Some(name) = [FACTOR, POSITION].into_iter().find(|name| self.fields.contains_key(*name)) {
            return Err(Error::input("flatten", format!("the mesh has a field `{name}` already")));
        }
        let flat = flatten(self, onto)?;
        let position = self.nodes().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let mut nodes: Vec<Vector3<f64>> = flat.nodes.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
        self.midpoints = nodes.split_off(self.vertices.len());
        self.vertices = nodes;
        let factor = MeshField { on: FieldOn::Nodes, components: 1, data: flat.log_scale };
        self.fields.insert(FACTOR.into(), factor);
        self.fields.insert(POSITION.into(), MeshField { on: FieldOn::Nodes, components: 3, data: position });
        Ok(())
    }
}

/// What both maps need of a surface.
struct SurfaceData<'a> {
    mesh: &'a Mesh,
    /// Vertices of the boundary in turn, faces to the left, from the lowest number on.
    boundary: Vec<usize>,
    /// Length of the boundary edge after each of them [m].
    lengths: Vec<f64>,
    /// A third of the area of the faces around each vertex [m2].
    areas: Vec<f64>,
    /// Angle defect of inner vertices, exterior angle of boundary vertices [rad].
    curvature: Vec<f64>,
    laplacian: Laplacian<'a>,
    /// The Laplacian with the boundary held.
    inside: Factor,
}

impl<'a> SurfaceData<'a> {
    fn new(mesh: &'a Mesh) -> Result<Self> {
        let boundary = boundary_of_disc(mesh)?;
        let place = |k: usize| mesh.vertices[boundary[k % boundary.len()]];
        let lengths = (0..boundary.len()).map(|k| (place(k + 1) - place(k)).norm()).collect();
        let mut held = vec![false; mesh.vertices.len()];
        boundary.iter().for_each(|&v| held[v] = true);
        let mut curvature: Vec<f64> = held.iter().map(|&on_boundary| if on_boundary { PI } else { TAU }).collect();
        let mut areas = vec![0.0; mesh.vertices.len()];
        let mut angles = Vec::with_capacity(mesh.faces.len());
        for face in &mesh.faces {
            let corners = face.map(|v| mesh.vertices[v]);
            let mut of_face = [0.0; 3];
            for i in 0..3 {
                let (u, v) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
                let twice_area = u.cross(&v).norm();
                of_face[i] = twice_area.atan2(u.dot(&v));
                curvature[face[i]] -= of_face[i];
                areas[face[i]] += twice_area / 6.0;
            }
            angles.push(of_face);
        }
        let laplacian = Laplacian::new(mesh, &angles);
        let inside = laplacian.factorise(&held)?;
        Ok(SurfaceData { mesh, boundary, lengths, areas, curvature, laplacian, inside })
    }

    /// The map that leaves lengths at the boundary as they are.
    fn natural(&mut self) -> Result<Flattened> {
        let minus_curvature: Vec<f64> = self.curvature.iter().map(|k| -k).collect();
        let u = self.inside.solve(&minus_curvature);
        let flux = self.laplacian.times(&u);
        let mut direction = 0.0;
        let tangents: Vec<Vector2<f64>> = self
            .boundary
            .iter()
            .map(|&v| {
                direction += self.curvature[v] + flux[v];
                Vector2::new(direction.cos(), direction.sin())
            })
            .collect();
        let sides = || tangents.iter().zip(&self.lengths);
        let spread: Matrix2<f64> = sides().map(|(t, l)| t * t.transpose() * *l).sum();
        let gap: Vector2<f64> = sides().map(|(t, l)| t * *l).sum();
        let pull = spread.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * gap);
        let mut place = Complex::new(0.0, 0.0);
        let mut curve = Vec::with_capacity(self.boundary.len());
        for (t, l) in sides() {
            curve.push(place);
            let length = l * (1.0 - t.dot(&pull));
            if !(length > 0.0) {
                return Err(Error::input_with_help(
                    "flatten",
                    "the flat boundary does not close",
                    "use a finer mesh, or flatten onto a disc",
                ));
            }
            place += Complex::new(t.x, t.y) * length;
        }
        let mut points = self.extend(&curve);
        let middle = self.mean(&points);
        points.iter_mut().for_each(|p| *p -= middle);
        Ok(Flattened { nodes: self.turned(&points), log_scale: u.iter().map(|u| -u).collect() })
    }

    /// The map onto the disc.
    fn disc(&mut self, radius: f64) -> Result<Flattened> {
        let weights = self.boundary_weights();
        let count = self.boundary.len();
        // Any one vertex can be held, since `u` is determined up to a constant.
        let mut held = vec![false; self.mesh.vertices.len()];
        held[self.boundary[0]] = true;
        let mut pinned = self.laplacian.factorise(&held)?;
        let mut points = circle::points(&self.lengths);
        self.centre(&mut points, &weights)?;
        let mut arcs = circle::arcs(&points);
        let mut change = f64::INFINITY;
        let mut u = Vec::new();
        for _ in 0..STEPS {
            let mut right: Vec<f64> = self.curvature.iter().map(|k| -k).collect();
            for (k, &v) in self.boundary.iter().enumerate() {
                // The exterior angle of a polygon in a circle.
                right[v] += 0.5 * (arcs[k] + arcs[(k + count - 1) % count]);
            }
            u = pinned.solve(&right);
            let highest = self.boundary.iter().map(|&v| u[v]).fold(f64::MIN, f64::max);
            let half = |k: usize| 0.5 * (u[self.boundary[k % count]] - highest);
            let lengths: Vec<f64> = self.lengths.iter().enumerate().map(|(k, l)| l * (half(k) + half(k + 1)).exp()).collect();
            points = circle::points(&lengths);
            self.centre(&mut points, &weights)?;
            let new = circle::arcs(&points);
            change = new.iter().zip(&arcs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            arcs = new;
            if !(change > CONVERGED) {
                break;
            }
        }
        if !(change <= CONVERGED) {
            let message = format!("the boundary is not yet a circle after {STEPS} steps: an arc still changes by {change:.1e} rad");
            return Err(Error::input_with_help("flatten", message, "use a finer mesh"));
        }
        let flat = self.extend(&points);
        let mut vertices = self.turned(&flat);
        for &v in &self.boundary {
            vertices[v] = vertices[v].normalize();
        }
        vertices.iter_mut().for_each(|p| *p *= radius);
        let area: f64 = self.mesh.faces.iter().map(|face| twice_area(face, &vertices) / 2.0).sum();
        let highest = u.iter().copied().fold(f64::MIN, f64::max);
        let scaled: f64 = u.iter().zip(&self.areas).map(|(u, a)| a * (2.0 * (u - highest)).exp()).sum();
        // The constant that gives the disc its area.
        let constant = 0.5 * (area / scaled).ln() - highest;
        Ok(Flattened { nodes: vertices, log_scale: u.iter().map(|u| -(u + constant)).collect() })
    }

    /// Brings the mean of boundary points on the unit circle with the weights of [`SurfaceData::boundary_weights`] to the centre.
    fn centre(&self, points: &mut [Complex<f64>], weights: &[f64]) -> Result<()> {
        circle::centre(points, weights).map_err(|off| {
            let total: f64 = weights.iter().sum();
            let heaviest = (0..weights.len()).max_by(|i, j| weights[*i].total_cmp(&weights[*j])).unwrap_or(0);
            let (vertex, share) = (self.boundary[heaviest], weights[heaviest] / total);
            let p = self.mesh.vertices[vertex];
            let message = if share >= 0.5 {
                format!(
                    "the boundary vertex at ({:.4e}, {:.4e}, {:.4e}) m has {:.0} % of the weight in the mean over the surface: where one has \
                     half or more, no map onto the disc brings the mean to the centre",
                    p.x,
                    p.y,
                    p.z,
                    100.0 * share
                )
            } else {
                format!("the mean over the surface stays off the centre of the disc by {off:.1e} of its radius")
            };
            Error::input_with_help("flatten", message, "use a finer mesh without obtuse faces, above all at the boundary")
        })
    }

    /// Weights of the boundary vertices, in turn, that give the mean over all vertices by area of any function harmonic inside.
    fn boundary_weights(&mut self) -> Vec<f64> {
        let inner = self.inside.solve(&self.areas);
        let flux = self.laplacian.times(&inner);
        self.boundary.iter().map(|&v| self.areas[v] - flux[v]).collect()
    }

    /// Mean over all vertices, weighted by area.
    fn mean(&self, points: &[Complex<f64>]) -> Complex<f64> {
        let total: f64 = self.areas.iter().sum();
        points.iter().zip(&self.areas).map(|(p, a)| p * *a).sum::<Complex<f64>>() / total
    }

    /// Harmonic coordinates with the given boundary, in turn.
    fn extend(&mut self, curve: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let mut coordinate = |part: fn(&Complex<f64>) -> f64| {
            let mut x = vec![0.0; self.mesh.vertices.len()];
            self.boundary.iter().zip(curve).for_each(|(&v, z)| x[v] = part(z));
            self.inside.extend(&self.laplacian, x)
        };
        let (x, y) = (coordinate(|z| z.re), coordinate(|z| z.im));
        x.into_iter().zip(y).map(|(x, y)| Complex::new(x, y)).collect()
    }

    /// The points turned about the origin so that they fit best to the surface seen along its mean normal.
    fn turned(&self, points: &[Complex<f64>]) -> Vec<Vector2<f64>> {
        let mesh = self.mesh;
        let normal: Vector3<f64> = mesh
            .faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|v| mesh.vertices[v]);
                (b - a).cross(&(c - a))
            })
            .sum();
        let normal = normal.try_normalize(1e-9 * self.areas.iter().sum::<f64>()).unwrap_or(Vector3::z());
        let axis = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let first = (axis - normal * normal.dot(&axis)).normalize();
        let second = normal.cross(&first);
        let origin = mesh.vertices[0];
        let seen = |v: usize| Complex::new(first.dot(&(mesh.vertices[v] - origin)), second.dot(&(mesh.vertices[v] - origin)));
        let sum: Complex<f64> = points.iter().enumerate().map(|(v, p)| p * seen(v).conj() * self.areas[v]).sum();
        let turn = if sum.norm() > 0.0 { sum.conj() / sum.norm() } else { Complex::new(1.0, 0.0) };
        points.iter().map(|p| p * turn).map(|p| Vector2::new(p.re, p.im)).collect()
    }
}

/// The boundary of a disc, in turn. Error: a mesh that is none.
fn boundary_of_disc(mesh: &Mesh) -> Result<Vec<usize>> {
    let refuse = |message: String| {
        Err(Error::input_with_help(
            "flatten",
            message,
            "only a surface in one piece with one boundary and no holes or handles is flattened",
        ))
    };
    let quality = Quality::of(mesh);
    let (parts, loops, euler) = (quality.components, quality.boundary_loops, quality.euler_characteristic);
    if (parts, loops, euler) != (1, 1, 1) {
        return refuse(format!("the mesh has {parts} parts, {loops} boundaries and the Euler characteristic {euler}: expected 1 of each"));
    }
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    if let Some(v) = (0..mesh.vertices.len()).find(|&v| fans(mesh, v, stars.of(v)) != 1) {
        return refuse(format!("at vertex {v} faces touch that share no edge there"));
    }
    let topology = Topology::new(&mesh.faces);
    let mut next = vec![None; mesh.vertices.len()];
    for (face, edges) in mesh.faces.iter().zip(&topology.face_edges) {
        for i in (0..3).filter(|&i| topology.is_boundary(edges[i])) {
            next[face[(i + 1) % 3]] = Some(face[(i + 2) % 3]);
        }
    }
    let mut boundary = Vec::new();
    let mut at = next.iter().position(Option::is_some);
    while let Some(v) = at {
        boundary.push(v);
        at = next[v].take().filter(|&v: &usize| next[v].is_some());
    }
    Ok(boundary)
}

fn twice_area(face: &[usize; 3], points: &[Vector2<f64>]) -> f64 {
    let [a, b, c] = face.map(|v| points[v]);
    (b - a).perp(&(c - a))
}

/// Refuses a map that turns faces over. `parts`: number of faces here that are one face of the user's mesh.
fn check_upright(mesh: &Mesh, parts: usize, points: &[Vector2<f64>]) -> Result<()> {
    let is_upright = |face: &[usize; 3]| {
        let longest = (0..3).map(|i| (points[face[i]] - points[face[(i + 1) % 3]]).norm_squared()).fold(0.0, f64::max);
        twice_area(face, points) > 2.0 * LEAST_AREA * longest
    };
    let mut bad: Vec<usize> = (0..mesh.faces.len()).filter(|&f| !is_upright(&mesh.faces[f])).map(|f| f / parts).collect();
    bad.dedup();
    let Some(first) = bad.first() else { return Ok(()) };
    let message = format!("{} faces are turned over or without area in the plane, first face {first}", bad.len());
    Err(Error::input_with_help("flatten", message, "use a finer mesh without obtuse faces, or another `onto`"))
}
