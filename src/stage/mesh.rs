//! `mesh`: generates or reads the mesh, names its regions, judges its quality (`mesh.h5`).

use super::Job;
use super::build::{expression, place_values};
use crate::case::{Archive, Folder, Kind, hash, mesh_from_archive, mesh_to_archive};
use crate::error::{Error, Result};
use crate::mesh::conformal::{self, Onto};
use crate::mesh::midpoints::{self, Surface};
use crate::mesh::{FieldOn, Mesh, MeshField, Quality, generate, import, refine, validate};
use crate::scene::{self, MeshTable, Pattern, Scene};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The stage.
///
/// # Errors
/// A mesh that cannot be made or used, a region without anything in it, a file that cannot be written.
pub fn run(job: &Job) -> Result<()> {
    let (mesh, warnings) = make(&job.scene, &job.scene_file)?;
    warnings.iter().for_each(|w| log::warn!("{w}"));
    let quality = Quality::of(&mesh);
    let _lock = Folder::new(&job.case, "").lock()?;
    mesh_to_archive(&mesh, numbers(&quality), &inputs(job)?).write(&path(job))?;
    job.record()?;
    if !job.quiet {
        super::print(&quality.to_string())?;
    }
    job.say(&path(job).display().to_string());
    Ok(())
}

/// Path of the stage's file.
pub fn path(job: &Job) -> PathBuf {
    job.case.join("mesh.h5")
}

/// Hash of what the stage's file is made from: its tables and the mesh file, if there is one.
pub fn inputs(job: &Job) -> Result<String> {
    let regions = serde_json::to_string(&(&job.scene.regions, job.scene.shell.element, &job.scene.refine, &job.scene.flatten))
        .map_err(|e| Error::input("scene", e.to_string()))?;
    let key = if matches!(job.scene.mesh, MeshTable::Outline(_)) { "mesh.outline.file" } else { "mesh.file.path" };
    let mesh = of_table(&job.scene.mesh, &job.scene_file).map_err(|e| at_file(key, e))?;
    let shape = match job.scene.rest.as_ref().and_then(|rest| rest.shape.as_ref()) {
        Some(scene::Shape::File(table)) => {
            of_table(&MeshTable::File(table.clone()), &job.scene_file).map_err(|e| at_file("rest.shape.file.path", e))?
        }
        _ => String::new(),
    };
    Ok(hash::of(&[mesh.as_bytes(), regions.as_bytes(), shape.as_bytes()]))
}

/// What a mesh counts by: its table and what is in its file, if it has one, not where that is.
fn of_table(table: &MeshTable, scene_file: &Path) -> Result<String> {
    let contents = table.file().map(|file| hash::file(&beside(scene_file, file))).transpose()?;
    let mut table = table.clone();
    if let Some(file) = table.file_mut() {
        file.clear();
    }
    let table = serde_json::to_string(&table).map_err(|e| Error::input("scene", e.to_string()))?;
    Ok(table + &contents.unwrap_or_default())
}

/// Reads what the stage wrote. Errors: a file that is missing, damaged or stale.
pub fn load(job: &Job) -> Result<Mesh> {
    let path = path(job);
    mesh_from_archive(&Archive::read_for(&path, Kind::Mesh, &inputs(job)?)?, &path)
}

/// The quality summary as named numbers.
fn numbers(q: &Quality) -> BTreeMap<String, f64> {
    let named = [
        ("vertices", q.vertices as f64),
        ("faces", q.faces as f64),
        ("edges", q.edges as f64),
        ("boundary_loops", q.boundary_loops as f64),
        ("components", q.components as f64),
        ("euler_characteristic", q.euler_characteristic as f64),
        ("smallest_edge_m", q.edge_length[0]),
        ("mean_edge_m", q.edge_length[1]),
        ("largest_edge_m", q.edge_length[2]),
        ("area_m2", q.total_area),
        ("smallest_angle_deg", q.angle[0]),
        ("largest_angle_deg", q.angle[1]),
        ("worst_aspect_ratio", q.worst_aspect_ratio),
    ];
    named.into_iter().map(|(name, value)| (format!("quality_{name}"), value)).collect()
}

