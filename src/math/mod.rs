//! Ground floor: small kernels that know nothing of shells, meshes or files.

pub mod expression;
pub mod jet;
mod operator;
pub mod quadrature;

pub use expression::Expression;
pub use jet::Jet;
pub use quadrature::SurfacePoint;
