//! Filling polygons with unstructured triangles of uniform size: a constrained Delaunay triangulation of scattered points,
//! smoothed, and refined where it still has small angles.
//!
//! Points scattered at random and moved to the centres of their stars settle into near-equilateral triangles with enough
//! vertices of five or seven neighbours that no direction is preferred. This module trusts its polygons: [`super::polygon`]
//! has checked them.

use crate::mesh::{Mesh, Stars};
use nalgebra::{Vector2, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use spade::handles::FixedVertexHandle;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::collections::HashMap;
use std::f64::consts::TAU;

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Rounds of smoothing and renewed triangulation.
const ROUNDS: usize = 12;
/// Random shift of lattice points, as a fraction of the size, that sets how irregular the mesh becomes.
const SCATTER: f64 = 0.5;
/// Nearest that a scattered point may be to the boundary, as a fraction of the size.
const CLEARANCE: f64 = 0.3;

/// Smallest angle [degrees] that is not rounding alone.
const FLAT: f64 = 1e-8;

/// A filled domain.
pub struct Filled {
    /// Flat mesh, normal +z, without regions.
    pub mesh: Mesh,
    /// For each polygon and each of its sides, the vertices along it.
    pub sides: Vec<Vec<Vec<usize>>>,
}

/// Fills the domain to the left of `polygons` with about `faces` triangles of edge length `size` [m]. `share_corners`: whether every corner is
/// shared by two faces or more.
pub fn fill(polygons: &[&[Vector2<f64>]], faces: f64, size: f64, min_angle: f64, seed: u64, share_corners: bool) -> Result<Filled, String> {
    let mut points = Vec::new();
    let mut pieces = Vec::new();
    let mut corners = Vec::new();
    for polygon in polygons {
        let first = points.len();
        let mut own = Vec::with_capacity(polygon.len());
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            own.push(points.len());
            let parts = ((b - a).norm() / size).round().max(1.0);
            points.extend((0..parts as usize).map(|k| a + (b - a) * (k as f64 / parts)));
        }
        pieces.extend((first..points.len()).map(|k| [k, if k + 1 < points.len() { k + 1 } else { first }]));
        corners.push(own);
    }
    let boundary = points.len();
    // Euler: faces = 2 inner + boundary - 2 + 2 holes.
    let inner = (faces - boundary as f64 + 2.0 - 2.0 * (polygons.len() - 1) as f64) / 2.0;
    let scattered = scatter(&points, &pieces, size, inner.max(0.0) as usize, seed);
    points.extend(scattered);

    let mut domain = Domain::new(triangulate(&points, &pieces)?);
    for _ in 0..ROUNDS {
        smooth(&mut points, boundary, &domain.faces);
        domain = Domain::new(triangulate(&points, &pieces)?);
    }
    if domain.smallest_angle(&points) < min_angle
        && let Some(finer) = refine(&domain.cdt, size, min_angle)
    {
        points = finer.vertices().map(|v| Vector2::new(v.position().x, v.position().y)).collect();
        domain = Domain::new(finer);
    }

    if share_corners && let Some(split) = corners_shared(&domain)? {
        points = split.vertices().map(|v| Vector2::new(v.position().x, v.position().y)).collect();
        domain = Domain::new(split);
    }

    if domain.smallest_angle(&points) < FLAT {
        return Err("two parts of the polygons are so close that a face between them has no area".into());
    }
    let vertices = points.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
    let sides = corners.iter().map(|own| domain.sides(own)).collect();
    Ok(Filled { mesh: Mesh { vertices, faces: domain.faces, ..Mesh::default() }, sides })
}

/// Whether the side from `a` to `b` crosses the ray from `p` towards +x.
pub fn crosses_ray(a: Vector2<f64>, b: Vector2<f64>, p: Vector2<f64>) -> bool {
    if (a.y <= p.y) == (b.y <= p.y) {
        return false;
    }
    let turn = (b.x - a.x) * (p.y - a.y) - (p.x - a.x) * (b.y - a.y);
    (turn > 0.0) == (b.y > a.y)
}

fn triangulate(points: &[Vector2<f64>], pieces: &[[usize; 2]]) -> Result<Cdt, String> {
    let mut conflict = None;
    let cdt =
        Cdt::try_bulk_load_cdt(points.iter().map(|p| Point2::new(p.x, p.y)).collect(), pieces.to_vec(), |piece| conflict = Some(piece))
            .map_err(|e| e.to_string())?;
    if conflict.is_some() || cdt.num_vertices() != points.len() {
        return Err("two parts of the polygons are so close that they cannot be told apart".into());
    }
    Ok(cdt)
}

