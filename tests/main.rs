//! The integration tests, in one binary: a test whose data or device is missing is shown as ignored.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::missing_assert_message,
    clippy::print_stdout,
    clippy::type_complexity,
    unreachable_pub,
    reason = "a test may fail by panic, reports its figures, and has no outside"
)]

mod agree;
mod analytic;
mod cameras;
mod charted;
mod cli;
mod clouds;
mod editing;
mod environment;
mod evenness;
mod extremes;
mod forms;
mod generate;
mod guided;
mod hostile;
mod ideal;
mod indirect;
mod leaks;
mod limits;
mod measured;
mod mesh;
mod npz;
mod oracle;
mod output;
mod overrides;
mod parts;
mod program;
mod quality;
mod ray_trace;
mod regions;
mod render;
mod rendered;
mod root_find;
mod roots;
mod scene;
mod searched;
mod shaders;
mod shown;
mod splats;
mod splatted;
mod support;
mod trends;
mod truth;
mod twins;
#[cfg(feature = "viewer")]
mod window;
mod written;

use libtest_mimic::Arguments;

fn main() {
    let trials = [
        agree::tests(),
        cameras::tests(),
        cli::tests(),
        clouds::tests(),
        editing::tests(),
        environment::tests(),
        evenness::tests(),
        extremes::tests(),
        generate::tests(),
        guided::tests(),
        hostile::tests(),
        indirect::tests(),
        leaks::tests(),
        limits::tests(),
        measured::tests(),
        mesh::tests(),
        oracle::tests(),
        output::tests(),
        overrides::tests(),
        parts::tests(),
        quality::tests(),
        regions::tests(),
        render::tests(),
        rendered::tests(),
        ray_trace::tests(),
        root_find::tests(),
        roots::tests(),
        scene::tests(),
        shaders::tests(),
        shown::tests(),
        splatted::tests(),
        splats::tests(),
        trends::tests(),
        truth::tests(),
        twins::tests(),
        written::tests(),
        #[cfg(feature = "viewer")]
        window::tests(),
    ]
    .into_iter()
    .flatten()
    .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
