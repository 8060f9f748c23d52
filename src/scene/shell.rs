//! Table `[shell]`: element, thickness and material.

use super::material::{Lame, Layers, Material, OrthotropicModuli};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Order of the element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Element {
    /// Three nodes a face, one director an edge, constant strains: cheap, second order; locks on thin irregular meshes.
    Linear,
    /// Six nodes a face, two directors an edge: order three and more, no locking. Not with `director = "average"`.
    #[default]
    Quadratic,
}

impl Element {
    /// Name in scenes and tables.
    pub fn name(self) -> &'static str {
        match self {
            Element::Linear => "linear",
            Element::Quadratic => "quadratic",
        }
    }
}

/// Where the normals on the edges come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Director {
    /// Normalised mean of the two face normals; the face's own normal on the boundary. Does not converge on irregular meshes.
    Average,
    /// A free angle per edge, hinge measure `sin`.
    FreeSin,
    /// A free angle per edge, hinge measure `tan`: a fold cannot invert.
    #[default]
    FreeTan,
    /// A free angle per edge, hinge measure the angle itself.
    FreeAngle,
}

impl Director {
    /// Name in scenes and tables.
    pub fn name(self) -> &'static str {
        match self {
            Director::Average => "average",
            Director::FreeSin => "free-sin",
            Director::FreeTan => "free-tan",
            Director::FreeAngle => "free-angle",
        }
    }
}

/// Mass matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mass {
    /// Galerkin.
    #[default]
    Consistent,
    /// Diagonal: a third of each linear face's mass at each vertex; on quadratic faces the consistent diagonal, scaled to the face's mass.
    Lumped,
}

/// The shell. Thickness, density and material hold wherever no region says otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shell {
    /// Order of the element. Default: `quadratic`; with `director = "average"`, `linear`.
    #[serde(default)]
    pub element: Element,
    /// Edge normals.
    #[serde(default)]
    pub director: Director,
    /// Thickness [m], > 0.
    pub thickness: f64,
    /// Young's modulus [Pa], > 0. May be absent where `orthotropic` or both layers of `bilayer` say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio, -1 < nu < 0.5. May be absent as `youngs_modulus` may.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
    /// Law of the material. Default: `stvk`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// First Lame parameter of `stvk`. Default: `plane-stress`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lame: Option<Lame>,
    /// Share of the membrane's stiffness that `tension-field` leaves in compression, > 0 and <= 1. Default: 1e-3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<f64>,
    /// Other moduli along the fibres than across. Not with `bilayer`; `stvk` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orthotropic: Option<OrthotropicModuli>,
    /// Two layers of different materials. `stvk` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bilayer: Option<Layers>,
    /// Density [kg/m3], > 0. Needed by dynamics and gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Kelvin-Voigt viscosity over modulus [s], > 0. Dynamics only. Absent: no damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// Mass matrix (dynamics and gravity).
    #[serde(default)]
    pub mass: Mass,
    /// Other values for the faces of some regions; later ones win.
    #[serde(default, rename = "region", skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<ShellRegion>,
}

impl Shell {
    /// What stands for a shell where there is none: no thickness, the element without further nodes.
    pub(super) fn absent() -> Self {
        Shell {
            element: Element::Linear,
            director: Director::default(),
            thickness: 0.0,
            youngs_modulus: None,
            poissons_ratio: None,
            material: None,
            lame: None,
            compression: None,
            orthotropic: None,
            bilayer: None,
            density: None,
            viscosity: None,
            mass: Mass::default(),
            regions: Vec::new(),
        }
    }

    /// Whether there is no shell.
    pub(super) fn is_absent(&self) -> bool {
        *self == Self::absent()
    }
}

/// Values for the faces of one region. Absent keys: the shell's own; but a region that names `material`, `orthotropic` or `bilayer` says the
/// whole law anew, and of the shell's only thickness, density, `youngs_modulus` and `poissons_ratio` stay in force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShellRegion {
    /// Name of a region with faces.
    pub region: String,
    /// Thickness [m], > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Young's modulus [Pa], > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio, -1 < nu < 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
    /// Law of the material. Default: `stvk`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// First Lame parameter of `stvk`. Default: `plane-stress`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lame: Option<Lame>,
    /// Share of the membrane's stiffness that `tension-field` leaves in compression, > 0 and <= 1. Default: 1e-3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<f64>,
    /// Other moduli along the fibres than across. Not with `bilayer`; `stvk` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orthotropic: Option<OrthotropicModuli>,
    /// Two layers of different materials. `stvk` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bilayer: Option<Layers>,
    /// Density [kg/m3], > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
}
