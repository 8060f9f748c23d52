//! Ground floor: small kernels that know nothing of shells, meshes or files.

pub mod expression;

pub use expression::Expression;
