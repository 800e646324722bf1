//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::missing_assert_message,
    reason = "a test may fail by panic"
)]

mod analytic;
mod evenness;
mod generate;
mod npz;
mod oracle;
mod output;
mod regions;

use libtest_mimic::Arguments;

fn main() {
    let trials = [
        oracle::tests(),
        generate::tests(),
        output::tests(),
        regions::tests(),
    ]
    .into_iter()
    .flatten()
    .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
