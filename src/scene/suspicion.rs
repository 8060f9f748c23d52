//! Values that are allowed but look like a slip of the unit.

use super::{MeshTable, Scene};

/// One sentence per value that is probably given in a wrong unit; empty for most scenes. Not errors.
pub fn suspicions(scene: &Scene) -> Vec<String> {
    let mut found = Vec::new();
    let size = mesh_size(&scene.mesh);
    let shell = &scene.shell;
    let thickness = (!shell.is_absent()).then_some(shell.thickness);
    let whole = ("shell".to_owned(), [thickness, shell.youngs_modulus, shell.density]);
    let parts = shell.regions.iter().enumerate();
    let parts = parts.map(|(i, part)| (format!("shell.region.{i}"), [part.thickness, part.youngs_modulus, part.density]));
    for (key, [thickness, modulus, density]) in std::iter::once(whole).chain(parts) {
        if let Some(thickness) = thickness {
            if size.is_none_or(|size| thickness > size / 20.0) && thickness > 0.1 {
                found.push(format!("{key}.thickness = {thickness} m is thick for a shell; is it in mm?"));
            } else if size.is_some_and(|size| thickness > size / 10.0) {
                found.push(format!("{key}.thickness = {thickness} m is more than a tenth of the mesh's smaller extent; are both in m?"));
            }
        }
        if let Some(modulus) = modulus.filter(|modulus| !(1e2..=1e13).contains(modulus)) {
            found.push(format!("{key}.youngs_modulus = {modulus:e} Pa is outside 1e2 to 1e13; is it in MPa or GPa?"));
        }
        if let Some(density) = density.filter(|density| !(1.0..=30_000.0).contains(density)) {
            found.push(format!("{key}.density = {density} kg/m3 is outside 1 to 30000; is it in g/cm3 or per area?"));
        }
    }
    let whole = ("shell".to_owned(), shell.orthotropic, shell.bilayer);
    let parts = shell.regions.iter().enumerate().map(|(i, part)| (format!("shell.region.{i}"), part.orthotropic, part.bilayer));
    for (key, orthotropic, bilayer) in std::iter::once(whole).chain(parts) {
        let fibres = orthotropic.map_or(Vec::new(), |o| o.youngs_moduli.to_vec());
        let layers = bilayer.map_or(Vec::new(), |b| [b.top, b.bottom].iter().filter_map(|layer| layer.youngs_modulus).collect());
        for (table, moduli) in [("orthotropic.youngs_moduli", fibres), ("bilayer", layers)] {
            found.extend(
                moduli
                    .iter()
                    .filter(|modulus| !(1e2..=1e13).contains(*modulus))
                    .map(|modulus| format!("{key}.{table} has a modulus of {modulus:e} Pa, outside 1e2 to 1e13; is it in MPa or GPa?")),
            );
        }
    }
    if let Some(size) = size.filter(|size| *size > 1e3) {
        found.push(format!("the mesh is {size} m across; is it in mm?"));
    }
    if let Some(dynamics) = scene.dynamics.as_ref().filter(|dynamics| dynamics.dt > dynamics.end) {
        found.push(format!("dynamics.dt = {} s is longer than the whole run of {} s", dynamics.dt, dynamics.end));
    }
    if let (Some(viscosity), Some(dynamics)) = (shell.viscosity, &scene.dynamics)
        && viscosity > dynamics.end
    {
        found.push(format!("shell.viscosity = {viscosity} s is longer than the whole run of {} s; is it in Pa s?", dynamics.end));
    }
    for (table, _, _, diffusion) in scene.diffusing() {
        // Moisture creeps; the best conductors of heat have 1e-4 m2/s.
        let most = if table == "heat" { 1e-3 } else { 1e-5 };
        let regions = diffusion.regions.iter().enumerate().map(|(i, region)| (format!("{table}.region.{i}"), region.diffusivity));
        for (key, d) in std::iter::once((table.to_owned(), diffusion.diffusivity)).chain(regions) {
            if let Some(d) = [d.through, d.along].into_iter().chain(d.across).find(|d| *d > most) {
                found.push(format!("{key}.diffusivity has a coefficient of {d:e} m2/s, above {most:e}; is it in mm2/s?"));
            }
        }
    }
    let rest = scene.rest.as_ref();
    if let Some(law) = rest.and_then(|rest| rest.thermal.as_ref()).filter(|law| law.expansion.abs() > 0.05) {
        found.push(format!("rest.thermal.expansion = {} changes lengths by {} % per kelvin", law.expansion, 100.0 * law.expansion));
    }
    let linear =
        rest.and_then(|rest| rest.linear.as_ref()).map(|law| ("linear", vec![law.mu], law.mu_perp.into_iter().collect::<Vec<_>>()));
    let bilayer =
        rest.and_then(|rest| rest.bilayer.as_ref()).map(|law| ("bilayer", law.mu.to_vec(), law.mu_perp.into_iter().flatten().collect()));
    for (law, mu, mu_perp) in linear.into_iter().chain(bilayer) {
        let along = mu.into_iter().map(|mu| ("mu", mu));
        for (key, mu) in along.chain(mu_perp.into_iter().map(|mu: f64| ("mu_perp", mu))).filter(|(_, mu)| mu.abs() > 0.05) {
            found.push(format!("rest.{law}.{key} = {mu} changes lengths by {} % per percent of moisture; is it per one?", 100.0 * mu));
        }
    }
    found
}

/// The smallest length of the surface that a generator says [m]; unknown for a file.
fn mesh_size(mesh: &MeshTable) -> Option<f64> {
    match mesh {
        MeshTable::Rectangle(table) => Some(table.size[0].min(table.size[1])),
        MeshTable::Disc(table) => Some(2.0 * table.radius),
        MeshTable::Annulus(table) => Some(table.radii[1] - table.radii[0]),
        MeshTable::Cylinder(table) => Some(table.length.min(table.radius * table.angle.to_radians())),
        MeshTable::SphereCap(table) => Some(2.0 * table.radius * table.half_angle.to_radians()),
        MeshTable::Outline(table) => table.points.as_ref().and_then(|points| {
            let extent = |axis: usize| {
                let values = points.iter().map(|point| point[axis]);
                values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
            };
            (0..2).map(extent).reduce(f64::min)
        }),
        MeshTable::Grid(table) => Some(table.size[0].min(table.size[1])),
        MeshTable::File(_) => None,
    }
}
