//! Ground floor: small kernels that know nothing of shells, meshes or files.

pub mod expression;
pub mod quadrature;

pub use expression::Expression;
pub use quadrature::SurfacePoint;
