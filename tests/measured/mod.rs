//! The commands that measure: what they write, what they refuse, and that their figures are those of an independent program.

mod compare;
mod sweep;
mod truth;
mod tune;

use libtest_mimic::Trial;

pub(crate) fn tests() -> Vec<Trial> {
    [
        compare::tests(),
        sweep::tests(),
        tune::tests(),
        truth::tests(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
