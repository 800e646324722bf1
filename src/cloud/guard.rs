//! Decoders of others, run so that their panics and their appetite for memory become sentences.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use crate::error::{Error, Result};

/// Assumed where the system does not say how much memory is free.
const UNKNOWN_MEMORY: u64 = 16 << 30;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder; a panic in it becomes an error that names the file, and prints nothing.
///
/// The process's panic hook is wrapped once, in a way that passes on every panic of every other thread, and every
/// panic of this thread outside of the decoder.
pub(super) fn guarded<T>(path: &Path, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    static WRAP_HOOK: Once = Once::new();
    WRAP_HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.try_with(Cell::get).unwrap_or(false) {
                previous(info);
            }
        }));
    });
    let outer = QUIET.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(decode));
    QUIET.set(outer);
    outcome.unwrap_or_else(|_| {
        Err(Error::cloud(
            path,
            "its data are damaged beyond what the decoder understands",
        ))
    })
}

/// [`Error::Memory`] where `needed` bytes are more than the system can give now.
pub(crate) fn require_memory(what: &str, needed: u64) -> Result<()> {
    let budget = available_memory().unwrap_or(UNKNOWN_MEMORY);
    if needed > budget {
        Err(Error::Memory {
            what: what.to_owned(),
            needed,
            budget,
        })
    } else {
        Ok(())
    }
}

fn available_memory() -> Option<u64> {
    let number = |path: &str| {
        std::fs::read_to_string(path)
            .ok()?
            .trim()
            .parse::<u64>()
            .ok()
    };
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let free = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10;

    // A container may have less than its machine, and a process less than either (`ulimit -v`).
    let limit = number("/sys/fs/cgroup/memory.max").zip(number("/sys/fs/cgroup/memory.current"));
    let free = limit.map_or(free, |(max, used)| free.min(max.saturating_sub(used)));
    Some(address_space().map_or(free, |left| free.min(left)))
}

/// Bytes of address space that the process may still take, where that is limited.
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let limit = (limits
        .lines()
        .find_map(|l| l.strip_prefix("Max address space")))?
    .split_whitespace()
    .next()?;
    let limit = limit.parse::<u64>().ok()?;
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let used = status.lines().find_map(|l| l.strip_prefix("VmSize:"))?;
    let used = used.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10;
    Some(limit.saturating_sub(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_a_decoder_is_an_error() {
        let outcome = guarded::<()>(Path::new("a.las"), || panic!("decoder"));
        assert!(
            matches!(outcome, Err(Error::Cloud { .. })),
            "got {outcome:?}"
        );
        assert!(!QUIET.get(), "the thread must be heard again");
    }

    #[test]
    fn more_memory_than_any_machine_has_is_refused() {
        let outcome = require_memory("a test", u64::MAX / 2);
        assert!(
            matches!(outcome, Err(Error::Memory { .. })),
            "got {outcome:?}"
        );
        assert!(
            require_memory("a test", 1 << 10).is_ok(),
            "a kilobyte must be fine"
        );
    }
}
