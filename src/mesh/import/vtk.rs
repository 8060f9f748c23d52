//! What legacy and XML VTK files have in common: kinds of numbers and of cells.
//!
//! Read here and not by a library because those at hand fail on what VTK 9 writes by default: compressed arrays of several
//! blocks, arrays with information keys, raw appended data, legacy files of version 5.

use super::{Fault, Soup};

/// A kind of number in a file, with its bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Kind {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        let (Kind::Signed(n) | Kind::Unsigned(n) | Kind::Float(n)) = self;
        n
    }

    /// The numbers in the bytes; a rest too short for one is left out. Integers beyond 2^53 are rounded: no index is as large.
    pub fn numbers(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        let read = |chunk: &[u8]| {
            let mut wide = [0u8; 8];
            for (k, to) in wide[..chunk.len()].iter_mut().enumerate() {
                *to = chunk[if big_endian { chunk.len() - 1 - k } else { k }];
            }
            let bits = u64::from_le_bytes(wide);
            let shift = 64 - 8 * chunk.len() as u32;
            match self {
                Kind::Signed(_) => ((bits << shift) as i64 >> shift) as f64,
                Kind::Unsigned(_) => bits as f64,
                Kind::Float(4) => f64::from(f32::from_bits(bits as u32)),
                Kind::Float(_) => f64::from_bits(bits),
            }
        };
        bytes.chunks_exact(self.size()).map(read).collect()
    }
}

/// Adds points; returns the number there were before.
pub fn add_points(soup: &mut Soup, coordinates: &[f64]) -> usize {
    let first = soup.mesh.vertices.len();
    coordinates.chunks_exact(3).for_each(|p| soup.vertex([p[0], p[1], p[2]]));
    first
}

/// Cells as VTK keeps them: points of all cells in a row, and where each cell ends.
#[derive(Default)]
pub struct Cells {
    pub connectivity: Vec<f64>,
    pub ends: Vec<f64>,
}

impl Cells {
    /// Adds the polygons among the cells; without `types` all are. `first` is the vertex index of their point 0.
    pub fn add_to(&self, soup: &mut Soup, first: usize, types: Option<&[f64]>) -> Result<(), Fault> {
        if let Some(types) = types
            && types.len() != self.ends.len()
        {
            return Err(Fault::new(format!("{} cells have {} types", self.ends.len(), types.len())));
        }
        let (mut start, mut skipped) = (0, 0);
        for (k, &end) in self.ends.iter().enumerate() {
            let place = |message: String| Fault::new(format!("cell {k}: {message}"));
            let corners = whole(end).and_then(|end| self.connectivity.get(start..end));
            let corners = corners.ok_or_else(|| place(format!("its end {end} in the list of points is out of order or range")))?;
            start += corners.len();
            let wanted = match types.map(|types| types[k]) {
                None | Some(7.0) => corners.len(),
                Some(5.0) => 3,
                Some(9.0) => 4,
                Some(22.0) => 6,
                Some(1.0..=4.0 | 21.0) => {
                    skipped += 1;
                    soup.cells += 1;
                    continue;
                }
                Some(kind) => return Err(place(format!("{} (type {kind}) is not supported: expected triangles", name(kind)))),
            };
            if corners.len() != wanted {
                return Err(place(format!("{} points where {wanted} are expected", corners.len())));
            }
            let index = |&v: &f64| {
                let index = whole(v).and_then(|v| v.checked_add(first)).filter(|&v| v < soup.mesh.vertices.len());
                index.ok_or_else(|| place(format!("point {v} is out of range")))
            };
            let corners = corners.iter().map(index).collect::<Result<Vec<_>, _>>()?;
            let quadratic = types.is_some_and(|types| types[k] == 22.0);
            soup.check_order(quadratic, "cell", k as u64)?;
            match corners[..] {
                [a, b, c, ab, bc, ca] if quadratic => {
                    soup.triangle([a, b, c], Some([ab, bc, ca]));
                }
                _ => soup.polygon(&corners).map_err(|fault| place(fault.message))?,
            }
        }
        if skipped > 0 {
            soup.warnings.push(format!("{skipped} cells that are points or lines are left out"));
        }
        Ok(())
    }
}

/// The number as an index, if it is one.
pub fn whole(x: f64) -> Option<usize> {
    (x >= 0.0 && x < 2f64.powi(53) && x.fract() == 0.0).then_some(x as usize)
}

fn name(kind: f64) -> &'static str {
    match kind as i64 {
        6 => "a triangle strip",
        8 => "a pixel",
        10 => "a tetrahedron",
        12 => "a hexahedron",
        13 => "a wedge",
        14 => "a pyramid",
        34 => "a triangle of seven nodes",
        69 => "a Lagrange triangle",
        _ => "a cell of another kind",
    }
}
