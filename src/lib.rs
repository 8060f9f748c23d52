//! thinshell: thin shells whose rest shape changes, from a TOML scene to VTK files and a report.
//!
//! # What is where
//!
//! Imports point down this table, and a test reads them.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`cli`] | verbs and flags |
//! | [`stage`] | one file per verb: check, mesh, setup, run, modes, export, report, status, all; `build` turns a scene into objects |
//! | [`case`] | a case's files: HDF5 (atomic, sealed by a checksum), history, VTK, hashes of inputs |
//! | [`report`] | distances, norms, rates, fitted curvatures, tables of error against run time |
//! | [`model`] | a shell or a surface on a grid with its loads, supports and rest driver, advanced step by step |
//! | [`solve`] | Newton's method, descent, dynamic relaxation, the way off unstable equilibria, paths by arc length, modes of vibration and buckling, step sizes |
//! | [`shell`] | elements, hinges, rest forms, materials, the Koiter energy, mass |
//! | [`cosserat`] | a Cosserat surface on a grid: forms, constants, energy, finite differences |
//! | [`load`] | forces on nodes |
//! | [`moisture`] | diffusion of moisture and heat in layers of prisms over the faces |
//! | [`mesh`] | triangles, generators, file import, quality |
//! | [`sparse`] | potentials, pattern, assembly into slots, factorisation, eigenvalues |
//! | [`scene`] | what a scene file may say |
//! | [`math`] | expressions |
//! | [`snapshot`], [`error`] | named fields at one moment, which models and files share; what can go wrong |
//!
//! A case is a folder and a stage is a command: `mesh` writes `mesh.h5`, `setup` writes `setup.h5`, `run` writes `run/step_NNNNNNNN.h5` and
//! `history.csv`, `modes` writes `modes.h5` and `modes.json`, `export` writes `vtk/`, `report` writes `report.json` and `report.md`. Each file carries the hash of what it was made from.
//!
//! # Notation
//!
//! | code | meaning | unit |
//! | --- | --- | --- |
//! | `r1`, `r2` | tangent vectors `v1 - v0`, `v2 - v0` of a face | m |
//! | `a` | first fundamental form, `r_i . r_j`, by components 11, 12, 22 | m2 |
//! | `b` | second fundamental form, `-dr.dn`: a sphere with outward normals has `b = -a/R` | m |
//! | `abar`, `bbar` | rest forms | m2, m |
//! | `h`, `E`, `nu` | thickness, Young's modulus, Poisson's ratio | m, Pa, 1 |
//! | `E1`, `E2`, `nu12`, `G12` | moduli along (1) and across (2) the machine direction | Pa, 1, Pa |
//! | `lambda`, `mu` | Lame parameters of a body, of the neo-Hookean law (elsewhere `mu` is a swelling coefficient) | Pa |
//! | `alpha`, `beta` | plane-stress Lame parameters `E nu / (1 - nu^2)`, `E / (2 (1 + nu))` | Pa |
//! | `p`, `phi` | frozen reference of an edge's director and the director's angle from it, turning about the edge | 1, rad |
//! | `m+`, `m-` | additional moisture at the top (the side of the normal) and the bottom | % |
//! | `eta` | viscosity over modulus | s |
//! | `a1`, `a2`, `G`, `B` | material coordinates of a grid and the two forms in them, `G_ij = r_i . r_j`, `B_ij = n . r_ij` | m, 1, 1/m |
//! | `eps`, `kappa` | `(G - G0)/2`, `-(B - B0)` | 1, 1/m |
//! | `u`, `D` | what diffuses (moisture, heat) and its diffusivity | the caller's, m2/s |
//!
//! # How to add a physical effect
//!
//! One file with a [`sparse::Potential`] (energy, gradient, Hessian, couplings), one table in [`scene`], one arm in `stage::build`, its tests
//! and its smallest scene. Nothing else changes: pattern, solver, checkpoints and absence follow from the list of potentials. A growth law is
//! a [`shell::rest::Law`], a function of a point; a material is a kind of [`shell::Constitution`], a function of the six forms; an element is a [`shell::Element`] with its number of unknowns and points.
//!
//! # Known gaps
//!
//! Contact, incompressible rubber and branches of paths are not here yet. A moment on edges that may tilt out of
//! their plane has no stiffness of its own in the matrix, so large ones converge only where the shell is held in its plane, and modes of buckling do not
//! see it. Supports hold coordinates along the axes; a slanted plane of symmetry needs a mesh that is turned. The air of [`load::Wind`] is not moved by the shell.
//!
//! # Sources
//!
//! Chen et al. 2018: Chen, Sastry, van Rees and Vouga, *Physical Simulation of Environmentally Induced Thin Shell Deformation*, ACM Transactions on
//! Graphics 37(4); sections are those of its draft, *Physical Simulation of Moisture Induced Thin Shell Deformation*. Its formulas are followed where
//! they are right; where a sign or a factor in print is not, the module that uses it has the right one. Wu and de Melo: Wu Shin-Ting and Vanio Fragoso de
//! Melo, *A Deformable Surface Model on the basis of the Theory of a Cosserat Surface*, formulas by its numbers.

// Docs write units in brackets, as in `[m]`; they are not links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod case;
pub mod cli;
pub mod cosserat;
pub mod error;
pub mod load;
pub mod math;
pub mod mesh;
pub mod model;
pub mod moisture;
pub mod report;
pub mod scene;
pub mod shell;
pub mod snapshot;
pub mod solve;
pub mod sparse;
pub mod stage;

pub use error::{Error, Result};
