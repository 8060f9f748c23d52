//! Surfaces on grids: what `mesh`, `setup` and `run` make of `[mesh.grid]` and `[cosserat]`.

use super::build::{expression, held_unknowns, place_values};
use super::setup::{self, Setup};
use super::stepping::Stepping;
use super::{loads, run, supports, velocity};
use crate::cosserat::{Border, Constants, CosseratSurface, Divergence, Elasticity, Grid, StrongForm};
use crate::error::{Error, Result};
use crate::load::{AlongNormals, Drag, NormalLoad};
use crate::mesh::{Mesh, Topology, generate};
use crate::model::{AppliedLoad, GridModel, GridParts, Model, RoundTable, Strong, node_shares, quadrangles};
use crate::scene::{self, Cosserat, GridScheme, Scene};
use crate::shell::Inertia;
use crate::snapshot::Snapshot;
use nalgebra::Vector3;

/// The mesh of a grid. Errors: a place that is not finite.
pub fn mesh(table: &scene::Grid) -> Result<Mesh> {
    let Some(texts) = &table.position else {
        return generate::surface_grid(table.nodes, table.size, |x, y| Vector3::new(x, y, 0.0));
    };
    let mut parsed = Vec::new();
    for (i, text) in texts.iter().enumerate() {
        parsed.push(expression(&format!("mesh.grid.position.{i}"), text, scene::PLANE)?);
    }
    let mesh = generate::surface_grid(table.nodes, table.size, |x, y| {
        let values = place_values(scene::PLANE, &Vector3::new(x, y, 0.0), 0.0);
        Vector3::from_iterator(parsed.iter().map(|e| e.eval(&values)))
    })?;
    for (node, p) in mesh.vertices.iter().enumerate() {
        if let Some(i) = (0..3).find(|i| !p[*i].is_finite()) {
            let (row, column) = (node / table.nodes[1], node % table.nodes[1]);
            return Err(Error::input(format!("mesh.grid.position.{i}"), format!("is {} at node ({row}, {column})", p[i])));
        }
    }
    Ok(mesh)
}

/// The two tables of a surface on a grid.
fn tables(scene: &Scene) -> Result<(&Cosserat, &scene::Grid)> {
    scene.cosserat.as_ref().zip(scene.mesh.grid()).ok_or_else(|| Error::input("cosserat", "needs [mesh.grid]"))
}

/// Nodes and spacing.
pub fn grid(scene: &Scene) -> Result<Grid> {
    let (_, table) = tables(scene)?;
    Ok(Grid { nodes: table.nodes, spacing: [0, 1].map(|k| table.size[k] / (table.nodes[k] - 1) as f64) })
}

/// Constants and the law that they belong to.
fn elasticity(scene: &Scene) -> Result<Elasticity> {
    let (table, _) = tables(scene)?;
    let constants = Constants { eta: table.eta.components(), xi: table.xi.components(), phi: table.phi.components() };
    Ok(match scene.model {
        scene::Model::Terzopoulos => Elasticity::Terzopoulos(constants),
        _ => Elasticity::Cosserat { constants, mixed: table.mixed_terms },
    })
}

/// The energy of the surface.
pub fn surface(scene: &Scene, mesh: &Mesh) -> Result<CosseratSurface> {
    CosseratSurface::new(grid(scene)?, &mesh.vertices, &elasticity(scene)?).map_err(|e| Error::input("cosserat", e))
}

/// The finite differences of the paper.
fn strong_form(scene: &Scene, mesh: &Mesh, areas: &[f64]) -> Result<StrongForm> {
    let (table, _) = tables(scene)?;
    let border = match table.border {
        scene::GridBorder::Paper => Border::Paper,
        scene::GridBorder::Symmetric => Border::Symmetric,
    };
    let divergence = match table.divergence {
        scene::Divergence::AsPrinted => Divergence::AsPrinted,
        scene::Divergence::Conservative => Divergence::Conservative,
    };
    Ok(StrongForm::new(grid(scene)?, &mesh.vertices, areas.to_vec(), elasticity(scene)?, border, divergence))
}

