//! Polygons filled with unstructured triangles: what a user may draw is checked here, [`super::delaunay`] fills it.

use super::delaunay::{self, Filled};
use super::{Triangulation, check_count, check_faces, check_length};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Region};
use nalgebra::Vector2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// Smallest size of triangles as a fraction of the largest coordinate: below it, positions lose too many digits.
const SMALLEST_SIZE: f64 = 1e-9;

/// Flat polygon in the xy plane with holes, unstructured triangles, normal +z.
///
/// `points`: at least 3 corners [m] in either sense, not repeated at the end. `holes`: polygons like it, inside the outline and
/// apart from each other. Sides are split into equal parts of about the target size; no face has two sides
/// on the boundary. Regions: outline, hole-0, hole-1, ...
///
/// `place`: file or key that the points come from, for messages.
pub fn outline(place: &str, points: &[[f64; 2]], holes: &[Vec<[f64; 2]>], triangulation: Triangulation) -> Result<Mesh> {
    let mut loops = vec![Loop::new(place.to_owned(), points, true)?];
    for (k, hole) in holes.iter().enumerate() {
        loops.push(Loop::new(format!("mesh.outline.holes[{k}]"), hole, false)?);
    }
    check_apart(&loops)?;
    let Filled { mut mesh, sides } = fill(&loops, triangulation, 0, true, "mesh.outline.triangulation")?;
    for (k, sides) in sides.iter().enumerate() {
        let name = if k == 0 { "outline".into() } else { format!("hole-{}", k - 1) };
        mesh.regions.insert(name, sides.iter().fold(Region::default(), |all, side| all.union(&Region::path(side, false))));
    }
    Ok(mesh)
}

/// Rectangle like [`super::rectangle`], but of unstructured triangles. Without `triangulation` their size is such that there are
/// about `2 cells.0 cells.1`. `seed` varies the places of the inner vertices. Regions: left, right, bottom, top, boundary.
pub fn rectangle_delaunay(size: [f64; 2], cells: [usize; 2], triangulation: Option<Triangulation>, seed: u64) -> Result<Mesh> {
    size.iter().try_for_each(|&s| check_length("mesh.rectangle.size", s))?;
    cells.iter().try_for_each(|&n| check_count("mesh.rectangle.cells", n, 1, super::MAX_FACES))?;
    let face_area = 0.5 * (size[0] / cells[0] as f64) * (size[1] / cells[1] as f64);
    let triangulation = triangulation.unwrap_or(Triangulation { size: (face_area * 4.0 / 3f64.sqrt()).sqrt(), min_angle: 25.0 });
    let corners = [[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]];
    let loops = [Loop::new("mesh.rectangle.size".into(), &corners, true)?];
    let Filled { mut mesh, sides } = fill(&loops, triangulation, seed, false, "mesh.rectangle.triangulation")?;
    let mut boundary = Region::default();
    for (name, side) in ["bottom", "right", "top", "left"].into_iter().zip(&sides[0]) {
        let side = Region::path(side, false);
        boundary = boundary.union(&side);
        mesh.regions.insert(name.into(), side);
    }
    mesh.regions.insert("boundary".into(), boundary);
    Ok(mesh)
}

/// A closed polygon with the domain on its left.
struct Loop {
    /// Key of the scene that holds it.
    place: String,
    corners: Vec<Vector2<f64>>,
}

impl Loop {
    fn new(place: String, points: &[[f64; 2]], counter_clockwise: bool) -> Result<Self> {
        if points.len() < 3 {
            return Err(Error::input(place, format!("{} points do not make a polygon: expected at least 3", points.len())));
        }
        if let Some((k, p)) = points.iter().enumerate().find(|(_, p)| p.iter().any(|&x| spade::validate_coordinate(x).is_err())) {
            return Err(Error::input(place, format!("point {k} is [{}, {}]: expected coordinates in metres", p[0], p[1])));
        }
        let mut corners: Vec<_> = points.iter().map(|&[x, y]| Vector2::new(x, y)).collect();
        if (signed_area(&corners) > 0.0) != counter_clockwise {
            corners.reverse();
        }
        Ok(Loop { place, corners })
    }
}

/// Area [m2], positive if counter-clockwise. Taken from the first corner, so that a distant polygon loses no digits.
fn signed_area(p: &[Vector2<f64>]) -> f64 {
    p.windows(2).map(|w| (w[0] - p[0]).perp(&(w[1] - p[0]))).sum::<f64>() / 2.0
}

