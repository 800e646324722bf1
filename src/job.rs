//! A handle on long work: progress out, cancellation in.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// Where the work stands: the step's name, what is done and what there is to do (any unit; total 0 = not known).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done, for a person: "reading", "estimating normals".
    pub step: &'static str,
    /// Done so far.
    pub done: u64,
    /// In all, or 0 where that is not known.
    pub total: u64,
}

type Listener = dyn Fn(Progress) + Send + Sync;

/// A handle that long work checks at every chunk. Clones share the same state.
#[derive(Clone, Default)]
pub struct Job {
    cancelled: Arc<AtomicBool>,
    listener: Option<Arc<Listener>>,
}

impl Job {
    /// A job that reports its progress to `listener`, from any thread.
    pub fn with_listener(listener: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self {
            cancelled: Arc::default(),
            listener: Some(Arc::new(listener)),
        }
    }

    /// Asks the work to stop. It ends with [`Error::Cancelled`] at its next chunk.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Job::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// [`Error::Cancelled`] once the job was cancelled.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }

    /// Tells the listener where the work stands, and checks for cancellation.
    pub fn progress(&self, step: &'static str, done: u64, total: u64) -> Result<()> {
        if let Some(listener) = &self.listener {
            listener(Progress { step, done, total });
        }
        self.check()
    }
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job")
            .field("cancelled", &self.is_cancelled())
            .finish_non_exhaustive()
    }
}
