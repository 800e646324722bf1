//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.

mod clouds;
mod output;

use libtest_mimic::Arguments;

fn main() {
    let trials = [clouds::tests(), output::tests()]
        .into_iter()
        .flatten()
        .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
