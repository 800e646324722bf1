//! The program `catoptric`: the library's way to the command line.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
