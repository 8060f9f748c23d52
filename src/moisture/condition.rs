//! What happens on the surface of a slab, where and when, and in its volume.

use super::slab::Slab;
use crate::error::{Error, Result};

/// A number for each vertex and time [s].
pub type Data = Box<dyn Fn(usize, f64) -> f64>;

/// One of the two large surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The side of the normal.
    Top,
    /// The other one.
    Bottom,
}

/// A part of the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Where {
    /// One side of these faces.
    Side {
        /// Which side.
        side: Side,
        /// Face indices.
        faces: Vec<usize>,
    },
    /// The full height of the shell along these edges.
    Rim {
        /// Face and the edge's place in it: it lies opposite the face's vertex of this number, 0 to 2.
        edges: Vec<(usize, usize)>,
    },
}

/// What happens there. Where nothing is said the surface is sealed.
pub enum Law {
    /// The value itself. Held at the vertices of the part; where two parts meet, the later condition decides.
    Value(Data),
    /// What flows in per area and time [u m/s]; negative where it flows out.
    Flux(Data),
    /// Exchange with the air: `coefficient (outside - u)` flows in.
    Exchange {
        /// Coefficient [m/s], 0 or more.
        coefficient: f64,
        /// Value of the air.
        outside: Data,
    },
}

/// One condition on a part of the surface. Flux and exchange add up where parts overlap.
pub struct Condition {
    /// Where.
    pub place: Where,
    /// What.
    pub law: Law,
    /// Start and end [s], either of which may be infinite.
    pub window: [f64; 2],
    /// Wet ground: in force only at vertices whose present height is below this [m].
    pub below: Option<f64>,
}

/// What is made in the volume.
pub struct Source {
    /// Rate [u/s] at a vertex, a height as a fraction of the thickness, and a time [s].
    pub rate: Box<dyn Fn(usize, f64, f64) -> f64>,
}

/// Number of the part of the surface in a balance.
pub(super) const TOP: usize = 0;
pub(super) const BOTTOM: usize = 1;
pub(super) const RIM: usize = 2;

/// A condition and the unknowns it acts on.
pub(super) struct Surface {
    /// [`TOP`], [`BOTTOM`] or [`RIM`].
    pub part: usize,
    pub law: Law,
    window: [f64; 2],
    pub below: Option<f64>,
    /// Vertices and the area that each stands for [m2], of all levels together.
    vertices: Vec<(usize, f64)>,
    /// First level, and the part of the area of each from there on.
    first: usize,
    shares: Vec<f64>,
}

impl Surface {
    /// Integrals over the surface take their values at the nodes: exact for data that are linear, and never a cause of overshoot.
    /// `shares`: part of the height that each level stands for. Errors: parts that the slab does not have, windows without duration.
    pub fn new(condition: Condition, slab: &Slab, shares: &[f64]) -> Result<Self> {
        let fault = |message: String| Err(Error::input("moisture", message));
        let Condition { place, law, window, below } = condition;
        if !(window[0] < window[1]) {
            return fault(format!("the window from {} s to {} s has no duration", window[0], window[1]));
        }
        if below.is_some_and(f64::is_nan) {
            return fault("the height of the wet ground is not a number".into());
        }
        if let Law::Exchange { coefficient, .. } = law
            && !(coefficient >= 0.0 && coefficient.is_finite())
        {
            return fault(format!("{coefficient} is not a coefficient of exchange: expected 0 m/s or more"));
        }
        let mut areas = vec![0.0; slab.vertices];
        let no_face = |f: usize| fault(format!("there is no face {f}: the slab has {}", slab.faces.len()));
        let (part, first, shares) = match place {
            Where::Side { side, faces } => {
                for f in faces {
                    let Some(face) = slab.faces.get(f) else { return no_face(f) };
                    face.iter().for_each(|&v| areas[v] += slab.area(f) / 3.0);
                }
                match side {
                    Side::Top => (TOP, slab.levels.len() - 1, vec![1.0]),
                    Side::Bottom => (BOTTOM, 0, vec![1.0]),
                }
            }
            Where::Rim { edges } => {
                for (f, local) in edges {
                    let Some(face) = slab.faces.get(f) else { return no_face(f) };
                    if local > 2 {
                        return fault(format!("face {f} has no edge {local}: expected 0 to 2"));
                    }
                    let half = 0.5 * slab.edge(f, local) * slab.thickness[f];
                    [1, 2].iter().for_each(|k| areas[face[(local + k) % 3]] += half);
                }
                (RIM, 0, shares.to_vec())
            }
        };
        let vertices = areas.into_iter().enumerate().filter(|(_, area)| *area > 0.0).collect();
        Ok(Surface { part, law, window, below, vertices, first, shares })
    }

    /// Whether the time lies in the window.
    pub fn in_window(&self, time: f64) -> bool {
        self.window[0] <= time && time <= self.window[1]
    }

    /// Start and end of the window [s].
    pub fn window(&self) -> [f64; 2] {
        self.window
    }

    /// Shows vertices where the condition is in force, and their unknowns with the area [m2] that each stands for. `value`: a vertex's data.
    ///
    /// # Errors
    /// Those of `value`.
    pub fn each(
        &self,
        levels: usize,
        heights: &[f64],
        mut value: impl FnMut(usize) -> Result<f64, String>,
        mut visit: impl FnMut(usize, f64, f64),
    ) -> Result<(), String> {
        for &(v, area) in &self.vertices {
            if self.below.is_some_and(|below| !(heights[v] < below)) {
                continue;
            }
            let data = value(v)?;
            for (l, share) in self.shares.iter().enumerate() {
                visit(v * levels + self.first + l, area * share, data);
            }
        }
        Ok(())
    }
}

/// A datum at a vertex and a time. Errors: it is not finite.
pub(super) fn datum(value: f64, what: &str, vertex: usize, time: f64) -> Result<f64, String> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(format!("moisture: the {what} at vertex {vertex} is {value} at {time} s: expected a finite number"))
}

/// A datum that must not be below `least`, where that is not minus infinity, by more than the round-off of expressions.
pub(super) fn at_least(least: f64, value: f64, what: &str, vertex: usize, time: f64) -> Result<f64, String> {
    let value = datum(value, what, vertex, time)?;
    if value >= least - 1e-9 * least.abs() {
        return Ok(value);
    }
    Err(format!("moisture: the {what} at vertex {vertex} is {value} at {time} s: expected {least} or more, which is bone dry already"))
}
