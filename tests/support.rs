//! What the integration tests share.

use libtest_mimic::Trial;

/// A test that holds unless `check` panics.
pub(crate) fn claim(name: &'static str, check: fn()) -> Trial {
    Trial::test(name, move || {
        check();
        Ok(())
    })
}
