//! Ground floor: small kernels that know nothing of shells, meshes or files.

pub mod expression;
pub mod jet;
mod normal_component;
mod operator;
pub mod quadrature;
mod rigid_fit;

pub use expression::Expression;
pub use jet::Jet;
pub use normal_component::TangentPlane;
pub use quadrature::SurfacePoint;
pub use rigid_fit::rigid_fit;
