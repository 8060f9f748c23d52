//! One integration binary; each module tests one part.

mod mesh_generate;