/// The whole model at its start.
pub fn model(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<GridModel> {
    let (table, _) = tables(scene)?;
    let grid = grid(scene)?;
    let (cells, count) = (quadrangles(&grid), mesh.vertices.len());
    let x: Vec<f64> = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    // Mass and damping are spread evenly over the surface.
    let shares = node_shares(&cells, &x);
    let area: f64 = shares.iter().sum();
    let spread = |total: f64| -> Vec<f64> { shares.iter().map(|share| total * share / area).collect() };
    let masses = table.mass.map(spread);
    let held = held_unknowns(scene, mesh, topology, setup)?;
    let mut loads = loads::build(scene, mesh, topology, &[], masses.as_deref().unwrap_or(&[]), &held)?;
    let mut along = |key: String, kind, factor: &Option<scene::Expr>| -> Result<()> {
        let potential = Box::new(NormalLoad::new(cells.clone(), count, kind));
        let factor = loads::load_factor(scene, &key, factor)?;
        loads.push(AppliedLoad { key, energy_name: None, potential, factor });
        Ok(())
    };
    if let Some(stream) = &table.stream {
        let kind = AlongNormals::Stream { coefficient: stream.coefficient, velocity: Vector3::from(stream.velocity) };
        along("cosserat.stream.factor".into(), kind, &stream.factor)?;
    }
    for (i, load) in table.normal_forces.iter().enumerate() {
        let key = format!("cosserat.normal-force.{i}");
        let nodes = setup::region(mesh, &format!("{key}.region"), &load.region)?.vertices.clone();
        if nodes.is_empty() {
            return Err(Error::input(format!("{key}.region"), format!("region '{}' has no vertices that could be loaded", load.region)));
        }
        along(format!("{key}.factor"), AlongNormals::Force { nodes, force: load.force }, &load.factor)?;
    }
    let strong = match table.scheme {
        GridScheme::Variational => None,
        GridScheme::StrongForm => {
            let damping = table.damping.map_or(vec![0.0; count], spread);
            let masses = masses.clone().unwrap_or_default();
            Some(Strong::new(strong_form(scene, mesh, &shares)?, masses, damping, shares.clone()))
        }
    };
    let inertia = masses.filter(|_| scene.dynamics.is_some()).map(|masses| {
        let matrices = masses.iter().map(|mass| [[*mass]]).collect();
        Box::new(Inertia::<1, 3>::new((0..count).map(|n| [n]).collect(), matrices)) as Box<dyn crate::shell::Inertial>
    });
    let parts = GridParts {
        surface: surface(scene, mesh)?,
        grid,
        inertia,
        drag: table.damping.filter(|_| strong.is_none()).map(|total| Drag::new(spread(total))),
        strong,
        loads,
        velocities: velocity::initial(scene, &held, &mesh.vertices)?,
        held,
        positions: mesh.vertices.clone(),
        table: table.table.as_ref().map(|t| RoundTable { centre: Vector3::from(t.centre), radius: t.radius }),
    };
    GridModel::new(parts, mesh.diameter(), scene.solver.tolerance, scene.solver.max_iterations)
}

/// What `setup.h5` keeps of a surface on a grid, and its first state.
pub fn setup(scene: &Scene, mesh: &Mesh) -> Result<(Setup, Snapshot)> {
    let topology = Topology::new(&mesh.faces);
    let mut setup = Setup { held: supports::find(scene, mesh, &topology)?.0, ..Setup::default() };
    let model = model(scene, mesh, &topology, &setup)?;
    setup::check_prescribed(scene, &model)?;
    Stepping::new(scene, mesh)?;
    super::report::check_measures(scene, mesh, &run::columns(scene, &model))?;
    setup.free_unknowns = model.free_unknowns();
    Ok((setup, model.snapshot()))
}

/// The surface in words, for `check`.
pub fn describe(table: &Cosserat) -> String {
    let scheme = match table.scheme {
        GridScheme::Variational => "variational",
        GridScheme::StrongForm => "strong form",
    };
    let [eta, xi, phi] = [table.eta, table.xi, table.phi].map(|c| match c {
        scene::Constant::One(value) => value.to_string(),
        scene::Constant::Three(values) => format!("{values:?}"),
    });
    let mass = table.mass.map_or(String::new(), |mass| format!(", {mass} kg"));
    let damping = table.damping.map_or(String::new(), |damping| format!(", damping {damping} kg/s"));
    let parts = [
        ("mixed terms", table.mixed_terms),
        ("stream", table.stream.is_some()),
        ("table", table.table.is_some()),
        ("normal forces", !table.normal_forces.is_empty()),
    ];
    let parts: String = parts.iter().filter(|(_, there)| *there).map(|(name, _)| format!(", {name}")).collect();
    format!("{scheme}, eta {eta} N/m, xi {xi} N m, phi {phi} N{mass}{damping}{parts}")
}
