//! Which settings do nothing for what is chosen.

use crate::reflect::Method;
use crate::reflect::sscr::{Closing, OF_GUIDED, OF_INTERLEAVED, Search};
use crate::settings::Settings;

/// Whether a setting, by its dotted name, changes nothing of a picture with these settings, whatever it is.
pub(super) fn is_idle(key: &str, settings: &Settings) -> bool {
    let (method, sscr) = (settings.reflect.method, &settings.sscr);
    let interleaved = method == Method::Sscr && sscr.search == Search::Interleaved;
    let searches = method != Method::RayTrace;
    match key {
        _ if OF_INTERLEAVED.contains(&key) => !interleaved,
        _ if OF_GUIDED.contains(&key) => interleaved || !searches,
        "sscr.search" => method != Method::Sscr,
        "sscr.pull_levels" => !searches || sscr.closing != Closing::PullPush,
        _ if key.starts_with("sscr.") => !searches,
        _ if key.starts_with("ray_trace.") => {
            method == Method::Sscr && sscr.closing != Closing::Rays
        }
        _ => false,
    }
}

/// Whether a setting changes only what mirrors show: the light that meets it costs the same.
pub(super) fn is_of_mirrors(key: &str) -> bool {
    ["reflect.", "sscr.", "lhc.", "ray_trace."]
        .iter()
        .any(|group| key.starts_with(group))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_search_heeds_is_idle() {
        let mut settings = Settings::default();
        let idle = |settings: &Settings| {
            [
                "sscr.max_steps",
                "sscr.points_per_pixel",
                "sscr.search",
                "sscr.pull_levels",
            ]
            .map(|key| is_idle(key, settings))
        };
        assert_eq!(idle(&settings), [true, false, false, false], "guided");
        settings.sscr.search = Search::Interleaved;
        assert_eq!(idle(&settings), [false, true, false, false], "interleaved");
        settings.reflect.method = Method::Auto;
        assert_eq!(idle(&settings), [true, false, true, false], "auto");
        settings.reflect.method = Method::RayTrace;
        assert_eq!(idle(&settings), [true; 4], "traced rays");
        assert!(!is_idle("splat.size", &settings) && !is_of_mirrors("splat.size"));
    }
}
