//! The program `catoptric`: the library's way to the command line.

mod cli;
#[cfg(feature = "viewer")]
mod viewer;

fn main() -> std::process::ExitCode {
    cli::run()
}
