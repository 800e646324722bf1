//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.

mod shaders;
mod twins;

use libtest_mimic::Arguments;

fn main() {
    let trials = vec![shaders::tests(), twins::tests()].concat();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