/// A path of a scene, which is relative to the scene's folder.
fn beside(scene_file: &Path, path: &Path) -> PathBuf {
    scene_file.parent().unwrap_or(Path::new("")).join(path)
}

/// The surface on which the midpoints of the edges lie, unless a file brings them.
fn surface(table: &MeshTable) -> Surface {
    match table {
        MeshTable::File(t) => of_file(t),
        MeshTable::Rectangle(_) | MeshTable::Outline(_) | MeshTable::Grid(_) => Surface::Plane,
        MeshTable::Disc(t) => Surface::Disc { radius: t.radius },
        MeshTable::Annulus(_) => Surface::Annulus,
        MeshTable::Cylinder(t) => Surface::Cylinder { radius: t.radius },
        MeshTable::SphereCap(t) => Surface::Sphere { radius: t.radius },
    }
}

fn of_file(table: &scene::MeshFile) -> Surface {
    match table.midpoints {
        scene::Midpoints::Straight => Surface::Plane,
        scene::Midpoints::Smooth => Surface::Smooth,
    }
}

/// Splits the faces of a mesh as often as the scene says.
fn refined(mesh: &mut Mesh, table: Option<scene::Refine>, surface: Surface, place: &str) -> Result<()> {
    let Some(table) = table else { return Ok(()) };
    refine(mesh, table.times, surface)?;
    validate::check(mesh, place).map(|_| ())
}

/// Refuses a place that is farther from its vertex than half the mesh is large: a slip of the unit or of the place.
///
/// # Errors
/// The distance, in words.
pub fn near(mesh: &Mesh, vertex: usize, place: &Vector3<f64>) -> Result<(), String> {
    let (distance, size) = ((mesh.vertices[vertex] - place).norm(), mesh.diameter());
    if distance <= 0.5 * size {
        return Ok(());
    }
    let (x, y, z) = (place.x, place.y, place.z);
    Err(format!("the vertex nearest to ({x}, {y}, {z}) m is {distance:.3e} m away from it, on a mesh of {size:.3e} m"))
}

/// The field that holds the nodes of the rest shape, where a file gives it.
pub const REST_SHAPE: &str = "rest_shape";

/// Positions of the nodes in another mesh file with the same faces.
fn other_shape(path: &Path, table: &scene::MeshFile, splits: Option<scene::Refine>, mesh: &Mesh) -> Result<MeshField> {
    let place = path.display().to_string();
    let (mut other, _) = import::read(path, table.scale)?;
    validate::check(&mut other, &place)?;
    refined(&mut other, splits, of_file(table), &place)?;
    if other.faces != mesh.faces {
        let differs = other.faces.iter().zip(&mesh.faces).position(|(a, b)| a != b);
        let what = differs.map_or(format!("it has {} faces", other.faces.len()), |f| format!("face {f} has other vertices"));
        return Err(Error::input(place, format!("its faces are not those of the mesh, which has {} faces: {what}", mesh.faces.len())));
    }
    if mesh.midpoints.is_empty() {
        other.drop_midpoints();
    } else if other.midpoints.is_empty() {
        midpoints::place(&mut other, of_file(table));
    }
    let data: Vec<f64> = other.nodes().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    if data.len() != 3 * mesh.nodes().len() {
        return Err(Error::input(place, format!("it has {} vertices, the mesh {}", other.vertices.len(), mesh.vertices.len())));
    }
    Ok(MeshField { on: FieldOn::Nodes, components: 3, data })
}

/// An error about a file as one about the key of the scene that names it.
fn at_file(key: &str, error: Error) -> Error {
    match error {
        Error::Input { place, message, help } => Error::Input { place: key.into(), message: format!("{place}: {message}"), help },
        Error::Io { .. } => Error::input(key, error.to_string()),
        other => other,
    }
}

