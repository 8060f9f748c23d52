//! Tables `[mesh]` and `[[region]]`.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Where the triangles come from: one generator (`[mesh.rectangle]`, `[mesh.disc]`, ...) or one file (`[mesh.file]`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeshTable {
    /// Flat rectangle `[0, size.0] x [0, size.1]` in the xy plane, normal +z. Regions: left, right, bottom, top, boundary.
    Rectangle(Rectangle),
    /// Flat disc around the origin, normal +z. Regions: rim, center.
    Disc(Disc),
    /// Flat annulus around the origin, normal +z. Regions: inner, outer; with a slit also slit-start, slit-end.
    Annulus(Annulus),
    /// Cylinder about the z axis from z = 0, outward normal. Regions: bottom, top; if open also start, end.
    Cylinder(Cylinder),
    /// Cap of a sphere around the origin, apex on +z, outward normal. Regions: rim, apex.
    SphereCap(SphereCap),
    /// Flat polygon with holes, Delaunay triangles, normal +z. Regions: outline, hole-0, hole-1, ...
    Outline(Outline),
    /// Rectangle of `p x q` nodes, flat in the xy plane or on a given surface, for the models on grids. Regions: left, right, bottom, top,
    /// boundary.
    Grid(Grid),
    /// A mesh file. Regions: its named groups.
    File(MeshFile),
}

impl MeshTable {
    /// Path of the file that the mesh is read or made from, relative to the scene file.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            MeshTable::File(table) => Some(&table.path),
            MeshTable::Outline(table) => table.file.as_ref(),
            _ => None,
        }
    }

    /// The generator of a grid, if it is one.
    pub fn grid(&self) -> Option<&Grid> {
        if let MeshTable::Grid(table) = self { Some(table) } else { None }
    }

    /// The same, to change it.
    pub fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            MeshTable::File(table) => Some(&mut table.path),
            MeshTable::Outline(table) => table.file.as_mut(),
            _ => None,
        }
    }
}

/// How a structured rectangle is cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Every cell by the same diagonal, lower left to upper right; two faces a cell.
    #[default]
    Diagonal,
    /// Diagonals alternate like a chessboard; two faces a cell.
    Alternating,
    /// Both diagonals and a vertex at the centre; four faces a cell.
    CrissCross,
    /// Unstructured Delaunay triangles of about the area of half a cell.
    Delaunay,
}

/// Generator `rectangle`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Length and width [m], > 0.
    pub size: [f64; 2],
    /// Cells along x and y, 1 to 10000; for `delaunay` they set the size of the triangles unless `triangulation` does.
    pub cells: [usize; 2],
    /// Pattern.
    #[serde(default)]
    pub pattern: Pattern,
    /// Random shift of inner vertices in each direction, as a fraction of the cell, 0 to 0.45. Not with `delaunay`.
    #[serde(default)]
    pub jitter: f64,
    /// Seed of the shift (and of the points of `delaunay`).
    #[serde(default)]
    pub seed: u64,
    /// Size and quality of `delaunay` triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangulation: Option<Triangulation>,
}

/// Size and quality of unstructured triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Triangulation {
    /// Target edge length [m], > 0.
    pub size: f64,
    /// Smallest angle aimed at [degrees], 0 to 30.
    #[serde(default = "default_min_angle")]
    pub min_angle: f64,
}

fn default_min_angle() -> f64 {
    25.0
}

/// Generator `grid`: a surface over a rectangle of material coordinates. Its nodes keep these as field `material_coordinates`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Nodes along the two material coordinates, 3 to 3000.
    pub nodes: [usize; 2],
    /// Lengths of the rectangle of material coordinates [m], > 0.
    pub size: [f64; 2],
    /// Place of a node [m], of x and y, here its material coordinates, and of their r and theta. Absent: flat, `["x", "y", 0]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[Expr; 3]>,
}

/// Generator `disc`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius [m], > 0.
    pub radius: f64,
    /// Rings of faces between centre and rim, 1 to 5000; ring `i` has `6 i` outer vertices.
    pub rings: usize,
}

