//! `check`: makes mesh and setup in memory and says which parts a scene has and how large it is. Writes no file.

use super::{Job, mesh as mesh_stage, print, setup};
use crate::error::Result;
use crate::scene::{MeshTable, Scene};

/// Prints the parts of the scene, one a line, and the numbers of vertices, faces and unknowns. The scene's own text was checked when the
/// job was read; this finds what only its mesh can tell.
///
/// # Errors
/// Those of the stages `mesh` and `setup`, except for files.
pub fn run(job: &Job) -> Result<()> {
    let (mesh, warnings) = mesh_stage::make(&job.scene, &job.scene_file)?;
    warnings.iter().for_each(|w| log::warn!("{w}"));
    let (setup, _) = setup::make(&job.scene, &mesh)?;
    let mut lines = parts(&job.scene);
    lines.push(("size", format!("{} vertices, {} faces", mesh.vertices.len(), mesh.faces.len())));
    lines.push(("unknowns", format!("{} free, {} held", setup.free_unknowns, setup.held.len())));
    let lines: Vec<String> = lines.into_iter().map(|(name, what)| format!("{name:<9} {what}")).collect();
    print(&lines.join("\n"))
}

/// Name and description of every part that the scene has.
fn parts(scene: &Scene) -> Vec<(&'static str, String)> {
    let shell = &scene.shell;
    let mut parts = vec![("mesh", mesh(&scene.mesh)), ("shell", format!("{} m, {:e} Pa", shell.thickness, shell.youngs_modulus))];
    if !scene.title.is_empty() {
        parts.insert(0, ("title", scene.title.clone()));
    }
    if let Some(rest) = &scene.rest {
        let law = if rest.pullback.is_some() {
            "pullback"
        } else if rest.linear.is_some() {
            "linear"
        } else {
            "initial shape"
        };
        parts.push(("rest", law.to_owned()));
    }
    if let Some(gravity) = &scene.gravity {
        let [x, y, z] = gravity.acceleration;
        parts.push(("gravity", format!("({x}, {y}, {z}) m/s2")));
    }
    parts.extend(scene.pins.iter().map(|pin| ("pin", pin.region.clone())));
    if let Some(statics) = &scene.statics {
        parts.push(("statics", format!("{} load steps", statics.steps)));
    }
    if let Some(dynamics) = &scene.dynamics {
        parts.push(("dynamics", format!("to {} s in steps of {} s", dynamics.end, dynamics.dt)));
    }
    if let Some(report) = &scene.report {
        parts.push((
            "report",
            format!("{} expectations{}", report.expectations.len(), if report.ladder.is_some() { ", ladder" } else { "" }),
        ));
    }
    parts
}

fn mesh(mesh: &MeshTable) -> String {
    match mesh {
        MeshTable::Rectangle(table) => format!("rectangle, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::Disc(table) => format!("disc, {} rings", table.rings),
        MeshTable::Annulus(table) => format!("annulus, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::Cylinder(table) => format!("cylinder, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::SphereCap(table) => format!("sphere cap, {} rings", table.rings),
        MeshTable::Outline(table) => format!("outline, {} corners, {} holes", table.points.len(), table.holes.len()),
        MeshTable::File(table) => format!("file {}", table.path.display()),
    }
}
