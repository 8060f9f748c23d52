//! Structured meshes of cells in two directions: rectangle, annulus, cylinder.

use super::{Pattern, check_count, check_faces, check_length};
use crate::error::{Error, Result};
use crate::mesh::{FieldOn, Mesh, MeshField, Region, Stars};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Smallest area that jitter leaves a face, as a fraction of its area without.
const JITTER_MIN_AREA: f64 = 0.05;

/// Cells in two directions `i`, `j`; faces turn from `i` to `j`. A direction that closes has as many columns of corners as cells.
#[derive(Clone, Copy)]
struct Grid {
    cells: [usize; 2],
    closed: [bool; 2],
    pattern: Pattern,
}

impl Grid {
    fn check(&self, place: &str, low: [usize; 2]) -> Result<()> {
        for (cells, low) in self.cells.into_iter().zip(low) {
            check_count(place, cells, low, super::MAX_FACES)?;
        }
        let per_cell = if self.pattern == Pattern::CrissCross { 4.0 } else { 2.0 };
        check_faces(place, per_cell * self.cells[0] as f64 * self.cells[1] as f64)
    }

    /// Columns of corners in each direction.
    fn corners(&self) -> [usize; 2] {
        [0, 1].map(|k| self.cells[k] + usize::from(!self.closed[k]))
    }

    /// Vertex index of a corner.
    fn corner(&self, i: usize, j: usize) -> usize {
        let [columns, rows] = self.corners();
        (i % columns) * rows + j % rows
    }

    /// Faces and positions; `place` maps grid coordinates (cell corners are whole numbers) to space. Corners come first, with
    /// index `i * rows + j`, then the centres of criss-cross cells.
    fn build(&self, place: impl Fn(f64, f64) -> Vector3<f64>) -> Mesh {
        let [columns, rows] = self.corners();
        let [ni, nj] = self.cells;
        let mut mesh = Mesh::default();
        for i in 0..columns {
            mesh.vertices.extend((0..rows).map(|j| place(i as f64, j as f64)));
        }
        for i in 0..ni {
            for j in 0..nj {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.corner(i, j));
                match self.pattern {
                    Pattern::CrissCross => {
                        let m = mesh.vertices.len();
                        mesh.vertices.push(place(i as f64 + 0.5, j as f64 + 0.5));
                        mesh.faces.extend([[a, b, m], [b, c, m], [c, d, m], [d, a, m]]);
                    }
                    Pattern::Alternating if (i + j) % 2 == 1 => mesh.faces.extend([[a, b, d], [b, c, d]]),
                    Pattern::Diagonal | Pattern::Alternating => mesh.faces.extend([[a, b, c], [a, c, d]]),
                }
            }
        }
        mesh
    }

    /// Corners of constant `i`, as a path along `j`.
    fn at_i(&self, i: usize) -> Region {
        Region::path(&(0..self.corners()[1]).map(|j| self.corner(i, j)).collect::<Vec<_>>(), self.closed[1])
    }

    /// Corners of constant `j`, as a path along `i`.
    fn at_j(&self, j: usize) -> Region {
        Region::path(&(0..self.corners()[0]).map(|i| self.corner(i, j)).collect::<Vec<_>>(), self.closed[0])
    }
}

