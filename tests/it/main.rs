//! All integration tests in one binary.

mod shell_derivatives;
