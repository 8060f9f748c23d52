//! Forms that are given in the xy plane.

use super::{Forms, Impossible, Law, ScalarField, Site, pulled_back};
use nalgebra::{Vector2, Vector3};

/// What components of forms in the plane refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// dx and dy.
    Cartesian,
    /// dr and dtheta about the z axis.
    Polar,
}

impl Components {
    /// Components of two vectors at a place.
    pub fn of(self, p: &Vector3<f64>, tangents: &[Vector3<f64>; 2]) -> [Vector2<f64>; 2] {
        tangents.map(|r| match self {
            Components::Cartesian => Vector2::new(r.x, r.y),
            Components::Polar => {
                let r2 = p.x * p.x + p.y * p.y;
                Vector2::new((p.x * r.x + p.y * r.y) / r2.sqrt(), (p.x * r.y - p.y * r.x) / r2)
            }
        })
    }
}

/// Law `pullback`: forms given in the xy plane.
pub struct Pullback {
    /// First form 11, 12, 22; none for the flat metric.
    pub abar: Option<[ScalarField; 3]>,
    /// Second form; none for zero.
    pub bbar: Option<[ScalarField; 3]>,
    /// What the components refer to.
    pub components: Components,
}

/// A form of the plane at a site, in the face's basis.
pub(super) fn plane_form(fields: &[ScalarField; 3], components: Components, site: &Site, time: f64) -> [f64; 3] {
    pulled_back(&fields.each_ref().map(|f| f(site, time)), &components.of(&site.position, &site.tangents))
}

impl Law for Pullback {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let form = |fields| plane_form(fields, self.components, site, time);
        let flat = Components::Cartesian.of(&site.position, &site.tangents);
        let a = self.abar.as_ref().map_or_else(|| pulled_back(&[1.0, 0.0, 1.0], &flat), form);
        Ok(Forms { a, b: self.bbar.as_ref().map_or([0.0; 3], form) })
    }
}
