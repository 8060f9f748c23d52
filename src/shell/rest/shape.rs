//! Forms of another shape of the same faces.

use super::{Forms, Impossible, Interpolation, Law, Site};
use nalgebra::Vector3;

/// Law `shape`: the forms that the faces have in another shape.
pub struct OtherShape {
    /// The other shape, as the same element sees it.
    pub shape: Box<dyn Interpolation>,
}

impl Law for OtherShape {
    fn forms(&self, site: &Site, _time: f64) -> Result<Forms, Impossible> {
        let there = self.shape.site(site.face, site.place);
        let [p, q]: [Vector3<f64>; 2] = there.tangents;
        Ok(Forms { a: [p.norm_squared(), p.dot(&q), q.norm_squared()], b: there.initial.b })
    }
}
