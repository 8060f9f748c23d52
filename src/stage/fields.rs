//! The fields of a state that are exported and reported: computed from a snapshot, never stored in checkpoints.

use super::build;
use super::setup::Setup;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::model::RestDriver;
use crate::scene::Scene;
use crate::shell::Shell;
use crate::shell::fields::at_point;
use crate::shell::rest::Forms;
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::{Matrix3, Vector3};

/// Computes fields of the snapshots of one case.
pub struct Fields<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    setup: &'a Setup,
    shell: Box<dyn Shell>,
    rest: Option<RestDriver>,
}

/// A state in space: vertex positions and fields.
pub struct State {
    /// Vertex positions [m].
    pub points: Vec<Vector3<f64>>,
    /// One entry per vertex.
    pub point_data: Vec<Field>,
    /// One entry per face.
    pub cell_data: Vec<Field>,
    /// Rest area of each face [m2].
    pub areas: Vec<f64>,
}

fn field(name: &str, association: Association, components: usize, unit: &str, data: Vec<f64>) -> Field {
    Field { name: name.into(), association, components, unit: unit.into(), data }
}

/// A symmetric tensor in VTK's order.
fn symmetric(m: &Matrix3<f64>) -> [f64; 6] {
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(0, 2)]]
}

impl<'a> Fields<'a> {
    /// Builds the shell and the rest driver that the fields are computed with.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, topology: &Topology, setup: &'a Setup) -> Result<Self> {
        Ok(Fields {
            scene,
            mesh,
            setup,
            shell: build::shell(scene, mesh, topology, setup),
            rest: build::rest(scene, mesh, topology, setup)?,
        })
    }

    /// All fields of a snapshot. Errors: a snapshot of another case.
    pub fn of(&mut self, snapshot: &Snapshot) -> Result<State> {
        let of = |name: &str, length: usize| -> Result<&[f64]> {
            let data = snapshot.field(name).map(|f| f.data.as_slice()).filter(|d| d.len() == length);
            data.ok_or_else(|| Error::input("checkpoint", format!("field '{name}' is missing or not of this mesh")))
        };
        let vertices = self.mesh.vertices.len();
        let x = of("position", 3 * vertices)?;
        let points: Vec<Vector3<f64>> = x.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
        let mut all = x.to_vec();
        all.resize(self.shell.unknowns(), 0.0);
        let count = self.shell.directors().len();
        if count > 0 {
            let directors: Vec<Vector3<f64>> = of("director", 3 * count)?.chunks_exact(3).map(|d| Vector3::new(d[0], d[1], d[2])).collect();
            self.shell.set_directors(&directors);
        }
        let rest = match &mut self.rest {
            Some(driver) => driver.forms(snapshot.time).map_err(|e| Error::input("rest", e))?,
            None => self.setup.initial_forms.clone(),
        };
        let point = |name: &str, n, unit: &str, data| field(name, Association::Node, n, unit, data);
        let displacement = points.iter().zip(&self.mesh.vertices).flat_map(|(p, q)| (p - q).data.0[0]).collect();
        let mut point_data = vec![point("displacement", 3, "m", displacement)];
        if let Some(velocity) = snapshot.field("velocity") {
            point_data.push(point("velocity", 3, "m/s", velocity.data.clone()));
        }
        if let Some([top, bottom]) = build::moisture(self.scene, self.mesh, snapshot.time)? {
            point_data.extend([point("moisture_top", 1, "%", top), point("moisture_bottom", 1, "%", bottom)]);
        }
        let (cell_data, areas) = self.cells(&points, &all, &rest);
        Ok(State { points, point_data, cell_data, areas })
    }

    /// Fields of the faces, and their rest areas.
    fn cells(&self, points: &[Vector3<f64>], x: &[f64], rest: &[Forms]) -> (Vec<Field>, Vec<f64>) {
        let forms = self.shell.forms(x);
        let per_face = self.shell.points();
        let mut columns: [Vec<f64>; 11] = Default::default();
        let mut directions = Vec::new();
        let mut areas = Vec::with_capacity(self.mesh.faces.len());
        for (f, face) in self.mesh.faces.iter().enumerate() {
            let [v0, v1, v2] = face.map(|v| points[v]);
            let r = [v1 - v0, v2 - v0];
            // Elements with several points show their mean.
            let mean = |all: &[[f64; 6]]| -> Forms {
                let m: [f64; 6] = std::array::from_fn(|i| all.iter().map(|e| e[i]).sum::<f64>() / all.len() as f64);
                Forms { a: [m[0], m[1], m[2]], b: [m[3], m[4], m[5]] }
            };
            let range = per_face * f..per_face * (f + 1);
            let rests: Vec<[f64; 6]> = rest[range.clone()].iter().map(|f| [f.a[0], f.a[1], f.a[2], f.b[0], f.b[1], f.b[2]]).collect();
            let (now, rest) = (mean(&forms[range]), mean(&rests));
            let material = &self.setup.materials[f];
            let p = at_point(&r, &now, &rest, material);
            areas.push(0.5 * (rest.a[0] * rest.a[2] - rest.a[1] * rest.a[1]).sqrt());
            let values: [&[f64]; 11] = [
                &p.principal_curvatures,
                p.principal_directions[0].as_slice(),
                p.principal_directions[1].as_slice(),
                &[p.mean_curvature],
                &[p.gauss_curvature],
                &symmetric(&p.membrane_strain),
                &symmetric(&p.membrane_stress),
                &symmetric(&p.bending_moment),
                &[p.membrane_energy_density],
                &[p.bending_energy_density],
                &[material.thickness],
            ];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.extend_from_slice(value));
            if let Some(d) = &self.setup.machine_direction {
                directions.extend_from_slice((r[0] * d[f][0] + r[1] * d[f][1]).normalize().as_slice());
            }
        }
        const NAMES: [(&str, usize, &str); 11] = [
            ("principal_curvatures", 2, "1/m"),
            ("principal_direction_1", 3, "1"),
            ("principal_direction_2", 3, "1"),
            ("mean_curvature", 1, "1/m"),
            ("gauss_curvature", 1, "1/m2"),
            ("membrane_strain", 6, "1"),
            ("membrane_stress", 6, "Pa"),
            ("bending_moment", 6, "N"),
            ("membrane_energy_density", 1, "J/m2"),
            ("bending_energy_density", 1, "J/m2"),
            ("thickness", 1, "m"),
        ];
        let mut cells: Vec<Field> =
            NAMES.iter().zip(columns).map(|((name, n, unit), data)| field(name, Association::Face, *n, unit, data)).collect();
        if !directions.is_empty() {
            cells.push(field("machine_direction", Association::Face, 3, "1", directions));
        }
        (cells, areas)
    }
}
