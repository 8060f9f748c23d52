//! The cotangent Laplacian of a triangle mesh and linear problems with it, factorised once.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::sparse::{Cholesky, Kind, Numbering, Pattern, Scatter, System};

/// `x . L x / 2` is the Dirichlet energy of the function that is linear on each face: `(L x)_i = sum_j w_ij (x_i - x_j)` with the mean of
/// the cotangents opposite an edge as its weight (Pinkall and Polthier, Experimental Mathematics 2, 1993). No unit.
///
/// Positive semidefinite with any triangles; weights are positive where the two angles opposite an edge add up to less than a half turn.
pub struct Laplacian<'a> {
    faces: &'a [[usize; 3]],
    vertices: usize,
    blocks: Vec<[[f64; 3]; 3]>,
}

impl<'a> Laplacian<'a> {
    /// `angles`: [rad], of each face at its corners.
    pub fn new(mesh: &'a Mesh, angles: &[[f64; 3]]) -> Self {
        let block = |angles: &[f64; 3]| {
            let mut block = [[0.0; 3]; 3];
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let weight = 0.5 / angles[i].tan();
                block[j][j] += weight;
                block[k][k] += weight;
                block[j][k] -= weight;
                block[k][j] -= weight;
            }
            block
        };
        Laplacian { faces: &mesh.faces, vertices: mesh.vertices.len(), blocks: angles.iter().map(block).collect() }
    }

    /// The product `L x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.vertices];
        for (face, block) in self.faces.iter().zip(&self.blocks) {
            for (i, row) in face.iter().zip(block) {
                product[*i] += row.iter().zip(face).map(|(l, j)| l * x[*j]).sum::<f64>();
            }
        }
        product
    }

    /// Factorises the rows and columns of the vertices that are not held. Errors: faces so thin that their cotangents cancel.
    pub fn factorise(&self, held: &[bool]) -> Result<Factor> {
        let numbering = Numbering::new(held);
        let pattern = Pattern::new(&numbering, &mut |show| self.faces.iter().for_each(|face| show(face)))?;
        let scatter = Scatter::new(self.faces.iter().copied(), &numbering, &pattern);
        let mut system = System::new(&pattern);
        self.blocks.iter().enumerate().for_each(|(f, block)| scatter.add_hessian(f, block, &mut system));
        let mut cholesky = Cholesky::new(&pattern)?;
        cholesky.refactor(&pattern, &system.matrix, Kind::Llt).map_err(|pivot| {
            let vertex = numbering.unknowns()[pivot.unknown];
            Error::input_with_help("flatten", format!("the faces at vertex {vertex} are too thin to be flattened"), "mesh the surface anew")
        })?;
        Ok(Factor { numbering, cholesky })
    }
}

/// Factor of the Laplacian without the held vertices.
pub struct Factor {
    numbering: Numbering,
    cholesky: Cholesky,
}

impl Factor {
    /// Solves for the vertices that are not held; the others get 0. `right`: one number per vertex, as the result.
    pub fn solve(&mut self, right: &[f64]) -> Vec<f64> {
        let unknowns = self.numbering.unknowns();
        let mut free: Vec<f64> = unknowns.iter().map(|&v| right[v as usize]).collect();
        if !free.is_empty() {
            self.cholesky.solve(&mut free);
        }
        let mut x = vec![0.0; right.len()];
        unknowns.iter().zip(free).for_each(|(&v, value)| x[v as usize] = value);
        x
    }

    /// The function with the values of `x` where vertices are held that is harmonic elsewhere.
    pub fn extend(&mut self, laplacian: &Laplacian, mut x: Vec<f64>) -> Vec<f64> {
        for &v in self.numbering.unknowns() {
            x[v as usize] = 0.0;
        }
        let right: Vec<f64> = laplacian.times(&x).iter().map(|r| -r).collect();
        let inner = self.solve(&right);
        x.iter().zip(inner).map(|(held, free)| held + free).collect()
    }
}
