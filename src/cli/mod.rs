//! The command line: everything that speaks to a terminal.

use std::process::ExitCode;

use clap::Parser as _;

mod args;
mod generate;
mod info;
mod outputs;
mod render;
mod terminal;

use args::{Cli, Command};

/// A mistake on the command line, which ends with exit status 2.
#[derive(Debug)]
struct Usage(String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Runs the program with the arguments of the process.
pub(crate) fn run() -> ExitCode {
    terminal::show_warnings();
    let done = match Cli::parse().command {
        Command::Render(args) => render::render(&args),
        Command::Info(args) => info::info(&args),
        Command::Generate(args) => generate::generate(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::say(&format!("{error:#}"));
            ExitCode::from(if is_usage(&error) { 2 } else { 1 })
        }
    }
}

fn is_usage(error: &anyhow::Error) -> bool {
    error.is::<Usage>()
        || matches!(
            error.downcast_ref(),
            Some(catoptric::Error::Override { .. })
        )
}

/// Whether the reader of stdout has gone, as `head` does once it has what it wants.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
