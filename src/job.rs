//! A handle on long work: progress out, cancellation in.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

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
    deadline: Option<Instant>,
    listener: Option<Arc<Listener>>,
}

impl Job {
    /// A job that reports its progress to `listener`, from any thread.
    pub fn with_listener(listener: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self {
            cancelled: Arc::default(),
            deadline: None,
            listener: Some(Arc::new(listener)),
        }
    }

    /// The same job, which counts as cancelled from `deadline` on: for measuring, where what takes longer is of no use.
    pub fn until(&self, deadline: Instant) -> Self {
        Self {
            deadline: Some(deadline),
            ..self.clone()
        }
    }

    /// Asks the work to stop. It ends with [`Error::Cancelled`] at its next chunk.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Job::cancel`] was called, or the deadline is over.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.deadline.is_some_and(|d| Instant::now() >= d)
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_deadline_ends_its_own_job_alone() {
        let job = Job::default();
        let over = job.until(Instant::now());
        let later = job.until(Instant::now() + Duration::from_secs(1000));
        assert!(over.check().is_err() && later.check().is_ok() && job.check().is_ok());
        job.cancel();
        assert!(later.check().is_err(), "it is still the same job");
    }
}
