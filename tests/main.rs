//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.

#![allow(
    clippy::expect_used,
    clippy::missing_assert_message,
    clippy::panic,
    clippy::unwrap_used,
    reason = "tests fail by them, and these are not marked as tests where clippy would see it"
)]

mod output;
mod scene;
mod support;

use libtest_mimic::Arguments;

fn main() {
    let trials = [output::tests(), scene::tests()]
        .into_iter()
        .flatten()
        .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
