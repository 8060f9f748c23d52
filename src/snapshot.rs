//! Named fields at one moment: all that models and files share.

use serde::{Deserialize, Serialize};

/// What the entries of a field belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Association {
    /// One entry per mesh node (vertices first, then any further nodes of the element).
    Node,
    /// One entry per vertex.
    Vertex,
    /// One entry per director of an edge (one per edge for the linear element).
    Director,
    /// One entry per face.
    Face,
    /// One entry per integration point, face by face.
    Point,
}

/// One named array.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name as files show it, for example `velocity`.
    pub name: String,
    /// What its entries belong to.
    pub association: Association,
    /// Numbers per entry: 1 scalar, 3 vector or symmetric 2x2 as (11, 12, 22), 6 symmetric 3x3, 9 tensor.
    pub components: usize,
    /// SI unit, for example `m/s`; `1` for a pure number.
    pub unit: String,
    /// Entries, component index fastest.
    pub data: Vec<f64>,
}

/// The state of a simulation at one moment. A checkpoint is a snapshot: everything that the next step reads is in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Number of accepted steps since the start.
    pub step: u64,
    /// Simulated time [s]; in statics without end the load factor.
    pub time: f64,
    /// Size of the next step to try [s].
    pub dt: f64,
    /// Named fields.
    pub fields: Vec<Field>,
    /// Named numbers: counters, energies and step-control state.
    pub numbers: Vec<(String, f64)>,
}

impl Snapshot {
    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// The number of that name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(n, _)| n == name).map(|(_, v)| *v)
    }
}
