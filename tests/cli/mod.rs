//! The program's manners: exit status, messages, help, interrupts.

mod outside;
mod refusals;
mod said;

use libtest_mimic::Trial;

pub(crate) fn tests() -> Vec<Trial> {
    [said::tests(), refusals::tests(), outside::tests()]
        .into_iter()
        .flatten()
        .collect()
}
