//! Meshes of concentric rings around one vertex: disc and sphere cap.

use super::{check_count, check_faces, check_length};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Region};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Index of vertex `k` of ring `i`: the centre is 0, ring `i` has `6 i` vertices, counted from the +x axis.
fn index(i: usize, k: usize) -> usize {
    if i == 0 { 0 } else { 1 + 3 * i * (i - 1) + k % (6 * i) }
}

/// Rings in six sectors of near-equilateral faces; `place` maps (ring as a fraction of all, angle [rad]) to space.
fn rings(place_key: &str, count: usize, place: impl Fn(f64, f64) -> Vector3<f64>) -> Result<(Mesh, Region)> {
    check_count(place_key, count, 1, 5000)?;
    check_faces(place_key, 6.0 * (count * count) as f64)?;
    let mut mesh = Mesh { vertices: vec![place(0.0, 0.0)], ..Mesh::default() };
    for i in 1..=count {
        let t = i as f64 / count as f64;
        mesh.vertices.extend((0..6 * i).map(|k| place(t, TAU * k as f64 / (6 * i) as f64)));
        for sector in 0..6 {
            for k in 0..i {
                let (inner, outer) = (sector * (i - 1) + k, sector * i + k);
                mesh.faces.push([index(i - 1, inner), index(i, outer), index(i, outer + 1)]);
                if k + 1 < i {
                    mesh.faces.push([index(i - 1, inner), index(i, outer + 1), index(i - 1, inner + 1)]);
                }
            }
        }
    }
    let rim = Region::path(&(0..6 * count).map(|k| index(count, k)).collect::<Vec<_>>(), true);
    Ok((mesh, rim))
}

/// Flat disc of `radius` [m] around the origin, normal +z; `rings` of faces, 1 to 5000. Regions: rim, center.
pub fn disc(radius: f64, rings: usize) -> Result<Mesh> {
    check_length("mesh.disc.radius", radius)?;
    let (mut mesh, rim) = self::rings("mesh.disc.rings", rings, |t, angle| {
        let r = radius * t;
        Vector3::new(r * angle.cos(), r * angle.sin(), 0.0)
    })?;
    mesh.regions.insert("rim".into(), rim);
    mesh.regions.insert("center".into(), Region::new([0], [], []));
    Ok(mesh)
}

/// Cap of a sphere of `radius` [m] around the origin, apex on +z, outward normal; `rings` of faces, 1 to 5000.
///
/// `half_angle`: angle between axis and rim, seen from the sphere's centre [degrees], > 0 and < 180. Regions: rim, apex.
pub fn sphere_cap(radius: f64, half_angle: f64, rings: usize) -> Result<Mesh> {
    check_length("mesh.sphere-cap.radius", radius)?;
    if !(half_angle > 0.0 && half_angle < 180.0) {
        let message = format!("{half_angle} is out of range: expected more than 0 and less than 180 degrees");
        return Err(Error::input("mesh.sphere-cap.half_angle", message));
    }
    let (mut mesh, rim) = self::rings("mesh.sphere-cap.rings", rings, |t, angle| {
        let (sin, cos) = (half_angle.to_radians() * t).sin_cos();
        radius * Vector3::new(sin * angle.cos(), sin * angle.sin(), cos)
    })?;
    mesh.regions.insert("rim".into(), rim);
    mesh.regions.insert("apex".into(), Region::new([0], [], []));
    Ok(mesh)
}