/// Refuses loops that meet themselves or each other, and holes that do not lie inside. The tests for meeting are exact.
fn check_apart(loops: &[Loop]) -> Result<()> {
    let corners: Vec<_> = loops.iter().flat_map(|l| l.corners.iter().copied()).collect();
    let owner: Vec<usize> = loops.iter().enumerate().flat_map(|(k, l)| vec![k; l.corners.len()]).collect();
    let mut sides = Vec::with_capacity(corners.len());
    for l in loops {
        let first = sides.len();
        sides.extend((0..l.corners.len()).map(|k| [first + k, first + (k + 1) % l.corners.len()]));
    }
    let at = |v: usize| format!("({}, {})", corners[v].x, corners[v].y);
    let refused = |[a, b]: [usize; 2]| {
        let message = format!("the side from {} to {} meets another side or corner", at(a), at(b));
        Err(Error::input_with_help(&loops[owner[a]].place, message, "polygons must not cross or touch themselves or each other"))
    };
    let mut order: Vec<usize> = (0..corners.len()).collect();
    order.sort_by(|&a, &b| corners[a].x.total_cmp(&corners[b].x).then(corners[a].y.total_cmp(&corners[b].y)).then(a.cmp(&b)));
    if let Some(w) = order.windows(2).find(|w| corners[w[0]] == corners[w[1]]) {
        return Err(Error::input(&loops[owner[w[1]]].place, format!("the corner {} occurs twice", at(w[1]))));
    }
    let mut conflict = None;
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        corners.iter().map(|p| Point2::new(p.x, p.y)).collect(),
        sides.clone(),
        |side| {
            conflict.get_or_insert(side);
        },
    )
    .map_err(|e| Error::input(&loops[0].place, e.to_string()))?;
    if let Some(side) = conflict {
        return refused(side);
    }
    // A side through a foreign corner is in no conflict: it is kept in parts, not as one edge.
    let handles: Vec<_> = cdt.fixed_vertices().collect();
    if let Some(&side) = sides.iter().find(|[a, b]| !cdt.exists_constraint(handles[*a], handles[*b])) {
        return refused(side);
    }
    for (k, hole) in loops.iter().enumerate().skip(1) {
        if !contains(&loops[0].corners, hole.corners[0]) {
            return Err(Error::input(&hole.place, "the hole lies outside the outline"));
        }
        for other in (1..loops.len()).filter(|&other| other != k) {
            if contains(&loops[other].corners, hole.corners[0]) {
                return Err(Error::input(&hole.place, format!("the hole lies inside {}", loops[other].place)));
            }
        }
    }
    Ok(())
}

/// Whether a point that is not on the polygon lies inside it: a ray towards +x leaves it an odd number of times.
fn contains(polygon: &[Vector2<f64>], p: Vector2<f64>) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    sides.filter(|(a, b)| delaunay::crosses_ray(**a, **b, p)).count() % 2 == 1
}

/// Checks the sizes and fills the domain to the left of `loops`.
fn fill(loops: &[Loop], triangulation: Triangulation, seed: u64, share_corners: bool, key: &str) -> Result<Filled> {
    let Triangulation { size, min_angle } = triangulation;
    let size_key = format!("{key}.size");
    check_length(&size_key, size)?;
    if !(0.0..=30.0).contains(&min_angle) {
        return Err(Error::input(format!("{key}.min_angle"), format!("{min_angle} is out of range: expected 0 to 30 degrees")));
    }
    let corners = || loops.iter().flat_map(|l| &l.corners);
    let largest = corners().fold(0f64, |m, p| m.max(p.x.abs()).max(p.y.abs()));
    if size < SMALLEST_SIZE * largest {
        return Err(Error::input(size_key, format!("{size} m is too small for coordinates as large as {largest} m")));
    }
    let area: f64 = loops.iter().map(|l| signed_area(&l.corners)).sum();
    let faces = area / (3f64.sqrt() / 4.0 * size * size);
    let length: f64 = loops.iter().flat_map(|l| l.corners.iter().zip(l.corners.iter().cycle().skip(1))).map(|(a, b)| (b - a).norm()).sum();
    check_faces(&size_key, faces.max(length / size))?;
    let extent = |f: fn(&Vector2<f64>) -> f64| corners().map(f).fold(f64::MIN, f64::max) - corners().map(f).fold(f64::MAX, f64::min);
    check_faces(&size_key, 0.1 * extent(|p| p.x) * extent(|p| p.y) / (size * size))?;
    let polygons: Vec<&[Vector2<f64>]> = loops.iter().map(|l| l.corners.as_slice()).collect();
    delaunay::fill(&polygons, faces, size, min_angle, seed, share_corners).map_err(|message| Error::input(&loops[0].place, message))
}