/// Up to `count` points inside the pieces: a triangular lattice, turned and scattered at random; those farthest from the boundary.
fn scatter(points: &[Vector2<f64>], pieces: &[[usize; 2]], size: f64, count: usize, seed: u64) -> Vec<Vector2<f64>> {
    if count == 0 {
        return Vec::new();
    }
    let nearby = Nearby::new(points, pieces, size);
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let (sin, cos) = generator.random_range(0.0..TAU).sin_cos();
    // Bounds of the domain in the lattice's own frame.
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for p in points {
        for (k, x) in [cos * p.x + sin * p.y, cos * p.y - sin * p.x].into_iter().enumerate() {
            low[k] = low[k].min(x);
            high[k] = high[k].max(x);
        }
    }
    let pitch = size * 3f64.sqrt() / 2.0;
    let [columns, rows] = [(high[0] - low[0]) / size, (high[1] - low[1]) / pitch].map(|n| n.ceil() as usize + 1);
    let mut found = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let mut shift = || generator.random_range(-SCATTER..SCATTER) * size;
            let x = low[0] + (column as f64 + 0.5 * (row % 2) as f64) * size + shift();
            let y = low[1] + row as f64 * pitch + shift();
            let p = Vector2::new(cos * x - sin * y, sin * x + cos * y);
            let distance = nearby.distance(p);
            if distance > CLEARANCE * size && nearby.inside(p) {
                found.push((distance, p));
            }
        }
    }
    // The number of faces follows from the number of points, so leave out those that crowd the boundary.
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&a, &b| found[b].0.total_cmp(&found[a].0).then(a.cmp(&b)));
    order.truncate(count);
    order.sort_unstable();
    order.into_iter().map(|k| found[k].1).collect()
}

/// Boundary pieces by place.
struct Nearby<'a> {
    points: &'a [Vector2<f64>],
    pieces: &'a [[usize; 2]],
    cell: f64,
    cells: HashMap<[i64; 2], Vec<usize>>,
    rows: HashMap<i64, Vec<usize>>,
}

impl<'a> Nearby<'a> {
    fn new(points: &'a [Vector2<f64>], pieces: &'a [[usize; 2]], size: f64) -> Self {
        let mut nearby = Nearby { points, pieces, cell: 2.0 * size, cells: HashMap::new(), rows: HashMap::new() };
        for (k, piece) in pieces.iter().enumerate() {
            let [a, b] = piece.map(|v| nearby.cell_of(points[v]));
            for row in a[1].min(b[1])..=a[1].max(b[1]) {
                nearby.rows.entry(row).or_default().push(k);
                for column in a[0].min(b[0])..=a[0].max(b[0]) {
                    nearby.cells.entry([column, row]).or_default().push(k);
                }
            }
        }
        nearby
    }

    fn cell_of(&self, p: Vector2<f64>) -> [i64; 2] {
        [p.x, p.y].map(|x| (x / self.cell).floor() as i64)
    }

    /// Distance to the boundary [m], or the cell size where it is more.
    fn distance(&self, p: Vector2<f64>) -> f64 {
        let [column, row] = self.cell_of(p);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        let pieces = around.filter_map(|c| self.cells.get(&c)).flatten();
        pieces.map(|&k| segment_distance(self.pieces[k].map(|v| self.points[v]), p)).fold(self.cell, f64::min)
    }

    /// Whether a ray from `p` crosses the boundary an odd number of times.
    fn inside(&self, p: Vector2<f64>) -> bool {
        let Some(pieces) = self.rows.get(&self.cell_of(p)[1]) else { return false };
        let crossed = pieces.iter().filter(|&&k| crosses_ray(self.points[self.pieces[k][0]], self.points[self.pieces[k][1]], p));
        crossed.count() % 2 == 1
    }
}

fn segment_distance([a, b]: [Vector2<f64>; 2], p: Vector2<f64>) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (a + along * t - p).norm()
}

/// A triangulation and the part of it that lies inside the polygons.
struct Domain {
    cdt: Cdt,
    faces: Vec<[usize; 3]>,
    /// End of the boundary edge that starts at a vertex, the domain on its left.
    next: HashMap<usize, usize>,
}