/// Generator `annulus`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Annulus {
    /// Inner and outer radius [m], 0 < inner < outer.
    pub radii: [f64; 2],
    /// Cells in radius (>= 1) and around (>= 3).
    pub cells: [usize; 2],
    /// Cut along the positive x axis: the two sides of the cut have vertices of their own.
    #[serde(default)]
    pub slit: bool,
    /// How cells are cut: `diagonal`, `alternating` or `criss-cross`.
    #[serde(default)]
    pub pattern: Pattern,
}

/// Generator `cylinder`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Radius [m], > 0.
    pub radius: f64,
    /// Length along z [m], > 0.
    pub length: f64,
    /// Opening angle [degrees], > 0 and <= 360; 360 closes it. It starts at the positive x axis.
    #[serde(default = "full_turn")]
    pub angle: f64,
    /// Cells around (>= 1, closed >= 3) and along z (>= 1).
    pub cells: [usize; 2],
    /// How cells are cut: `diagonal`, `alternating` or `criss-cross`.
    #[serde(default)]
    pub pattern: Pattern,
}

fn full_turn() -> f64 {
    360.0
}

/// Generator `sphere-cap`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereCap {
    /// Radius of the sphere [m], > 0.
    pub radius: f64,
    /// Angle between the axis and the rim, seen from the sphere's centre [degrees], > 0 and < 180.
    pub half_angle: f64,
    /// Rings of faces between apex and rim, 1 to 5000.
    pub rings: usize,
}

/// Generator `outline`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Outline {
    /// Corners in the xy plane [m], at least 3, in either sense, not repeated at the end. Either these or `file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 2]>>,
    /// CSV file with the corners instead: columns `x` and `y` [m], `#` before comments. Path relative to the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Polygons cut out, inside the outline and apart from each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<Vec<[f64; 2]>>,
    /// Size and quality of the triangles.
    pub triangulation: Triangulation,
}

/// A mesh file: `.obj .ply .stl .vtu .vtp .vtk .msh` (Gmsh 2.2 and 4.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path, relative to the scene file.
    pub path: PathBuf,
    /// Factor that turns the file's lengths into metres, > 0 (0.001 for a file in mm).
    #[serde(default = "one")]
    pub scale: f64,
    /// Where the quadratic element and `[refine]` have the middles of the edges of a linear file; a quadratic file brings its own.
    #[serde(default)]
    pub midpoints: Midpoints,
}

/// Middles of the edges of a linear mesh file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Midpoints {
    /// Halfway along the straight edges: a curved shell then has kinks.
    #[default]
    Straight,
    /// On a smooth surface fitted to the vertices around.
    Smooth,
}

fn one() -> f64 {
    1.0
}

/// Splits every face of the mesh into four, through the middles of its edges, so that finer meshes are like coarser ones. Middles lie on the
/// rims and surfaces of the generators and on the curved faces of quadratic files, halfway along the straight edges elsewhere; of a linear file
/// as its `midpoints` says. Regions and fields of the mesh come along; regions by `where` and `nearest` are those of the refined mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refine {
    /// How often, 1 to 12: each time there are four times as many faces, 2e7 at most.
    pub times: usize,
}

/// Replaces the shape of the mesh, a surface in one piece with one boundary and no holes or handles, by its conformal image in the xy plane,
/// normal +z. Regions by `where` and `nearest` are those of the flat mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flatten {
    /// Shape of the flat mesh.
    pub onto: FlattenOnto,
    /// Radius of the disc [m], > 0; by default such that the disc has the area of the surface. With `onto = "disc"` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
}

/// Shapes of a flattened mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlattenOnto {
    /// A disc around the origin; the mean of the surface by area goes to its centre.
    Disc,
    /// Lengths at the boundary stay as they are; the origin is the mean of the surface by area.
    Natural,
}

/// A named part of the mesh, by one of `where`, `nearest`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionTable {
    /// Name, used by pins, materials and reports; must be new.
    pub name: String,
    /// Condition on a place of the initial mesh (with `[flatten]` the flat one), of x, y, z, r, theta: `"x < 0.01"`. Vertices where it holds, edges with both ends
    /// among them, faces where it holds at the centroid.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub condition: Option<Expr>,
    /// The one vertex nearest to this point [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<[f64; 3]>,
}
