//! Diffusion of moisture, or heat, in the volume of a shell: `du/dt = div(D grad u) + s` (Chen et al. 2018, section 4).
//!
//! Six-node prisms are stacked in layers over the faces. With one metric a face, each prism is the product of a triangle and a line: its
//! stiffness is `A x M_line + M x K_line`, its mass `M x M_line`, with exact integrals. The geometry is that of the rest state, so bending
//! a sheet does not change how fast it dries, and it is linear in the sheet under the quadratic element too.
//!
//! [`Slab`] says what the shell is, [`Condition`] what happens on its surface, [`Diffusion`] advances the values. Unknown of vertex `v` at
//! level `l`: `v * levels + l`; level 0 is the bottom, the last one the top, the side of the normal. The unit of `u` is the caller's.
//!
//! Not here: what moisture does to rest forms and mass, scenes, the present shape. Two sides that touch do not exchange anything.

mod condition;
mod diffusion;
mod operator;
mod slab;

pub use condition::{Condition, Data, Law, Side, Source, Where};
pub use diffusion::{Balance, Diffusion, Scheme};
pub use slab::{Mass, Slab, cosine_levels, in_plane_tensor};
