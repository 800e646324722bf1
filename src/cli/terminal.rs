//! The terminal: messages, progress, and the interrupt that cancels.

use std::io::{IsTerminal as _, Write as _};
use std::sync::Mutex;

use catoptric::cloud::Repairs;
use catoptric::text::printable;
use catoptric::{Job, Progress};
use indicatif::{ProgressBar, ProgressStyle};

/// One line on stderr; a closed stderr is nobody's concern.
pub(super) fn say(message: &str) {
    let _ = writeln!(std::io::stderr(), "catoptric: {}", printable(message));
}

/// Says what was dropped and changed, where something was.
pub(super) fn say_repairs(repairs: &Repairs) {
    let done = repairs.sentences();
    if !done.is_empty() {
        say(&done.join("; "));
    }
}

/// A job that Ctrl-C cancels and that shows its progress where stderr is a terminal.
pub(super) fn job() -> anyhow::Result<(Job, ProgressLine)> {
    let line = ProgressLine::new();
    let job = match &line.bar {
        Some(bar) => {
            let (bar, step) = (bar.clone(), Mutex::new(""));
            Job::with_listener(move |progress| show(&bar, &step, progress))
        }
        None => Job::default(),
    };
    let cancelled = job.clone();
    ctrlc::set_handler(move || cancelled.cancel())?;
    Ok((job, line))
}

/// The line that shows the progress; it is wiped when this goes.
pub(super) struct ProgressLine {
    bar: Option<ProgressBar>,
}

impl ProgressLine {
    fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner();
            bar.enable_steady_tick(std::time::Duration::from_millis(100));
            bar
        });
        Self { bar }
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn show(bar: &ProgressBar, step: &Mutex<&'static str>, progress: Progress) {
    let Ok(mut step) = step.lock() else { return };
    if *step != progress.step {
        *step = progress.step;
        bar.set_message(progress.step);
        let template = if progress.total > 0 {
            "{msg} {wide_bar} {percent} %"
        } else {
            "{spinner} {msg}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
    }
    bar.set_length(progress.total);
    bar.set_position(progress.done);
}

/// Shows the library's warnings; those of its dependencies are theirs.
struct Warnings;

impl log::Log for Warnings {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn && metadata.target().starts_with("catoptric")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            say(&format!("{}", record.args()));
        }
    }

    fn flush(&self) {}
}

/// Sends the library's warnings to stderr.
pub(super) fn show_warnings() {
    // A second call would find the first one's logger, which is the same.
    if log::set_logger(&Warnings).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}
