//! What can go wrong, said from the user's side.

use std::path::{Path, PathBuf};

/// What can go wrong. Every message is one sentence, with the remedy where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be opened or read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file could not be written; nothing was left behind.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system or the encoder said.
        source: std::io::Error,
    },
    /// A point file is broken or of a kind that is not read.
    #[error("{}: {problem}", path.display())]
    Cloud {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and the remedy.
        problem: String,
    },
    /// A scene file says something that cannot be done.
    #[error("{}{}: {problem}", path.display(), line.map_or(String::new(), |l| format!(":{l}")))]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// The line, counted from 1, where it is known.
        line: Option<usize>,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// A key or value given by the caller is wrong.
    #[error("{0}")]
    Setting(String),
    /// A key or value given on top of the scene is wrong, or of no use in it.
    #[error("{given}: {problem}")]
    Override {
        /// How it was given: "--set splat.size=2".
        given: String,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// There is no point to draw.
    #[error("the scene has no points left to draw; {0}")]
    NoPoints(String),
    /// No graphics adapter, or none of that name.
    #[error("{0}")]
    NoAdapter(String),
    /// The graphics device failed.
    #[error("the graphics device failed: {0}; try --backend cpu")]
    Gpu(String),
    /// The work needs more memory than the budget allows.
    #[error("{what} needs {} MiB, and {} MiB are available; use fewer points or a smaller picture", needed >> 20, budget >> 20)]
    Memory {
        /// What the memory is for.
        what: String,
        /// Bytes.
        needed: u64,
        /// Bytes.
        budget: u64,
    },
    /// The caller cancelled the work; nothing was written.
    #[error("cancelled; nothing was written")]
    Cancelled,
}

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// A broken or unreadable point file.
    pub(crate) fn cloud(path: &Path, problem: impl Into<String>) -> Self {
        Self::Cloud {
            path: path.to_owned(),
            problem: problem.into(),
        }
    }
}
