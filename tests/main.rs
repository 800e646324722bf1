//! Every integration test, in one binary.

mod analytic;
mod evenness;
mod generate;
mod mesh;
mod npz;
mod oracle;

use libtest_mimic::Arguments;

fn main() {
    let trials = [oracle::tests(), generate::tests(), mesh::tests()]
        .into_iter()
        .flatten()
        .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit()
}
