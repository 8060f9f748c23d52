//! What a shell is made of: keys of `[shell]` and of `[[shell.region]]`, how the latter change the former, and which go together.

use super::{Shell, ShellRegion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Law of the material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// St. Venant-Kirchhoff: stress linear in the Green strain.
    #[default]
    Stvk,
    /// Compressible rubber, in plane stress, integrated through the thickness.
    NeoHookean,
    /// St. Venant-Kirchhoff with a bending strain that stretch does not change, to first order: a strip that is turned by moments keeps its length
    /// exactly, where it shortens by h^2 k^2 / 12 otherwise. For thick or sharply bent shells.
    BiotBending,
    /// Cloth and foil: wrinkles instead of bearing compression; bends as St. Venant-Kirchhoff.
    TensionField,
}

impl Material {
    /// Name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Material::Stvk => "stvk",
            Material::NeoHookean => "neo-hookean",
            Material::BiotBending => "biot-bending",
            Material::TensionField => "tension-field",
        }
    }
}

/// First Lame parameter of isotropic St. Venant-Kirchhoff.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Lame {
    /// `E nu / (1 - nu^2)`: the right one for a shell.
    #[default]
    PlaneStress,
    /// `E nu / ((1 + nu) (1 - 2 nu))`, as some papers print it: too stiff. For replication only.
    ThreeD,
}

/// Orthotropic St. Venant-Kirchhoff: moduli along (1) and across (2) the machine direction, which the scene must have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrthotropicModuli {
    /// Young's moduli `[E1, E2]` along and across the fibres [Pa], > 0.
    pub youngs_moduli: [f64; 2],
    /// Poisson's ratio nu12: the contraction across under a stretch along; `|nu12| < sqrt(E1 / E2)`. nu21 is `nu12 E2 / E1`.
    pub poissons_ratio: f64,
    /// Shear modulus G12 [Pa], > 0.
    pub shear_modulus: f64,
}

/// Two layers, each isotropic St. Venant-Kirchhoff. The reference surface stays the middle of the whole shell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Thickness of the top layer (the side of the normal) [m], > 0 and less than the shell's.
    pub top_thickness: f64,
    /// Top layer.
    #[serde(default)]
    pub top: Layer,
    /// Bottom layer.
    #[serde(default)]
    pub bottom: Layer,
}

/// One layer. Absent keys: the shell's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Young's modulus [Pa], > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio, -1 < nu < 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
}

/// What holds for some faces, after all that is said about them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Composition {
    /// Thickness [m].
    pub thickness: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio.
    pub poissons_ratio: Option<f64>,
    /// Law.
    pub material: Material,
    /// First Lame parameter.
    pub lame: Option<Lame>,
    /// Share of the membrane's stiffness in compression.
    pub compression: Option<f64>,
    /// Moduli along and across the fibres.
    pub orthotropic: Option<OrthotropicModuli>,
    /// Layers.
    pub bilayer: Option<Layers>,
}

impl Composition {
    /// That of `[shell]`.
    pub fn of(shell: &Shell) -> Self {
        Composition {
            thickness: shell.thickness,
            youngs_modulus: shell.youngs_modulus,
            poissons_ratio: shell.poissons_ratio,
            material: shell.material.unwrap_or_default(),
            lame: shell.lame,
            compression: shell.compression,
            orthotropic: shell.orthotropic,
            bilayer: shell.bilayer,
        }
    }

    /// With what a region changes. One that names `material`, `orthotropic` or `bilayer` says the whole law anew.
    pub fn within(mut self, region: &ShellRegion) -> Self {
        self.thickness = region.thickness.unwrap_or(self.thickness);
        self.youngs_modulus = region.youngs_modulus.or(self.youngs_modulus);
        self.poissons_ratio = region.poissons_ratio.or(self.poissons_ratio);
        if region.material.is_some() || region.orthotropic.is_some() || region.bilayer.is_some() {
            self.material = region.material.unwrap_or_default();
            (self.orthotropic, self.bilayer) = (region.orthotropic, region.bilayer);
            (self.lame, self.compression) = (None, None);
        }
        self.lame = region.lame.or(self.lame);
        self.compression = region.compression.or(self.compression);
        self
    }

    /// Young's moduli [Pa] and Poisson's ratios of the layers, top and bottom, where both are known.
    pub fn layers(&self, bilayer: &Layers) -> Option<[[f64; 2]; 2]> {
        let of = |layer: &Layer| Some([layer.youngs_modulus.or(self.youngs_modulus)?, layer.poissons_ratio.or(self.poissons_ratio)?]);
        Some([of(&bilayer.top)?, of(&bilayer.bottom)?])
    }

    /// What does not go together or is missing: the key, and what is wrong with it.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let linear = self.material == Material::Stvk;
        let law = self.material.name();
        let isotropic = self.orthotropic.is_none() && self.bilayer.is_none();
        let rules = [
            ("bilayer", self.bilayer.is_some() && self.orthotropic.is_some(), "cannot be combined with `orthotropic`".to_owned()),
            ("orthotropic", self.orthotropic.is_some() && !linear, format!("exists for `stvk` only, not for `{law}`")),
            ("bilayer", self.bilayer.is_some() && !linear, format!("exists for `stvk` only, not for `{law}`")),
            ("lame", self.lame.is_some() && !linear, format!("exists for `stvk` only, not for `{law}`")),
            ("lame", self.lame.is_some() && !isotropic, "has no meaning with `orthotropic` or `bilayer`".to_owned()),
            (
                "compression",
                self.compression.is_some() && self.material != Material::TensionField,
                format!("exists for `tension-field` only, not for `{law}`"),
            ),
        ];
        if let Some((key, _, message)) = rules.into_iter().find(|(_, wrong, _)| *wrong) {
            return Err((key, message));
        }
        if let Some(o) = &self.orthotropic {
            let ([e1, e2], nu) = (o.youngs_moduli, o.poissons_ratio);
            let bound = (e1 / e2).sqrt();
            if !(nu.abs() < bound) {
                let message = format!(
                    "the stiffness is not positive definite: |nu12| < sqrt(E1 / E2) = {bound} is violated (E1 = {e1:e} Pa, E2 = {e2:e} Pa)"
                );
                return Err(("orthotropic.poissons_ratio", message));
            }
            return Ok(());
        }
        if let Some(bilayer) = &self.bilayer {
            let (top, whole) = (bilayer.top_thickness, self.thickness);
            if !(top < whole) {
                return Err(("bilayer.top_thickness", format!("must be less than the thickness of the shell there, {whole} m")));
            }
            return match self.layers(bilayer) {
                Some(_) => Ok(()),
                None if self.youngs_modulus.is_none()
                    && (bilayer.top.youngs_modulus.is_none() || bilayer.bottom.youngs_modulus.is_none()) =>
                {
                    Err(("youngs_modulus", "this key is missing, and a layer without its own needs it [Pa]".to_owned()))
                }
                None => Err(("poissons_ratio", "this key is missing, and a layer without its own needs it".to_owned())),
            };
        }
        match (self.youngs_modulus, self.poissons_ratio) {
            (None, _) => Err(("youngs_modulus", "this key is missing [Pa]".to_owned())),
            (_, None) => Err(("poissons_ratio", "this key is missing".to_owned())),
            _ => Ok(()),
        }
    }
}
