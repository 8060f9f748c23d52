//! Forms of a surface that is given as a map of the initial shape (Chen et al. 2018, section 3: forms sampled from a target).

use super::{Components, Forms, Impossible, Law, Site, pulled_back};
use nalgebra::Vector3;

/// Position `r(x, y)` [m] and its derivatives in x and y at a place of the xy plane: `r`, `r_x`, `r_y`, `r_xx`, `r_xy`, `r_yy`.
pub type SurfaceMap = Box<dyn Fn(&Vector3<f64>) -> [Vector3<f64>; 6]>;

/// Law `surface`: `abar`, `bbar` are those of the surface `r(x, y)`, whose normal is along `r_x x r_y`.
pub struct Surface {
    /// The map.
    pub map: SurfaceMap,
}

impl Law for Surface {
    fn forms(&self, site: &Site, _time: f64) -> Result<Forms, Impossible> {
        let p = site.position;
        let [_, x, y, xx, xy, yy] = (self.map)(&p);
        let normal = x.cross(&y).try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()));
        let Some(normal) = normal else {
            return Err(format!("the surface has no normal at ({}, {}, {}) m", p.x, p.y, p.z).into());
        };
        let t = Components::Cartesian.of(&p, &site.tangents);
        let a = [x.norm_squared(), x.dot(&y), y.norm_squared()];
        let b = [normal.dot(&xx), normal.dot(&xy), normal.dot(&yy)];
        Ok(Forms { a: pulled_back(&a, &t), b: pulled_back(&b, &t) })
    }
}
