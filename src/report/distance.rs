//! Distances between surfaces: from points to the nearest point of any triangle.

use nalgebra::Vector3;

/// Largest distance [m] of the points from a triangle surface: the one-sided Hausdorff distance of the points.
///
/// `vertices` [m] and `faces` are the surface's. 0 without points; infinite if there are points but no faces; NaN if a
/// coordinate is not finite.
pub fn farthest(points: &[Vector3<f64>], vertices: &[Vector3<f64>], faces: &[[usize; 3]]) -> f64 {
    if points.iter().chain(vertices).any(|p| p.iter().any(|x| !x.is_finite())) {
        return f64::NAN;
    }
    let tree = Tree::new(vertices, faces);
    points.iter().map(|p| tree.nearest(p).1).fold(0.0, f64::max).sqrt()
}

/// Hausdorff distance [m] of two triangle surfaces, measured at the vertices of each against the triangles of the other.
///
/// A surface is its vertices [m] and faces. Between vertices the true distance may be larger by what the faces sag there.
pub fn hausdorff(a: (&[Vector3<f64>], &[[usize; 3]]), b: (&[Vector3<f64>], &[[usize; 3]])) -> f64 {
    let (there, back) = (farthest(a.0, b.0, b.1), farthest(b.0, a.0, a.1));
    if there.is_nan() || back.is_nan() { f64::NAN } else { there.max(back) }
}

/// Square of the distance from a point to a triangle [m^2] (Ericson 2005, section 5.1.5).
fn point_triangle_squared(p: &Vector3<f64>, [a, b, c]: [&Vector3<f64>; 3]) -> f64 {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let along = |from: &Vector3<f64>, edge: &Vector3<f64>| {
        let length = edge.norm_squared();
        let t = if length > 0.0 { ((p - from).dot(edge) / length).clamp(0.0, 1.0) } else { 0.0 };
        (p - from - edge * t).norm_squared()
    };
    let nearest_edge = along(a, &ab).min(along(a, &ac)).min(along(b, &bc));
    let normal = ab.cross(&ac);
    let area = normal.norm_squared();
    // Inside where the point lies to the left of all three edges, seen along the normal.
    let left = |from: &Vector3<f64>, edge: &Vector3<f64>| normal.dot(&edge.cross(&(p - from))) >= 0.0;
    if area > 0.0 && left(a, &ab) && left(b, &bc) && left(c, &-ac) {
        return ((p - a).dot(&normal).powi(2) / area).min(nearest_edge);
    }
    nearest_edge
}

/// A binary tree of boxes over triangles.
pub(super) struct Tree<'a> {
    vertices: &'a [Vector3<f64>],
    faces: &'a [[usize; 3]],
    /// Face indices, sorted so that those of a node stand together.
    order: Vec<usize>,
    /// Box of each node; the children of node `i` are `2i + 1` and `2i + 2`, each with half of its faces.
    boxes: Vec<[Vector3<f64>; 2]>,
}

/// Faces per leaf, at most.
const LEAF: usize = 4;

impl<'a> Tree<'a> {
    /// Tree over a surface of finite coordinates.
    pub fn new(vertices: &'a [Vector3<f64>], faces: &'a [[usize; 3]]) -> Self {
        let mut tree = Tree { vertices, faces, order: (0..faces.len()).collect(), boxes: Vec::new() };
        if !faces.is_empty() {
            tree.split(0, 0, faces.len());
        }
        tree
    }

    fn split(&mut self, node: usize, start: usize, end: usize) {
        let (vertices, faces) = (self.vertices, self.faces);
        let corners = self.order[start..end].iter().flat_map(|f| faces[*f]).map(|v| vertices[v]);
        let everywhere = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        let [low, high] = corners.fold(everywhere, |[l, h], p| [l.inf(&p), h.sup(&p)]);
        if self.boxes.len() <= node {
            self.boxes.resize(node + 1, everywhere);
        }
        self.boxes[node] = [low, high];
        if end - start > LEAF {
            let axis = (high - low).imax();
            let place = |face: usize| faces[face].iter().map(|v| vertices[*v][axis]).sum::<f64>();
            let half = (end - start) / 2;
            self.order[start..end].select_nth_unstable_by(half, |f, g| place(*f).total_cmp(&place(*g)));
            self.split(2 * node + 1, start, start + half);
            self.split(2 * node + 2, start + half, end);
        }
    }

    /// The face nearest to a point and the square of its distance [m^2], infinite without faces.
    pub fn nearest(&self, p: &Vector3<f64>) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        if !self.boxes.is_empty() {
            self.search(p, 0, 0, self.faces.len(), &mut best);
        }
        best
    }

    /// The faces whose squared distance from a point is at most that [m^2], among them the nearest one if that is.
    pub fn within(&self, p: &Vector3<f64>, squared: f64) -> Vec<usize> {
        let mut found = Vec::new();
        let mut waiting = if self.boxes.is_empty() { Vec::new() } else { vec![(0, 0, self.faces.len())] };
        while let Some((node, start, end)) = waiting.pop() {
            if self.to_box_squared(p, node) > squared {
                continue;
            }
            if end - start > LEAF {
                let half = start + (end - start) / 2;
                waiting.extend([(2 * node + 1, start, half), (2 * node + 2, half, end)]);
                continue;
            }
            let near = |face: &usize| point_triangle_squared(p, self.faces[*face].map(|v| &self.vertices[v])) <= squared;
            found.extend(self.order[start..end].iter().copied().filter(near));
        }
        found
    }

    fn search(&self, p: &Vector3<f64>, node: usize, start: usize, end: usize, best: &mut (usize, f64)) {
        if self.to_box_squared(p, node) >= best.1 {
            return;
        }
        if end - start <= LEAF {
            for &face in &self.order[start..end] {
                let distance = point_triangle_squared(p, self.faces[face].map(|v| &self.vertices[v]));
                if distance < best.1 {
                    *best = (face, distance);
                }
            }
            return;
        }
        let half = start + (end - start) / 2;
        let (first, second) = ((2 * node + 1, start, half), (2 * node + 2, half, end));
        let nearer = self.to_box_squared(p, first.0) <= self.to_box_squared(p, second.0);
        for (node, start, end) in if nearer { [first, second] } else { [second, first] } {
            self.search(p, node, start, end, best);
        }
    }

    fn to_box_squared(&self, p: &Vector3<f64>, node: usize) -> f64 {
        let [low, high] = &self.boxes[node];
        (low - p).sup(&(p - high)).sup(&Vector3::zeros()).norm_squared()
    }
}