impl Domain {
    /// Walks in from the hull: crossing a constraint changes from outside to inside or back.
    fn new(cdt: Cdt) -> Self {
        let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
        let mut open = Vec::new();
        for edge in cdt.convex_hull().flat_map(|e| [e, e.rev()]) {
            if let Some(face) = edge.face().as_inner() {
                inside[face.index()] = Some(edge.is_constraint_edge());
                open.push(face);
            }
        }
        while let Some(face) = open.pop() {
            let here = inside[face.index()] == Some(true);
            for edge in face.adjacent_edges() {
                if let Some(other) = edge.rev().face().as_inner()
                    && inside[other.index()].is_none()
                {
                    inside[other.index()] = Some(here != edge.is_constraint_edge());
                    open.push(other);
                }
            }
        }
        let (mut faces, mut next) = (Vec::new(), HashMap::new());
        for face in cdt.inner_faces().filter(|f| inside[f.index()] == Some(true)) {
            faces.push(face.vertices().map(|v| v.index()));
            for edge in face.adjacent_edges().into_iter().filter(|e| e.is_constraint_edge()) {
                next.insert(edge.from().index(), edge.to().index());
            }
        }
        Domain { cdt, faces, next }
    }

    /// Vertices along each side of the polygon with the given corners.
    fn sides(&self, corners: &[usize]) -> Vec<Vec<usize>> {
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        ends.map(|(&from, &to)| {
            let mut side = vec![from];
            let mut at = from;
            while let Some(&v) = self.next.get(&at) {
                side.push(v);
                at = v;
                if at == to {
                    break;
                }
            }
            side
        })
        .collect()
    }

    /// Smallest angle [degrees].
    fn smallest_angle(&self, points: &[Vector2<f64>]) -> f64 {
        let angles = self.faces.iter().flat_map(|face| {
            (0..3).map(|i| {
                let [a, b, c] = [0, 1, 2].map(|k| points[face[(i + k) % 3]]);
                (b - a).perp(&(c - a)).atan2((b - a).dot(&(c - a))).to_degrees()
            })
        });
        angles.fold(180.0, f64::min)
    }
}

/// Moves every vertex from index `fixed` on to the area-weighted mean of the centroids of its faces, unless that would fold one
/// (L. Chen and M. Holst 2011, "Efficient mesh optimization schemes based on optimal Delaunay triangulations").
fn smooth(points: &mut [Vector2<f64>], fixed: usize, faces: &[[usize; 3]]) {
    let stars = Stars::new(points.len(), faces);
    let area = |points: &[Vector2<f64>], face: &[usize; 3]| {
        let [a, b, c] = face.map(|v| points[v]);
        (b - a).perp(&(c - a))
    };
    for v in fixed..points.len() {
        let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
        for &f in stars.of(v) {
            let w = area(points, &faces[f]);
            let [a, b, c] = faces[f].map(|v| points[v]);
            sum += (a + b + c) * (w / 3.0);
            weight += w;
        }
        let home = points[v];
        points[v] = sum / weight;
        if !stars.of(v).iter().all(|&f| area(points, &faces[f]) > 0.0) {
            points[v] = home;
        }
    }
}

/// The triangulation with the inner edge of each face halved that has two sides on the boundary; `None` if there is no such face. Alone in its
/// corner, a face would have no vertex that can move inside, and no conformal map could spread the corner.
fn corners_shared(domain: &Domain) -> Result<Option<Cdt>, String> {
    let is_outer = |a: usize, b: usize| domain.next.get(&a) == Some(&b);
    let inner_edges: Vec<[usize; 2]> = domain
        .faces
        .iter()
        .filter_map(|&[a, b, c]| {
            [[a, b, c], [b, c, a], [c, a, b]].into_iter().find(|&[a, b, c]| is_outer(a, b) && is_outer(b, c) && !is_outer(c, a))
        })
        .map(|[a, _, c]| [a, c])
        .collect();
    if inner_edges.is_empty() {
        return Ok(None);
    }
    let mut split = domain.cdt.clone();
    for ends in inner_edges {
        let [a, b] = ends.map(|v| split.vertex(FixedVertexHandle::from_index(v)).position());
        split.insert(Point2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y))).map_err(|e| e.to_string())?;
    }
    Ok(Some(split))
}

/// The triangulation with points added until no angle is smaller than `min_angle` [degrees], save at corners that are; `None` if
/// that has no end.
fn refine(cdt: &Cdt, size: f64, min_angle: f64) -> Option<Cdt> {
    let mut finer = cdt.clone();
    let parameters = RefinementParameters::new()
        .exclude_outer_faces(true)
        .with_angle_limit(AngleLimit::from_deg(min_angle))
        .with_min_required_area(1e-6 * size * size);
    finer.refine(parameters).refinement_complete.then_some(finer)
}
