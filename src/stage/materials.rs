//! What each face is made of: from the scene's tables to [`Material`] and [`Constitution`], and to the rows that `setup.h5` keeps of the latter.

use super::setup::{Setup, region};
use crate::case::Array;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::scene::{self, Composition, Lame, Scene};
use crate::shell::{Bilayer, Constitution, Material, Orthotropic};

/// Share of the membrane's stiffness that a tension field leaves in compression, by default.
const COMPRESSION: f64 = 1e-3;

/// Sets materials, laws and densities of all faces. The machine direction must be set before.
///
/// # Errors
/// Regions that do not exist or have no faces; regions that overlap so that what holds on a face does not go together; an orthotropic
/// material without a machine direction.
pub fn set(setup: &mut Setup, scene: &Scene, mesh: &Mesh) -> Result<()> {
    let shell = &scene.shell;
    // What holds on each face, as a number in the list of all that there is, with the last region that said something about it.
    let mut made = vec![(Composition::of(shell), "shell".to_owned(), String::new())];
    let mut of_face = vec![0; mesh.faces.len()];
    setup.densities = shell.density.map_or(Vec::new(), |rho| vec![rho; mesh.faces.len()]);
    for (i, table) in shell.regions.iter().enumerate() {
        let key = format!("shell.region.{i}");
        let place = format!("{key}.region");
        let faces = &region(mesh, &place, &table.region)?.faces;
        if faces.is_empty() {
            return Err(Error::input(place, format!("region '{}' has no faces", table.region)));
        }
        let mut changed = vec![None; made.len()];
        for &f in faces {
            let before = of_face[f];
            of_face[f] = match changed[before] {
                Some(after) => after,
                None => {
                    made.push((made[before].0.within(table), key.clone(), format!(" (region '{}')", table.region)));
                    *changed[before].insert(made.len() - 1)
                }
            };
            if let (Some(rho), Some(to)) = (table.density, setup.densities.get_mut(f)) {
                *to = rho;
            }
        }
    }
    let mut used = vec![false; made.len()];
    of_face.iter().for_each(|n| used[*n] = true);
    for ((composition, key, place), _) in made.iter().zip(&used).filter(|(_, used)| **used) {
        composition.check().map_err(|(name, message)| Error::input(format!("{key}.{name}"), format!("{message}{place}")))?;
        if composition.orthotropic.is_some() && setup.machine_direction.is_none() {
            return Err(Error::input(format!("{key}.orthotropic"), format!("needs a machine direction, and the scene has none{place}")));
        }
        if composition.lame == Some(Lame::ThreeD) {
            log::warn!("{key}.lame = \"three-d\"{place} is too stiff for a shell; it is there to replicate what others computed");
        }
    }
    let laws: Vec<(Material, Constitution)> =
        of_face.iter().enumerate().map(|(f, n)| law(&made[*n].0, setup.machine_direction.as_ref().map(|d| d[f]))).collect();
    setup.materials = laws.iter().map(|(material, _)| *material).collect();
    if laws.iter().any(|(_, law)| *law != Constitution::default()) {
        setup.constitutions = laws.iter().map(|(_, law)| *law).collect();
    }
    Ok(())
}

/// What a composition that holds together makes of a face. `direction`: the face's machine direction.
fn law(made: &Composition, direction: Option<[f64; 2]>) -> (Material, Constitution) {
    let isotropic = [made.youngs_modulus.unwrap_or_default(), made.poissons_ratio.unwrap_or_default()];
    let (means, constitution) = if let Some((table, direction)) = made.orthotropic.zip(direction) {
        let o = Orthotropic {
            youngs_moduli: table.youngs_moduli,
            poissons_ratio: table.poissons_ratio,
            shear_modulus: table.shear_modulus,
            direction,
        };
        (o.means(), Constitution::Orthotropic(o))
    } else if let Some((table, [top, bottom])) = made.bilayer.and_then(|table| Some((table, made.layers(&table)?))) {
        let b = Bilayer { top_thickness: table.top_thickness, youngs_moduli: [top[0], bottom[0]], poissons_ratios: [top[1], bottom[1]] };
        (b.means(made.thickness), Constitution::Bilayer(b))
    } else {
        let constitution = match (made.material, made.lame) {
            (scene::Material::StVenantKirchhoff, Some(Lame::ThreeD)) => Constitution::ThreeDimensional,
            (scene::Material::StVenantKirchhoff, _) => Constitution::PlaneStress,
            (scene::Material::NeoHookean, _) => Constitution::NeoHookean,
            (scene::Material::TensionField, _) => Constitution::TensionField { compression: made.compression.unwrap_or(COMPRESSION) },
        };
        (isotropic, constitution)
    };
    (Material { thickness: made.thickness, youngs_modulus: means[0], poissons_ratio: means[1] }, constitution)
}

/// Numbers in a row: the kind of the law, then its parameters, then zeros.
const ROW: usize = 6;

/// Rows of numbers for `setup.h5`.
pub fn to_array(constitutions: &[Constitution]) -> Array {
    let row = |c: &Constitution| -> [f64; ROW] {
        match c {
            Constitution::PlaneStress => [0.0; ROW],
            Constitution::ThreeDimensional => [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Constitution::Orthotropic(o) => [2.0, o.youngs_moduli[0], o.youngs_moduli[1], o.poissons_ratio, o.shear_modulus, 0.0],
            Constitution::Bilayer(b) => {
                let ([e0, e1], [nu0, nu1]) = (b.youngs_moduli, b.poissons_ratios);
                [3.0, b.top_thickness, e0, e1, nu0, nu1]
            }
            Constitution::NeoHookean => [4.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Constitution::TensionField { compression } => [5.0, *compression, 0.0, 0.0, 0.0, 0.0],
        }
    };
    Array::rows(constitutions.iter().flat_map(row).collect(), ROW).with("unit", "SI").with(
        "components",
        "kind and its parameters: 0 plane stress; 1 three-dimensional; 2 orthotropic, E1, E2, nu12, G12; \
         3 bilayer, top thickness, E top, E bottom, nu top, nu bottom; 4 neo-hookean; 5 tension field, compression",
    )
}

/// The laws that rows describe; none if they describe none.
pub fn from_rows(rows: &[f64], machine_direction: &Option<Vec<[f64; 2]>>) -> Option<Vec<Constitution>> {
    let law = |(f, r): (usize, &[f64])| {
        Some(match r[0] {
            0.0 => Constitution::PlaneStress,
            1.0 => Constitution::ThreeDimensional,
            2.0 => Constitution::Orthotropic(Orthotropic {
                youngs_moduli: [r[1], r[2]],
                poissons_ratio: r[3],
                shear_modulus: r[4],
                direction: *machine_direction.as_ref()?.get(f)?,
            }),
            3.0 => {
                let bilayer = Bilayer { top_thickness: r[1], youngs_moduli: [r[2], r[3]], poissons_ratios: [r[4], r[5]] };
                Constitution::Bilayer(bilayer)
            }
            4.0 => Constitution::NeoHookean,
            5.0 => Constitution::TensionField { compression: r[1] },
            _ => return None,
        })
    };
    rows.chunks_exact(ROW).enumerate().map(law).collect()
}
