//! Pressure that follows the surface: a force `p n dA` on every piece of it, `n` its present normal.
//!
//! The forces are those of the present surface, integrated with the shape functions. Their derivative is symmetric wherever the edge of
//! the loaded part is held or the part is closed; elsewhere the symmetric part is taken, which costs iterations, not accuracy.
//!
//! The energy is minus the flux through the surface of a field whose divergence is `p`: `P (x - x_0) int_0^1 s^(d - 1) p ds` along the way to `x`
//! from where `P (x - x_0)` is zero, `P` a projection of rank `d`. With `d = 3` that is `p` times the volume seen from `x_0`. When the surface moves
//! the flux changes by `p` times the volume swept and by an integral along the rim of the loaded part, which is zero where the rim is held, and
//! where it stays in a plane along which the field is directed: that of a plane of symmetry through `x_0`, or with a normal that `P` takes out, as
//! two parallel ones need. A part whose rim moves in any other way has no energy; only a line search is given one, the work since it began
//! by the trapezoidal rule.
//!
//! A pressure may vary with the present place, as that of a liquid does. Three Gauss points along the way make its energy exact for a pressure of
//! third degree in place with `d = 3`. For others the forces are still exact. The derivative of `p` in place is a central difference.

use super::{ScalarField, not_finite};
use crate::math::SurfacePoint;
use crate::math::quadrature::GAUSS;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::{Matrix3, Vector3};

/// What the pressure is [Pa].
enum Value {
    /// The same everywhere.
    Uniform(f64),
    /// A field of the present place and of time.
    Field(Field),
}

/// What the volume under a loaded part is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// A point on every plane of symmetry [m].
    pub origin: Vector3<f64>,
    /// Axes of the projection.
    pub axes: [bool; 3],
}

impl Viewpoint {
    /// The origin.
    pub const ORIGIN: Self = Viewpoint { origin: Vector3::new(0.0, 0.0, 0.0), axes: [true; 3] };

    /// `P (x - x_0)`.
    fn way(&self, place: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|k, _| if self.axes[k] { place[k] - self.origin[k] } else { 0.0 })
    }

    fn dimension(&self) -> i32 {
        self.axes.iter().filter(|axis| **axis).count() as i32
    }
}

struct Field {
    value: ScalarField,
    time: f64,
    /// Half the distance over which its derivative is taken [m].
    step: f64,
    /// Initial places of the quadrature points, where it is looked at beforehand.
    places: Vec<Vector3<f64>>,
}

impl Value {
    fn at(&self, place: &Vector3<f64>) -> f64 {
        match self {
            Value::Uniform(p) => *p,
            Value::Field(field) => (field.value)(place, field.time),
        }
    }

    /// The field whose divergence is the pressure [N/m].
    fn flux(&self, place: &Vector3<f64>, from: &Viewpoint) -> Vector3<f64> {
        let (way, dimension) = (from.way(place), from.dimension());
        let moment = match self {
            Value::Uniform(p) => p / f64::from(dimension),
            Value::Field(field) => {
                let at = |s: f64| (field.value)(&(place - way * (1.0 - s)), field.time);
                GAUSS.iter().map(|(s, w)| w * s.powi(dimension - 1) * at(*s)).sum()
            }
        };
        way * moment
    }

    /// Gradient in place [Pa/m]; none where there is none.
    fn gradient(&self, place: &Vector3<f64>) -> Option<Vector3<f64>> {
        let Value::Field(field) = self else { return None };
        let along = |k: usize| {
            let mut d = Vector3::zeros();
            d[k] = field.step;
            (self.at(&(place + d)) - self.at(&(place - d))) / (2.0 * field.step)
        };
        Some(Vector3::new(along(0), along(1), along(2)))
    }
}

/// Pressure on faces of `K` nodes and `N = 3 K` coordinates.
pub struct Pressure<const K: usize, const N: usize> {
    nodes: Vec<[usize; K]>,
    points: Vec<SurfacePoint<K>>,
    pressure: Value,
    factor: f64,
    /// None for a part that has no energy.
    viewpoint: Option<Viewpoint>,
    /// Without an energy: coordinates of the nodes of each face where a line search began, and the gradient there.
    search: Vec<([Vector3<f64>; K], [f64; N])>,
    scatter: Scatter<N>,
}

