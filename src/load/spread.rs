//! Dead forces that are spread over a surface: per initial area or per volume, as fields of the initial place and of time.

use super::{DeadLoad, VectorField, not_finite};
use crate::sparse::{Curvature, Numbering, Pattern, Potential, System};
use nalgebra::Vector3;

/// A quadrature point of a loaded surface in its initial shape.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePiece {
    /// Its place [m].
    pub place: Vector3<f64>,
    /// Nodes, and the area (or volume) that each of them carries: weight times shape function times size [m2 or m3].
    pub shares: Vec<(usize, f64)>,
}

/// `-factor int f(X, t).x`, `f` a force per area or volume at the initial place `X`, by quadrature.
pub struct SpreadLoad {
    pieces: Vec<SurfacePiece>,
    field: VectorField,
    /// Whether the field depends on time.
    changes: bool,
    time: Option<f64>,
    /// Place in the list of nodal forces of each share, piece by piece.
    slots: Vec<usize>,
    nodal: DeadLoad,
}

impl SpreadLoad {
    /// `field`: force per area [N/m2] or volume [N/m3]. `changes`: whether it depends on time. The forces are those of time 0.
    pub fn new(pieces: Vec<SurfacePiece>, field: VectorField, changes: bool) -> Self {
        let mut nodes: Vec<usize> = pieces.iter().flat_map(|piece| piece.shares.iter().map(|(node, _)| *node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let slots = pieces.iter().flat_map(|piece| piece.shares.iter().map(|(node, _)| nodes.partition_point(|n| n < node))).collect();
        let nodal = DeadLoad::new(nodes.into_iter().map(|node| (node, Vector3::zeros())).collect());
        let mut load = SpreadLoad { pieces, field, changes, time: None, slots, nodal };
        load.integrate(0.0);
        load
    }

    fn integrate(&mut self, time: f64) {
        let mut forces = vec![Vector3::zeros(); self.nodal.len()];
        let mut slots = self.slots.iter();
        for piece in &self.pieces {
            let force = (self.field)(&piece.place, time);
            for ((_, share), slot) in piece.shares.iter().zip(&mut slots) {
                forces[*slot] += force * *share;
            }
        }
        self.nodal.set_forces(forces);
        self.time = Some(time);
    }
}

impl super::Load for SpreadLoad {
    fn set_factor(&mut self, factor: f64) {
        self.nodal.set_factor(factor);
    }

    fn set_time(&mut self, time: f64) {
        if self.changes && self.time != Some(time) {
            self.integrate(time);
        }
    }

    fn fault(&self, time: f64, _factor: f64) -> Option<(&'static str, String)> {
        let places = self.pieces.iter().map(|piece| &piece.place);
        not_finite(places, time, |p| (self.field)(p, time).sum()).map(|reason| ("force", reason))
    }
}

impl Potential for SpreadLoad {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        self.nodal.stencils(visit);
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.nodal.bind(numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        self.nodal.energy(x)
    }

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        self.nodal.assemble(x, curvature, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        self.nodal.gradient(x, into)
    }
}
