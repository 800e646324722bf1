//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.

mod analytic;
mod evenness;
mod generate;
mod mesh;
mod npz;
mod oracle;
mod output;

use libtest_mimic::Arguments;

fn main() {
    let trials = [
        generate::tests(),
        mesh::tests(),
        oracle::tests(),
        output::tests(),
    ];
    let trials = trials.into_iter().flatten().collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
