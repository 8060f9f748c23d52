//! What each face is made of: from the scene's tables to [`Material`] and [`Constitution`], and to the rows that `setup.h5` keeps of the latter.

use super::setup::region;
use crate::case::Array;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::scene::{self, Composition, Lame, Scene};
use crate::shell::{Bilayer, Constitution, Material, Orthotropic};

/// Share of the membrane's stiffness that a tension field leaves in compression, by default.
const COMPRESSION: f64 = 1e-3;

/// What the scene says of each face, and what has to be known of the scene to make laws of it.
pub struct Compositions {
    /// All that there are.
    made: Vec<Composition>,
    /// Which of them each face has.
    of_face: Vec<usize>,
    /// Density of each face [kg/m3]; empty where the scene has none.
    pub densities: Vec<f64>,
}

impl Compositions {
    /// Reads `[shell]` and its regions.
    ///
    /// # Errors
    /// Regions that do not exist or have no faces; regions that overlap so that what holds on a face does not go together; an orthotropic
    /// material without a machine direction.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self> {
        let shell = &scene.shell;
        let mut made = vec![Composition::of(shell)];
        // For errors: the last table that said something about a composition, and its region.
        let mut places = vec![("shell".to_owned(), String::new())];
        let mut of_face = vec![0; mesh.faces.len()];
        let mut densities = shell.density.map_or(Vec::new(), |rho| vec![rho; mesh.faces.len()]);
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
                        made.push(made[before].within(table));
                        places.push((key.clone(), format!(" (region '{}')", table.region)));
                        *changed[before].insert(made.len() - 1)
                    }
                };
                if let (Some(rho), Some(to)) = (table.density, densities.get_mut(f)) {
                    *to = rho;
                }
            }
        }
        let mut used = vec![false; made.len()];
        of_face.iter().for_each(|n| used[*n] = true);
        for ((composition, (key, place)), _) in made.iter().zip(&places).zip(&used).filter(|(_, used)| **used) {
            composition.check().map_err(|(name, message)| Error::input(format!("{key}.{name}"), format!("{message}{place}")))?;
            if composition.orthotropic.is_some() && scene.machine_direction.is_none() {
                let message = format!("needs the table [machine-direction]{place}");
                return Err(Error::input(format!("{key}.orthotropic"), message));
            }
            if composition.lame == Some(Lame::ThreeD) {
                log::warn!("{key}.lame = \"three-d\"{place} is too stiff for a shell; it is there to replicate what others computed");
            }
        }
        Ok(Compositions { made, of_face, densities })
    }

    /// Thickness and (mean) moduli of each face.
    pub fn materials(&self) -> Vec<Material> {
        self.of_face.iter().map(|n| material(&self.made[*n])).collect()
    }

    /// Law of each face; empty where all have the default. `machine_direction`: of each face, which orthotropic faces need.
    pub fn constitutions(&self, machine_direction: Option<&[[f64; 2]]>) -> Vec<Constitution> {
        let law = |(f, n): (usize, &usize)| constitution(&self.made[*n], machine_direction.map(|d| d[f]));
        let laws: Vec<Constitution> = self.of_face.iter().enumerate().map(law).collect();
        if laws.iter().all(|law| *law == Constitution::default()) { Vec::new() } else { laws }
    }
}

/// The two layers of a composition that has some.
fn bilayer(made: &Composition) -> Option<Bilayer> {
    let table = made.bilayer?;
    let [top, bottom] = made.layers(&table)?;
    Some(Bilayer { top_thickness: table.top_thickness, youngs_moduli: [top[0], bottom[0]], poissons_ratios: [top[1], bottom[1]] })
}

/// The orthotropic law of a composition that has it.
fn orthotropic(made: &Composition, direction: [f64; 2]) -> Option<Orthotropic> {
    let scene::OrthotropicModuli { youngs_moduli, poissons_ratio, shear_modulus } = made.orthotropic?;
    Some(Orthotropic { youngs_moduli, poissons_ratio, shear_modulus, direction })
}

/// Thickness and moduli, or their means.
fn material(made: &Composition) -> Material {
    let isotropic = || [made.youngs_modulus.unwrap_or_default(), made.poissons_ratio.unwrap_or_default()];
    // The means of an orthotropic material do not depend on its direction.
    let means = orthotropic(made, [1.0, 0.0]).map(|o| o.means()).or(bilayer(made).map(|b| b.means(made.thickness)));
    let [youngs_modulus, poissons_ratio] = means.unwrap_or_else(isotropic);
    Material { thickness: made.thickness, youngs_modulus, poissons_ratio }
}

/// The law of a composition that holds together. `direction`: the face's machine direction.
fn constitution(made: &Composition, direction: Option<[f64; 2]>) -> Constitution {
    if let Some(o) = direction.and_then(|direction| orthotropic(made, direction)) {
        return Constitution::Orthotropic(o);
    }
    if let Some(b) = bilayer(made) {
        return Constitution::Bilayer(b);
    }
    match (made.material, made.lame) {
        (scene::Material::Stvk, Some(Lame::ThreeD)) => Constitution::ThreeDimensional,
        (scene::Material::Stvk, _) => Constitution::PlaneStress,
        (scene::Material::NeoHookean, _) => Constitution::NeoHookean,
        (scene::Material::BiotBending, _) => Constitution::BiotBending,
        (scene::Material::TensionField, _) => Constitution::TensionField { compression: made.compression.unwrap_or(COMPRESSION) },
    }
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
            Constitution::BiotBending => [6.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        }
    };
    Array::rows(constitutions.iter().flat_map(row).collect(), ROW).with("unit", "SI").with(
        "components",
        "kind and its parameters: 0 plane stress; 1 three-dimensional; 2 orthotropic, E1, E2, nu12, G12; \
         3 bilayer, top thickness, E top, E bottom, nu top, nu bottom; 4 neo-hookean; 5 tension field, compression; 6 Biot's bending",
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
            6.0 => Constitution::BiotBending,
            _ => return None,
        })
    };
    rows.chunks_exact(ROW).enumerate().map(law).collect()
}
