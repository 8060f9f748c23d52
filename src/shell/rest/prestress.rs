//! Forms to which given tensors are added, so that the initial shape is under stress.

use super::pullback::plane_form;
use super::{Components, Forms, Impossible, Law, ScalarField, Site};

/// Law `prestress`: `abar = times a + plus_a`, `bbar = b + plus_b`, of the forms it starts from.
pub struct Prestress {
    /// Factor on the first form; none for 1.
    pub times: Option<ScalarField>,
    /// Added first form in the xy plane; none for nothing.
    pub plus_a: Option<[ScalarField; 3]>,
    /// Added second form; none for nothing.
    pub plus_b: Option<[ScalarField; 3]>,
    /// What the components refer to.
    pub components: Components,
}

impl Law for Prestress {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let times = self.times.as_ref().map_or(1.0, |f| f(site, time));
        let plus =
            |fields: &Option<[ScalarField; 3]>| fields.as_ref().map_or([0.0; 3], |fields| plane_form(fields, self.components, site, time));
        let (a, b, start) = (plus(&self.plus_a), plus(&self.plus_b), site.initial);
        Ok(Forms { a: std::array::from_fn(|i| times * start.a[i] + a[i]), b: std::array::from_fn(|i| start.b[i] + b[i]) })
    }
}
