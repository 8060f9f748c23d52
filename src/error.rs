//! The errors a user can meet, and the exit code each of them means.
//!
//! Every fallible function of the library returns [`Result`]. The variants are few because a caller can do only four
//! things: mend the input, rerun a stage, change the numerics, or make room on the disk. This module does not print.

use std::path::{Path, PathBuf};

/// Result with the library's own [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What went wrong, in terms a user can act on.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum Error {
    /// A scene file that cannot be used, with the place in its text.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(Box<SceneError>),

    /// Any other input that cannot be used: a mesh file, a command line, a scene's consequence (a face, a region).
    #[error("{place}: {message}")]
    Input {
        /// File, key or stage that is at fault.
        place: String,
        /// What is wrong, with the value found and what was expected.
        message: String,
        /// What to do about it.
        #[help]
        help: Option<String>,
    },

    /// A case file that is missing, damaged, foreign or older than what it was made from.
    #[error("{}: {message}", path.display())]
    Stale {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
        /// The command that makes it anew.
        #[help]
        help: String,
    },

    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Verb, as in "cannot *write* FILE".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's own words.
        source: std::io::Error,
    },

    /// The equations could not be solved; the last good checkpoint is kept.
    #[error("{message}")]
    Numerical {
        /// What failed, when, and the size of the remaining error.
        message: String,
        /// What may help.
        #[help]
        help: Option<String>,
    },

    /// The run ended well but missed what its scene expects.
    #[error("{0}")]
    Missed(String),

    /// Stopped by a signal after a last checkpoint; holds the signal's number.
    #[error("stopped by signal {0} after a last checkpoint")]
    Interrupted(i32),
}

/// A fault in the text of a scene file.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{message}")]
pub struct SceneError {
    /// What was found and what was expected; names the key.
    pub message: String,
    /// The file's name and text.
    #[source_code]
    pub text: miette::NamedSource<String>,
    /// Where in the text.
    #[label("{label}")]
    pub span: Option<miette::SourceSpan>,
    /// Short text under the marked place.
    pub label: String,
    /// What to do about it.
    #[help]
    pub help: Option<String>,
}

impl Error {
    /// Input error without advice.
    pub fn input(place: impl Into<String>, message: impl Into<String>) -> Self {
        Error::Input { place: place.into(), message: message.into(), help: None }
    }

    /// Input error with advice on how to mend it.
    pub fn input_with_help(place: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Error::Input { place: place.into(), message: message.into(), help: Some(help.into()) }
    }

    /// Input/output error: `cannot {action} {path}: ...`.
    pub fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Error::Io { action, path: path.to_path_buf(), source }
    }

    /// Process exit code: 1 expectation missed, 2 bad input or stale file, 3 numerical failure, 128 + n for signal n.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Missed(_) => 1,
            Error::Scene(_) | Error::Input { .. } | Error::Stale { .. } | Error::Io { .. } => 2,
            Error::Numerical { .. } => 3,
            Error::Interrupted(signal) => 128 + *signal as u8,
        }
    }
}