/// Flat rectangle `[0, size.0] x [0, size.1]` in the xy plane, normal +z; corner `(i, j)` has index `i (cells.1 + 1) + j`.
///
/// `size`: length and width [m]. `jitter`: random shift of inner vertices in each direction as a fraction of the cell, 0 to
/// 0.45, drawn from `seed`; a shift that would leave a face with less than a twentieth of its area is halved until it does not.
/// Regions: left, right, bottom, top, boundary.
pub fn rectangle(size: [f64; 2], cells: [usize; 2], pattern: Pattern, jitter: f64, seed: u64) -> Result<Mesh> {
    size.iter().try_for_each(|&s| check_length("mesh.rectangle.size", s))?;
    let grid = Grid { cells, closed: [false; 2], pattern };
    grid.check("mesh.rectangle.cells", [1, 1])?;
    if !(0.0..=0.45).contains(&jitter) {
        return Err(Error::input("mesh.rectangle.jitter", format!("{jitter} is out of range: expected 0 to 0.45")));
    }
    let [nx, ny] = cells.map(|n| n as f64);
    // Divide before multiplying: the far sides lie at exactly `size`.
    let mut mesh = grid.build(|i, j| Vector3::new(size[0] * (i / nx), size[1] * (j / ny), 0.0));
    let sides = [("left", grid.at_i(0)), ("right", grid.at_i(cells[0])), ("bottom", grid.at_j(0)), ("top", grid.at_j(cells[1]))];
    let boundary = sides.iter().fold(Region::default(), |all, (_, side)| all.union(side));
    if jitter > 0.0 {
        shift_vertices(&mut mesh, &boundary.vertices, [jitter * size[0] / nx, jitter * size[1] / ny], seed);
    }
    mesh.regions.extend(sides.into_iter().chain([("boundary", boundary)]).map(|(name, region)| (name.to_string(), region)));
    Ok(mesh)
}

/// Field of the nodes that holds the material coordinates [m] of a surface on a grid.
pub const MATERIAL_COORDINATES: &str = "material_coordinates";

/// Surface on a grid of `nodes`, two faces a cell; node `(i, j)` has index `i nodes.1 + j`. `place`: position [m] by material coordinates [m],
/// which run to `size` and are kept as field [`MATERIAL_COORDINATES`]. Regions: left, right, bottom, top, boundary.
pub fn surface_grid(nodes: [usize; 2], size: [f64; 2], place: impl Fn(f64, f64) -> Vector3<f64>) -> Result<Mesh> {
    size.iter().try_for_each(|&s| check_length("mesh.grid.size", s))?;
    nodes.iter().try_for_each(|&n| check_count("mesh.grid.nodes", n, 3, super::MAX_FACES))?;
    let cells = nodes.map(|n| n - 1);
    let grid = Grid { cells, closed: [false; 2], pattern: Pattern::Diagonal };
    grid.check("mesh.grid.nodes", [2, 2])?;
    let at = |i: f64, j: f64| [size[0] * (i / cells[0] as f64), size[1] * (j / cells[1] as f64)];
    let mut mesh = grid.build(|i, j| place(at(i, j)[0], at(i, j)[1]));
    let data = (0..nodes[0]).flat_map(|i| (0..nodes[1]).flat_map(move |j| at(i as f64, j as f64))).collect();
    mesh.fields.insert(MATERIAL_COORDINATES.into(), MeshField { on: FieldOn::Nodes, components: 2, data });
    let sides = [("left", grid.at_i(0)), ("right", grid.at_i(cells[0])), ("bottom", grid.at_j(0)), ("top", grid.at_j(cells[1]))];
    let boundary = sides.iter().fold(Region::default(), |all, (_, side)| all.union(side));
    mesh.regions.extend(sides.into_iter().chain([("boundary", boundary)]).map(|(name, region)| (name.to_string(), region)));
    Ok(mesh)
}

/// Moves each vertex that is not `fixed` (ascending) by up to `reach` in x and y, without folding a face.
fn shift_vertices(mesh: &mut Mesh, fixed: &[usize], reach: [f64; 2], seed: u64) {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let area = |vertices: &[Vector3<f64>], face: &[usize; 3]| {
        let [a, b, c] = face.map(|v| vertices[v]);
        (b - a).xy().perp(&(c - a).xy())
    };
    let floor: Vec<f64> = mesh.faces.iter().map(|f| JITTER_MIN_AREA * area(&mesh.vertices, f)).collect();
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    for v in 0..mesh.vertices.len() {
        if fixed.binary_search(&v).is_ok() {
            continue;
        }
        let home = mesh.vertices[v];
        let mut shift = Vector3::new(generator.random_range(-1.0..=1.0) * reach[0], generator.random_range(-1.0..=1.0) * reach[1], 0.0);
        mesh.vertices[v] = home + shift;
        while stars.of(v).iter().any(|&f| area(&mesh.vertices, &mesh.faces[f]) < floor[f]) {
            shift *= 0.5;
            mesh.vertices[v] = home + shift;
        }
    }
}