impl<const K: usize, const N: usize> Pressure<K, N> {
    /// `nodes`: of each loaded face. `points`: quadrature of the element. `pressure`: [Pa], positive along the normal.
    pub fn new(nodes: Vec<[usize; K]>, points: Vec<SurfacePoint<K>>, pressure: f64) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Pressure {
            nodes,
            points,
            pressure: Value::Uniform(pressure),
            factor: 1.0,
            viewpoint: Some(Viewpoint::ORIGIN),
            search: Vec::new(),
            scatter,
        }
    }

    /// The same with its energy seen from elsewhere; none for a part that has none.
    pub fn seen_from(self, viewpoint: Option<Viewpoint>) -> Self {
        Pressure { viewpoint, ..self }
    }

    /// Whether the pressure is finite at a time wherever the energy of the initial shape takes it.
    pub fn is_finite_beneath(&self, time: f64) -> bool {
        let (Value::Field(field), Some(from)) = (&self.pressure, &self.viewpoint) else { return true };
        let finite = |place: &Vector3<f64>, s: f64| (field.value)(&(place - from.way(place) * (1.0 - s)), time).is_finite();
        field.places.iter().all(|place| GAUSS.iter().all(|(s, _)| finite(place, *s)))
    }

    /// The same with a pressure [Pa] that varies with the present place and with time. `positions`: initial, of all nodes [m]. `diameter`: of the
    /// mesh [m].
    pub fn varying(
        nodes: Vec<[usize; K]>,
        points: Vec<SurfacePoint<K>>,
        value: ScalarField,
        positions: &[Vector3<f64>],
        diameter: f64,
    ) -> Self {
        let at = |face: &[usize; K], point: &SurfacePoint<K>| face.iter().zip(point.shape).map(|(n, s)| positions[*n] * s).sum();
        let places = nodes.iter().flat_map(|face| points.iter().map(move |point| at(face, point))).collect();
        let field = Field { value, time: 0.0, step: 1e-5 * diameter, places };
        Pressure { pressure: Value::Field(field), ..Pressure::new(nodes, points, 0.0) }
    }

    fn stencil(nodes: &[usize; K]) -> [usize; N] {
        std::array::from_fn(|s| 3 * nodes[s / 3] + s % 3)
    }

    fn positions(&self, face: usize, x: &[f64]) -> [Vector3<f64>; K] {
        self.nodes[face].map(|n| Vector3::new(x[3 * n], x[3 * n + 1], x[3 * n + 2]))
    }

    /// Tangent vectors at a quadrature point.
    fn tangents(point: &SurfacePoint<K>, r: &[Vector3<f64>; K]) -> [Vector3<f64>; 2] {
        point.slopes.map(|slopes| r.iter().zip(slopes).map(|(r, s)| r * s).sum())
    }

    fn place(point: &SurfacePoint<K>, r: &[Vector3<f64>; K]) -> Vector3<f64> {
        r.iter().zip(point.shape).map(|(r, n)| r * n).sum()
    }

    /// Gradient and energy of one face.
    fn face(&self, face: usize, x: &[f64]) -> ([f64; N], f64) {
        let r = self.positions(face, x);
        let (mut gradient, mut energy) = ([0.0; N], 0.0);
        for point in &self.points {
            let [r1, r2] = Self::tangents(point, &r);
            let place = Self::place(point, &r);
            let area = r1.cross(&r2) * (self.factor * point.weight);
            let force = area * self.pressure.at(&place);
            for (i, n) in point.shape.iter().enumerate() {
                for k in 0..3 {
                    gradient[3 * i + k] -= n * force[k];
                }
            }
            if let Some(from) = &self.viewpoint {
                energy -= self.pressure.flux(&place, from).dot(&area);
            }
        }
        if let Some((start, before)) = self.search.get(face) {
            let moved = |i: usize| r[i / 3][i % 3] - start[i / 3][i % 3];
            energy += (0..N).map(|i| 0.5 * (before[i] + gradient[i]) * moved(i)).sum::<f64>();
        }
        (gradient, energy)
    }
}

/// `[a]_x` with `[a]_x b = a x b`.
fn cross(a: &Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

impl<const K: usize, const N: usize> super::Load for Pressure<K, N> {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }

    fn set_time(&mut self, time: f64) {
        if let Value::Field(field) = &mut self.pressure {
            field.time = time;
        }
    }

    fn fault(&self, time: f64, _factor: f64) -> Option<(&'static str, String)> {
        let Value::Field(field) = &self.pressure else { return None };
        let on_surface = not_finite(field.places.iter(), time, |p| (field.value)(p, time));
        let beneath = || {
            (!self.is_finite_beneath(time)).then(|| format!("is not finite beneath the surface, where its energy takes it, at t = {time}"))
        };
        on_surface.or_else(beneath).map(|reason| ("pressure", reason))
    }
}

impl<const K: usize, const N: usize> Potential for Pressure<K, N> {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        for nodes in &self.nodes {
            visit(&Self::stencil(nodes));
        }
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new(self.nodes.iter().map(Self::stencil), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        (0..self.nodes.len()).map(|f| self.face(f, x).1).sum()
    }

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        if self.viewpoint.is_none() && curvature == Curvature::Projected {
            self.search.clear();
            self.search = (0..self.nodes.len()).map(|face| (self.positions(face, x), self.face(face, x).0)).collect();
        }
        let energy = self.gradient(x, into);
        // Descent wants a positive semidefinite matrix, which that of a pressure is not.
        if curvature == Curvature::Projected {
            return energy;
        }
        for face in 0..self.nodes.len() {
            let r = self.positions(face, x);
            let mut blocks = [[Matrix3::zeros(); K]; K];
            for point in &self.points {
                let (tangents, place) = (Self::tangents(point, &r), Self::place(point, &r));
                let p = self.pressure.at(&place) * self.factor;
                let [r1, r2] = tangents.map(|t| cross(&t) * (-p * point.weight));
                let varied = self.pressure.gradient(&place).map(|slope| {
                    let area = tangents[0].cross(&tangents[1]) * (self.factor * point.weight);
                    area * slope.transpose()
                });
                for (i, n) in point.shape.iter().enumerate() {
                    for j in 0..K {
                        blocks[i][j] += (r1 * point.slopes[1][j] - r2 * point.slopes[0][j]) * *n;
                        if let Some(varied) = &varied {
                            blocks[i][j] -= varied * (n * point.shape[j]);
                        }
                    }
                }
            }
            let mut hessian = [[0.0; N]; N];
            for i in 0..K {
                for j in 0..=i {
                    let block = (blocks[i][j] + blocks[j][i].transpose()) * 0.5;
                    for a in 0..3 {
                        for b in 0..3 {
                            hessian[3 * i + a][3 * j + b] = block[(a, b)];
                        }
                    }
                }
            }
            self.scatter.add_hessian(face, &hessian, into);
        }
        energy
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let mut energy = 0.0;
        for face in 0..self.nodes.len() {
            let (gradient, e) = self.face(face, x);
            energy += e;
            self.scatter.add_gradient(face, &gradient, into);
        }
        energy
    }
}