/// Whether all vertices lie in one plane, but for round-off.
fn is_plane(mesh: &Mesh) -> bool {
    let origin = mesh.vertices[0];
    let normal: Vector3<f64> = mesh
        .faces
        .iter()
        .map(|f| (mesh.vertices[f[1]] - mesh.vertices[f[0]]).cross(&(mesh.vertices[f[2]] - mesh.vertices[f[0]])))
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
        .map_or_else(Vector3::z, |n| n.normalize());
    mesh.vertices.iter().all(|p| (p - origin).dot(&normal).abs() <= 1e-6 * mesh.diameter())
}

/// Makes the mesh with all its regions, and warnings about it.
pub fn make(scene: &Scene, scene_file: &Path) -> Result<(Mesh, Vec<String>)> {
    let mut warnings = Vec::new();
    let pattern = |p: Pattern| match p {
        Pattern::Diagonal | Pattern::Delaunay => generate::Pattern::Diagonal,
        Pattern::Alternating => generate::Pattern::Alternating,
        Pattern::CrissCross => generate::Pattern::CrissCross,
    };
    let triangulation = |t: &scene::Triangulation| generate::Triangulation { size: t.size, min_angle: t.min_angle };
    let place;
    let mut mesh = match &scene.mesh {
        MeshTable::Rectangle(t) => {
            place = "mesh.rectangle".to_owned();
            if t.pattern == Pattern::Delaunay {
                generate::rectangle_delaunay(t.size, t.cells, t.triangulation.as_ref().map(triangulation), t.seed)?
            } else {
                generate::rectangle(t.size, t.cells, pattern(t.pattern), t.jitter, t.seed)?
            }
        }
        MeshTable::Disc(t) => {
            place = "mesh.disc".to_owned();
            generate::disc(t.radius, t.rings)?
        }
        MeshTable::Annulus(t) => {
            place = "mesh.annulus".to_owned();
            generate::annulus(t.radii, t.cells, t.slit, pattern(t.pattern))?
        }
        MeshTable::Cylinder(t) => {
            place = "mesh.cylinder".to_owned();
            generate::cylinder(t.radius, t.length, t.angle, t.cells, pattern(t.pattern))?
        }
        MeshTable::SphereCap(t) => {
            place = "mesh.sphere-cap".to_owned();
            generate::sphere_cap(t.radius, t.half_angle, t.rings)?
        }
        MeshTable::Outline(t) => {
            let (key, points) = match (&t.file, &t.points) {
                (Some(file), _) => {
                    let path = beside(scene_file, file);
                    (path.display().to_string(), import::read_outline(&path).map_err(|e| at_file("mesh.outline.file", e))?)
                }
                (None, points) => ("mesh.outline.points".to_owned(), points.clone().unwrap_or_default()),
            };
            place = "mesh.outline".to_owned();
            generate::outline(&key, &points, &t.holes, triangulation(&t.triangulation))?
        }
        MeshTable::Grid(t) => {
            place = "mesh.grid".to_owned();
            super::grid::mesh(t)?
        }
        MeshTable::File(t) => {
            place = "mesh.file.path".to_owned();
            let (mesh, noted) = import::read(&beside(scene_file, &t.path), t.scale).map_err(|e| at_file(&place, e))?;
            warnings.extend(noted);
            let (size, thickness) = (mesh.diameter(), scene.shell.thickness);
            // Larger than a house and thinner than 1e-4 of its size.
            if t.scale == 1.0 && size > 10.0 && thickness < 1e-4 * size {
                warnings.push(format!(
                    "mesh.file: the mesh is {size:.4} m across and the shell {thickness} m thick; is the mesh in mm? mesh.file.scale = 1e-3"
                ));
            }
            mesh
        }
    };
    warnings.extend(validate::check(&mut mesh, &place)?);
    let surface = surface(&scene.mesh);
    refined(&mut mesh, scene.refine, surface, &place)?;
    if scene.shell.element == scene::Element::Quadratic {
        if mesh.midpoints.is_empty() {
            midpoints::place(&mut mesh, surface);
            validate::check(&mut mesh, &place)?;
            if matches!((&scene.mesh, surface), (MeshTable::File(_), Surface::Plane)) && scene.flatten.is_none() && !is_plane(&mesh) {
                warnings.push(format!(
                    "{place}: its faces are flat, so a curved shell has kinks between them; mesh.file.midpoints = \"smooth\" rounds them"
                ));
            }
        }
    } else if !mesh.midpoints.is_empty() {
        warnings.push("the linear element leaves out the midpoints of the mesh's edges".into());
        mesh.drop_midpoints();
    }
    if let Some(table) = &scene.flatten {
        let radius = || table.radius.unwrap_or_else(|| (Quality::of(&mesh).total_area / std::f64::consts::PI).sqrt());
        let onto = match table.onto {
            scene::FlattenOnto::Natural => Onto::Natural,
            scene::FlattenOnto::Disc => Onto::Disc { radius: radius() },
        };
        let slivers = if onto == Onto::Natural { Vec::new() } else { conformal::corner_faces(&mesh) };
        if let Some(first) = slivers.first() {
            warnings.push(format!(
                "flatten: {} faces have two sides on the boundary and become slivers on a disc, first face {first}; divide them from the corner",
                slivers.len()
            ));
        }
        mesh.flatten(onto)?;
        warnings.extend(validate::check(&mut mesh, "flatten")?);
    }
    if let Some(scene::Shape::File(table)) = scene.rest.as_ref().and_then(|rest| rest.shape.as_ref()) {
        let path = beside(scene_file, &table.path);
        let shape = other_shape(&path, table, scene.refine, &mesh).map_err(|e| at_file("rest.shape.file.path", e))?;
        if mesh.fields.insert(REST_SHAPE.to_owned(), shape).is_some() {
            return Err(Error::input("rest.shape.file", format!("the mesh file has a field '{REST_SHAPE}' already")));
        }
    }
    for (i, table) in scene.regions.iter().enumerate() {
        let key = format!("region.{i}");
        if mesh.regions.contains_key(&table.name) {
            return Err(Error::input(format!("{key}.name"), format!("the mesh has a region '{}' already", table.name)));
        }
        let region = match (&table.condition, &table.nearest) {
            (Some(condition), _) => {
                let condition = expression(&format!("{key}.where"), condition, scene::PLACE)?;
                // Not a number is neither true nor false, and would count as true.
                let unclear = std::cell::Cell::new(None);
                let region = mesh.region_where(|p| {
                    let value = condition.eval(&place_values(scene::PLACE, &p, 0.0));
                    if value.is_nan() {
                        unclear.set(Some(p));
                    }
                    value != 0.0
                });
                if let Some(p) = unclear.get() {
                    return Err(Error::input(format!("{key}.where"), format!("is not a number at ({}, {}, {}) m", p.x, p.y, p.z)));
                }
                region
            }
            (None, Some(point)) => {
                let point = Vector3::from(*point);
                let region = mesh.region_nearest(point);
                for vertex in &region.vertices {
                    near(&mesh, *vertex, &point).map_err(|e| Error::input(format!("{key}.nearest"), e))?;
                }
                region
            }
            (None, None) => continue,
        };
        if region.vertices.is_empty() && region.faces.is_empty() {
            return Err(Error::input(
                format!("{key}.where"),
                format!("region '{}' is empty: no vertex and no face meets the condition", table.name),
            ));
        }
        mesh.regions.insert(table.name.clone(), region);
    }
    if scene.shell.director == scene::Director::Average && Quality::of(&mesh).is_irregular() {
        warnings.push("director = \"average\" does not converge on irregular meshes: curvatures come out 10 to 20 % wrong however fine the mesh; use \"free-tan\"".into());
    }
    Ok((mesh, warnings))
}
