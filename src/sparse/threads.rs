//! Work on elements by several threads, with the same bits for any number of them.
//!
//! Elements do not know each other, so threads compute them in any order; what they contribute is added by one thread at a time in the order of
//! the elements, a batch while the next is computed. The number of threads is that of rayon's pool. Meshes so small that threads only get in
//! each other's way are left to one.

use super::{Scatter, System};
use rayon::prelude::*;
use std::ops::Range;

/// Elements that one thread computes at a time.
const CHUNK: usize = 16;

/// The same where one thread does it all: what its fastest memory holds.
const FEW: usize = 4;

/// Elements whose contributions are kept until they are added. Two batches of the quadratic element are 1.2 MB.
const BATCH: usize = 128;

/// Elements below which one thread does it all.
const SHARED: usize = 512;

/// What one element of `N` unknowns adds to energy, gradient and Hessian (lower triangle).
#[derive(Clone, Debug)]
pub struct Contribution<const N: usize> {
    /// Energy [J].
    pub energy: f64,
    /// Gradient in the element's unknowns.
    pub gradient: [f64; N],
    /// Second derivatives; what is above the diagonal is not read.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Contribution<N> {
    /// Nothing.
    const ZERO: Self = Contribution { energy: 0.0, gradient: [0.0; N], hessian: [[0.0; N]; N] };
}

/// Whether so many elements are worth several threads.
fn is_shared(elements: usize) -> bool {
    elements >= SHARED && rayon::current_num_threads() > 1
}

/// Sets `into`, `width` numbers for each element. `compute`: the elements and their part of it.
pub fn fill<T: Send>(into: &mut [T], width: usize, compute: impl Fn(Range<usize>, &mut [T]) + Sync) {
    let elements = into.len() / width;
    if is_shared(elements) {
        into.par_chunks_mut(CHUNK * width)
            .enumerate()
            .for_each(|(chunk, part)| compute(chunk * CHUNK..chunk * CHUNK + part.len() / width, part));
    } else {
        compute(0..elements, into);
    }
}

/// One value for each element, `zero` before it is computed.
pub fn collect<T: Send + Clone>(elements: usize, zero: T, compute: impl Fn(Range<usize>, &mut [T]) + Sync) -> Vec<T> {
    let mut values = vec![zero; elements];
    fill(&mut values, 1, compute);
    values
}

impl<const N: usize> Scatter<N> {
    /// Adds gradients and Hessians of all elements; returns the sum of energies [J]. `compute`: elements, and their contributions to be set.
    pub fn add_all(&self, into: &mut System, compute: impl Fn(Range<usize>, &mut [Contribution<N>]) + Sync) -> f64 {
        let elements = self.elements();
        let mut energy = 0.0;
        let mut add = |first: usize, batch: &[Contribution<N>]| {
            for (k, part) in batch.iter().enumerate() {
                energy += part.energy;
                self.add_gradient(first + k, &part.gradient, into);
                self.add_hessian(first + k, &part.hessian, into);
            }
        };
        if !is_shared(elements) {
            let mut part = vec![Contribution::ZERO; FEW];
            for first in (0..elements).step_by(FEW) {
                let range = first..(first + FEW).min(elements);
                let part = &mut part[..range.len()];
                compute(range, part);
                add(first, part);
            }
            return energy;
        }
        let batch = |first: usize| first..(first + BATCH).min(elements);
        let compute = |range: Range<usize>, parts: &mut [Contribution<N>]| {
            parts[..range.len()]
                .par_chunks_mut(CHUNK)
                .enumerate()
                .for_each(|(chunk, part)| compute(range.start + chunk * CHUNK..range.start + chunk * CHUNK + part.len(), part));
        };
        let (mut now, mut next) = (vec![Contribution::ZERO; BATCH], vec![Contribution::ZERO; BATCH]);
        compute(batch(0), &mut now);
        for first in (0..elements).step_by(BATCH) {
            let (here, there) = (batch(first), batch((first + BATCH).min(elements)));
            rayon::join(|| add(first, &now[..here.len()]), || compute(there, &mut next));
            std::mem::swap(&mut now, &mut next);
        }
        energy
    }
}
