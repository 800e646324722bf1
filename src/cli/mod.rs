//! The command line: everything that speaks to a terminal.

use std::process::ExitCode;

use clap::Parser as _;
use clap::error::ErrorKind;

mod args;
mod compare;
mod experiment;
mod folder;
mod generate;
mod info;
mod outputs;
mod render;
mod sweep;
mod terminal;
mod tune;
#[cfg(feature = "viewer")]
mod view;

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
    let done = match Cli::try_parse() {
        Ok(cli) => match cli.command {
            Command::Render(args) => render::render(&args),
            #[cfg(feature = "viewer")]
            Command::View(args) => view::view(&args),
            Command::Info(args) => info::info(&args),
            Command::Generate(args) => generate::generate(&args),
            Command::Compare(args) => compare::compare(&args),
            Command::Sweep(args) => sweep::sweep(&args),
            Command::Tune(args) => tune::tune(&args),
        },
        Err(refusal) if refusal.use_stderr() => Err(Usage(sentence(&refusal)).into()),
        // Not a refusal: the text of --help or --version.
        Err(help) => help.print().map_err(anyhow::Error::from),
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

/// What clap refuses, in one line: its message and its advice, without the usage that `--help` shows.
fn sentence(refusal: &clap::Error) -> String {
    if refusal.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "what is to be done is missing; see catoptric --help".into();
    }
    let text = refusal.render().to_string();
    // The usage line alone tells which command lacks something.
    if refusal.kind() == ErrorKind::MissingRequiredArgument
        && text.contains("Usage: catoptric info")
    {
        return "name a scene or a point cloud, or ask for --settings; see catoptric info --help"
            .into();
    }
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"));
    let parts: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !line.starts_with("For more information"))
        .collect();
    let message = parts.join("; ").replace(":;", ":");
    format!(
        "{}; see catoptric --help",
        message.strip_prefix("error: ").unwrap_or(&message)
    )
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
