//! Slabs over meshes, for the tests of diffusion.

use nalgebra::{Matrix2, Vector2, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use thinshell::mesh::generate::{Pattern, rectangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::moisture::{Condition, Data, Diffusion, Law, Mass, Scheme, Side, Slab, Where, in_plane_tensor};

pub const MASSES: [Mass; 2] = [Mass::Lumped, Mass::Consistent];
pub const SCHEMES: [Scheme; 2] = [Scheme::BackwardEuler, Scheme::Sdirk2];

/// A square of two faces.
pub fn cell() -> Mesh {
    rectangle([1.0; 2], [1, 1], Pattern::Diagonal, 0.0, 0).unwrap()
}

/// One thickness everywhere; diffusivities along and across the direction `fibres` in the sheet, and through it [m2/s].
pub fn slab(mesh: &Mesh, thickness: f64, diffusivity: [f64; 3], fibres: Vector3<f64>, levels: Vec<f64>) -> Slab {
    let mut slab = Slab { vertices: mesh.vertices.len(), faces: mesh.faces.clone(), levels, ..Slab::default() };
    for face in &mesh.faces {
        let [v0, v1, v2] = face.map(|v| mesh.vertices[v]);
        let (r1, r2) = (v1 - v0, v2 - v0);
        let metric = [r1.dot(&r1), r1.dot(&r2), r2.dot(&r2)];
        let inverse = Matrix2::new(metric[0], metric[1], metric[1], metric[2]).try_inverse().unwrap();
        let direction = inverse * Vector2::new(r1.dot(&fibres), r2.dot(&fibres));
        slab.metric.push(metric);
        slab.thickness.push(thickness);
        slab.in_plane.push(in_plane_tensor(metric, direction.into(), diffusivity[0], diffusivity[1]));
        slab.through.push(diffusivity[2]);
    }
    slab
}

/// The same diffusivity in all directions of the sheet and through it.
pub fn isotropic(mesh: &Mesh, thickness: f64, diffusivity: f64, levels: Vec<f64>) -> Slab {
    slab(mesh, thickness, [diffusivity; 3], Vector3::x(), levels)
}

pub fn uniform(layers: usize) -> Vec<f64> {
    (0..=layers).map(|l| l as f64 / layers as f64).collect()
}

/// A condition that is always in force.
pub fn always(place: Where, law: Law) -> Condition {
    Condition { place, law, window: [f64::NEG_INFINITY, f64::INFINITY], below: None }
}

pub fn constant(value: f64) -> Data {
    Box::new(move |_, _| value)
}

pub fn side(mesh: &Mesh, side: Side) -> Where {
    Where::Side { side, faces: (0..mesh.faces.len()).collect() }
}

/// Boundary edges whose ends both satisfy the condition.
pub fn rim(mesh: &Mesh, wanted: impl Fn(&Vector3<f64>) -> bool) -> Where {
    let topology = Topology::new(&mesh.faces);
    let boundary = (0..topology.edges.len()).filter(|e| topology.is_boundary(*e));
    let chosen = boundary.filter(|e| topology.edges[*e].iter().all(|v| wanted(&mesh.vertices[*v])));
    Where::Rim { edges: chosen.filter_map(|e| topology.edge_faces[e][0].map(|f| (f.face, f.local))).collect() }
}

/// Numbers in [0, 1).
pub fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| random.random()).collect()
}

/// Content that something entered has not explained [u m3].
pub fn missing(diffusion: &Diffusion, start: f64) -> f64 {
    let b = diffusion.balance();
    b.content - start - (b.top + b.bottom + b.rim + b.sources)
}

/// Slope of the logarithms of `values` over those of `sizes`, by least squares.
pub fn order(sizes: &[f64], values: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().map(|x| x.ln()).sum::<f64>() / x.len() as f64;
    let (mx, my) = (mean(sizes), mean(values));
    let product: f64 = sizes.iter().zip(values).map(|(x, y)| (x.ln() - mx) * (y.ln() - my)).sum();
    product / sizes.iter().map(|x| (x.ln() - mx).powi(2)).sum::<f64>()
}
