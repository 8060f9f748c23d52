//! Initial velocities: expressions of place, and random ones with a seed.
//!
//! Random velocities differ from node to node: the roughest motion that a mesh can have. Coordinates that supports hold have the velocity of
//! their support, whatever else is said.

use super::build;
use crate::error::{Error, Result};
use crate::model::HeldUnknown;
use crate::scene::{self, RandomVelocity, Scene};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Initial velocity of each node [m/s]; empty in statics. `held`: what supports hold, and its motion.
///
/// # Errors
/// An expression that is not finite at a node.
pub fn initial(scene: &Scene, held: &[HeldUnknown], nodes: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>> {
    let Some(dynamics) = &scene.dynamics else { return Ok(Vec::new()) };
    let mut velocities = vec![Vector3::zeros(); nodes.len()];
    if let Some(exprs) = &dynamics.velocity {
        let fields = exprs.iter().map(|e| build::field("dynamics.velocity", e, scene::PLACE)).collect::<Result<Vec<_>>>()?;
        velocities.iter_mut().zip(nodes).for_each(|(v, p)| *v = Vector3::from_fn(|k, _| fields[k](p, 0.0)));
        if let Some(v) = velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(Error::input("dynamics.velocity", format!("is not finite at vertex {v}")));
        }
    }
    if let Some(table) = &dynamics.random_velocity {
        velocities.iter_mut().zip(random(table, nodes.len())).for_each(|(v, random)| *v += random);
    }
    // Held coordinates come last, so that more supports do not change the random velocity of other nodes.
    for held in held {
        let Some(v) = velocities.get_mut(held.unknown / 3) else { continue };
        let velocity = held.velocity(0.0, dynamics.dt);
        // A motion that is not finite is told of when its time comes.
        v[held.unknown % 3] = if velocity.is_finite() { velocity } else { 0.0 };
    }
    Ok(velocities)
}

/// Velocities of `count` nodes [m/s], alike in all directions, of any speed up to the table's with equal chance for equal volumes.
fn random(table: &RandomVelocity, count: usize) -> Vec<Vector3<f64>> {
    let mut generator = ChaCha8Rng::seed_from_u64(table.seed);
    let mut one = || loop {
        let v = Vector3::from_fn(|_, _| generator.random_range(-1.0..=1.0));
        if v.norm() <= 1.0 {
            break table.speed * v;
        }
    };
    (0..count).map(|_| one()).collect()
}
