//! The fields of a surface on a grid that are exported and reported, and the choice between them and those of a shell.
//!
//! All belong to the nodes. Tensors are by material coordinates, components 11, 12, 22; derivatives are central differences whatever the scheme.

use super::fields::{Fields, State};
use super::grid;
use super::setup::Setup;
use crate::cosserat::geometry::{gauss_curvature, mean_curvature};
use crate::cosserat::{CosseratSurface, Grid};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::model::quadrangles;
use crate::scene::Scene;
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::Vector3;

/// Name, components and unit of the fields that every surface on a grid has.
const NAMES: [(&str, usize, &str); 5] =
    [("normal", 3, "1"), ("mean_curvature", 1, "1/m"), ("gauss_curvature", 1, "1/m2"), ("strain", 3, "1"), ("curvature_change", 3, "1/m")];

/// Names and numbers of components of the fields that a scene has.
pub fn names(scene: &Scene) -> Vec<(&'static str, usize)> {
    let mut names = vec![("displacement", 3)];
    names.extend(scene.dynamics.as_ref().map(|_| ("velocity", 3)));
    names.extend(scene.cosserat.as_ref().and_then(|table| table.table.as_ref()).map(|_| ("stuck", 1)));
    names.extend(NAMES.iter().map(|(name, n, _)| (*name, *n)));
    names
}

/// Computes fields of the snapshots of one case on a grid.
pub struct GridFields<'a> {
    mesh: &'a Mesh,
    grid: Grid,
    surface: CosseratSurface,
}

impl<'a> GridFields<'a> {
    /// Builds the energy that fields are computed with.
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Result<Self> {
        Ok(GridFields { mesh, grid: grid::grid(scene)?, surface: grid::surface(scene, mesh)? })
    }

    /// Corners around of every cell.
    pub fn quadrangles(&self) -> Vec<[usize; 4]> {
        quadrangles(&self.grid)
    }

    fn positions<'s>(&self, snapshot: &'s Snapshot) -> Result<&'s [f64]> {
        let data = snapshot.field("position").map(|f| f.data.as_slice()).filter(|d| d.len() == 3 * self.mesh.vertices.len());
        data.ok_or_else(|| Error::input("checkpoint", "field 'position' is missing or not of this mesh"))
    }

    fn of(&self, snapshot: &Snapshot) -> Result<State> {
        let points: Vec<Vector3<f64>> = self.positions(snapshot)?.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
        let field = |name: &str, components, unit: &str, data: Vec<f64>| Field {
            name: name.into(),
            association: Association::Node,
            components,
            unit: unit.into(),
            data,
        };
        let displacement = points.iter().zip(&self.mesh.vertices).flat_map(|(p, q)| (p - q).data.0[0]).collect();
        let mut point_data = vec![field("displacement", 3, "m", displacement)];
        for (name, components, unit) in [("velocity", 3, "m/s"), ("stuck", 1, "1")] {
            point_data.extend(snapshot.field(name).map(|f| field(name, components, unit, f.data.clone())));
        }
        let mut columns: [Vec<f64>; 5] = Default::default();
        for node in 0..points.len() {
            let [now, rest] = [&points, &self.mesh.vertices].map(|r| self.grid.derivatives(r, node));
            let (g, n) = (now.metric(), now.normal());
            let b = now.curvature(&n);
            let (g0, b0) = (rest.metric(), rest.curvature(&rest.normal()));
            columns[0].extend(n.iter());
            columns[1].push(mean_curvature(&g, &b));
            columns[2].push(gauss_curvature(&g, &b));
            columns[3].extend((0..3).map(|c| 0.5 * (g[c] - g0[c])));
            columns[4].extend((0..3).map(|c| b0[c] - b[c]));
        }
        point_data.extend(NAMES.iter().zip(columns).map(|((name, n, unit), data)| field(name, *n, unit, data)));
        let areas = self.mesh.faces.iter().map(|f| {
            let [a, b, c] = f.map(|v| self.mesh.vertices[v]);
            0.5 * (b - a).cross(&(c - a)).norm()
        });
        Ok(State { areas: areas.collect(), points, point_data, cell_data: Vec::new() })
    }
}

/// What computes the fields of a case.
pub enum Shown<'a> {
    /// Of a shell.
    Shell(Box<Fields<'a>>),
    /// Of a surface on a grid.
    Grid(Box<GridFields<'a>>),
}

impl<'a> Shown<'a> {
    /// Those of the scene's model.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, topology: &'a Topology, setup: &'a Setup) -> Result<Self> {
        if scene.cosserat.is_some() {
            return Ok(Shown::Grid(Box::new(GridFields::new(scene, mesh)?)));
        }
        Ok(Shown::Shell(Box::new(Fields::new(scene, mesh, topology, setup)?)))
    }

    /// All fields of a snapshot. Errors: a snapshot of another case.
    pub fn of(&mut self, snapshot: &Snapshot) -> Result<State> {
        match self {
            Shown::Shell(fields) => fields.of(snapshot),
            Shown::Grid(fields) => fields.of(snapshot),
        }
    }

    /// Membrane and bending energy [J] of a snapshot's shape in the rest forms of another one; energy of both together counts as bending.
    pub fn energies(&mut self, shape: &Snapshot, state: &Snapshot) -> Result<[f64; 2]> {
        match self {
            Shown::Shell(fields) => fields.energies(shape, state),
            Shown::Grid(fields) => {
                let [membrane, bending, coupling] = fields.surface.energies(fields.positions(shape)?);
                Ok([membrane, bending + coupling])
            }
        }
    }
}