/// Flat annulus around the origin, normal +z; corner `(i, j)`: `i` in radius from the inside, `j` around from the +x axis.
///
/// `radii`: inner and outer [m]. `cells`: in radius (>= 1) and around (>= 3). With `slit` it is cut along +x: the two sides have
/// vertices of their own at the same places. Regions: inner, outer; with a slit also slit-start (angle 0) and slit-end.
pub fn annulus(radii: [f64; 2], cells: [usize; 2], slit: bool, pattern: Pattern) -> Result<Mesh> {
    radii.iter().try_for_each(|&r| check_length("mesh.annulus.radii", r))?;
    if radii[0] >= radii[1] {
        let message = format!("inner radius {} is not smaller than outer radius {}", radii[0], radii[1]);
        return Err(Error::input("mesh.annulus.radii", message));
    }
    let grid = Grid { cells, closed: [false, !slit], pattern };
    grid.check("mesh.annulus.cells", [1, 3])?;
    let mut mesh = grid.build(|i, j| {
        let t = i / cells[0] as f64;
        // The centre of a cell lies on its chords, or wide cells would not hold it.
        let chord = if j.fract() == 0.0 { 1.0 } else { (PI / cells[1] as f64).cos() };
        let r = chord * (radii[0] * (1.0 - t) + radii[1] * t);
        let (sin, cos) = turn(j, cells[1]).sin_cos();
        Vector3::new(r * cos, r * sin, 0.0)
    });
    mesh.regions.insert("inner".into(), grid.at_i(0));
    mesh.regions.insert("outer".into(), grid.at_i(cells[0]));
    if slit {
        mesh.regions.insert("slit-start".into(), grid.at_j(0));
        mesh.regions.insert("slit-end".into(), grid.at_j(cells[1]));
    }
    Ok(mesh)
}

/// Angle [rad] of step `j` of `n` in a full turn; the last step lies exactly on the first.
fn turn(j: f64, n: usize) -> f64 {
    if j == n as f64 { 0.0 } else { TAU * j / n as f64 }
}

/// Cylinder about the z axis, from z = 0 to `length` [m], outward normal; corner `(i, j)`: `i` around from the +x axis, `j` along z.
///
/// `radius` [m]. `angle`: opening angle [degrees], > 0 and <= 360; 360 closes it. `cells`: around (>= 1, closed >= 3) and along.
/// Regions: bottom, top; if open also start (angle 0) and end.
pub fn cylinder(radius: f64, length: f64, angle: f64, cells: [usize; 2], pattern: Pattern) -> Result<Mesh> {
    check_length("mesh.cylinder.radius", radius)?;
    check_length("mesh.cylinder.length", length)?;
    if !(angle > 0.0 && angle <= 360.0) {
        return Err(Error::input("mesh.cylinder.angle", format!("{angle} is out of range: expected more than 0, up to 360 degrees")));
    }
    let closed = angle == 360.0;
    let grid = Grid { cells, closed: [closed, false], pattern };
    grid.check("mesh.cylinder.cells", if closed { [3, 1] } else { [1, 1] })?;
    let mut mesh = grid.build(|i, j| {
        let (sin, cos) = (angle.to_radians() * i / cells[0] as f64).sin_cos();
        Vector3::new(radius * cos, radius * sin, length * (j / cells[1] as f64))
    });
    // One open cell across half a turn or more would be a flat face through the axis, or beyond it.
    if angle / cells[0] as f64 >= 180.0 {
        return Err(Error::input("mesh.cylinder.cells", format!("{} cells around are too few for {angle} degrees", cells[0])));
    }
    mesh.regions.insert("bottom".into(), grid.at_j(0));
    mesh.regions.insert("top".into(), grid.at_j(cells[1]));
    if !closed {
        mesh.regions.insert("start".into(), grid.at_i(0));
        mesh.regions.insert("end".into(), grid.at_i(cells[0]));
    }
    Ok(mesh)
}
