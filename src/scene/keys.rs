//! The keys of a scene, and the right one nearest to a wrong one.

use crate::settings::Settings;

/// Keys of the document.
pub(super) const ROOT: &[&str] = &[
    "format",
    "cloud",
    "mirror",
    "light",
    "environment",
    "clip",
    "camera",
    "settings",
];
/// Keys of a `[[cloud]]`.
pub(super) const CLOUD: &[&str] = &[
    "path",
    "generate",
    "points",
    "seed",
    "mesh",
    "up_axis",
    "colour_bits",
    "transform",
    "material",
    "colour",
    "visible",
    "viewpoint",
    "mirror",
];
/// Keys of a cloud's `material`.
pub(super) const MATERIAL: &[&str] = &["specular", "shininess"];
/// Keys of a `[[cloud.mirror]]`: which points are mirrors.
pub(super) const RULE: &[&str] = &[
    "property",
    "classification",
    "box",
    "near_plane",
    "reflectance",
];
/// Those of them that choose points; a rule has one.
pub(super) const SELECTIONS: &[&str] = &["property", "classification", "box", "near_plane"];
/// Keys of a rule's `box`, and of `[clip]`.
pub(super) const BOX: &[&str] = &["min", "max"];
/// Keys of a rule's `near_plane`.
pub(super) const NEAR_PLANE: &[&str] = &["point", "normal", "distance", "within"];
/// Keys of a `[[light]]`.
pub(super) const LIGHT: &[&str] = &[
    "kind",
    "position",
    "target",
    "intensity",
    "inner_angle_degrees",
    "outer_angle_degrees",
];
/// Keys of `[environment]`.
pub(super) const ENVIRONMENT: &[&str] = &["colour", "zenith", "horizon", "map"];
/// Keys of `[camera]`.
pub(super) const CAMERA: &[&str] = &[
    "position",
    "target",
    "up",
    "fov_y_degrees",
    "near",
    "far",
    "size",
];
/// The shapes of a `[[mirror]]`, and the keys of each besides `shape`.
pub(super) const SHAPES: &[(&str, &[&str])] = &[
    ("plane", &["centre", "normal", "up", "size"]),
    ("sphere", &["centre", "radius"]),
    (
        "paraboloid",
        &["vertex", "axis", "focal_length", "rim_radius"],
    ),
    ("torus", &["centre", "axis", "major_radius", "minor_radius"]),
    ("blob", &["centre", "radius", "amplitude"]),
    ("bumps", &["centre", "radius"]),
    ("mesh", &["path"]),
];

/// Every key that can be given on top of a scene, N in place of an index.
pub(super) fn patterns() -> Vec<String> {
    let under = |prefix: &str, keys: &[&str]| {
        keys.iter()
            .map(|k| format!("{prefix}.{k}"))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<String> = Settings::describe().into_iter().map(|d| d.key).collect();
    all.extend(under("camera", CAMERA));
    all.extend(under("environment", ENVIRONMENT));
    all.extend(under("clip", BOX));
    all.extend(
        under("cloud.N", CLOUD)
            .into_iter()
            .filter(|k| k != "cloud.N.mirror"),
    );
    all.extend(under("cloud.N.material", MATERIAL));
    all.extend(under("cloud.N.mirror.N", RULE));
    all.extend(under("cloud.N.mirror.N.box", BOX));
    all.extend(under("cloud.N.mirror.N.near_plane", NEAR_PLANE));
    all.extend(under("cloud.N.mirror.N.near_plane.within", BOX));
    all.extend(under("light.N", LIGHT));
    let mut shape_keys: Vec<&str> = SHAPES
        .iter()
        .flat_map(|(_, keys)| keys.iter().copied())
        .chain(["shape"])
        .collect();
    shape_keys.sort_unstable();
    shape_keys.dedup();
    all.extend(under("mirror.N", &shape_keys));
    all
}

/// The key with its indices replaced by N, and these indices.
pub(super) fn pattern_of(key: &str) -> (String, Vec<&str>) {
    let mut indices = Vec::new();
    let segments: Vec<&str> = key
        .split('.')
        .map(|s| {
            if !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit()) {
                indices.push(s);
                "N"
            } else {
                s
            }
        })
        .collect();
    (segments.join("."), indices)
}

/// The right key nearest to the wrong dotted key `given`, with the indices that were given; `None` where none is near.
pub(super) fn nearest_key(given: &str) -> Option<String> {
    let (pattern, indices) = pattern_of(given.strip_prefix("settings.").unwrap_or(given));
    let all = patterns();
    let nearest = nearest(&pattern, all.iter().map(String::as_str))?;
    let mut indices = indices.into_iter();
    let segments: Vec<&str> = nearest
        .split('.')
        .map(|s| {
            if s == "N" {
                indices.next().unwrap_or("0")
            } else {
                s
            }
        })
        .collect();
    Some(segments.join("."))
}

/// The candidate that `given` is a typing error or the beginning of; the first of equals.
pub(super) fn nearest<'a>(
    given: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    let edits = |candidate: &str| {
        let edits = strsim::damerau_levenshtein(given, candidate);
        // Farther than a third of the length, it is another word.
        let length = given.chars().count().min(candidate.chars().count());
        (edits * 3 <= length).then_some(edits as f64)
    };
    let distance = |candidate: &'a str| {
        // A beginning ("fov") means its whole.
        if given.len() >= 3
            && candidate
                .strip_prefix(given)
                .is_some_and(|rest| !rest.contains('.'))
        {
            return Some(0.5);
        }
        // Whoever leaves the group out ("exposure") means the key by its last part.
        let last = candidate.rsplit('.').next().unwrap_or(candidate);
        edits(candidate).or_else(|| {
            let edits = strsim::damerau_levenshtein(given, last);
            (edits <= 1 && given.len() >= 3).then_some(edits as f64 + 0.5)
        })
    };
    candidates
        .filter_map(|candidate| Some((candidate, distance(candidate)?)))
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(candidate, _)| candidate)
}

/// The advice to write `nearest`.
pub(super) fn did_you_mean(nearest: &str) -> String {
    format!("did you mean {nearest:?}?")
}

/// Names for a sentence: `"a", "b" or "c"`.
pub(super) fn alternatives(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("{one:?}"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|n| format!("{n:?}")).collect();
            format!("{} or {last:?}", first.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_key_of_a_typing_error_is_the_one_meant() {
        for (given, meant) in [
            ("splat.sise", "splat.size"),
            ("exposure", "image.exposure"),
            ("camera.pos", "camera.position"),
            ("cloud.3.pth", "cloud.3.path"),
            (
                "cloud.1.mirror.2.reflectence",
                "cloud.1.mirror.2.reflectance",
            ),
            ("camera.fov", "camera.fov_y_degrees"),
            ("light.0.intensty", "light.0.intensity"),
            ("settings.image.tonemap", "image.tone_map"),
        ] {
            assert_eq!(nearest_key(given).as_deref(), Some(meant), "for {given}");
        }
        for given in ["format", "cloud", ".", "banana", "image.banana"] {
            assert_eq!(nearest_key(given), None, "for {given}");
        }
    }

    #[test]
    fn every_key_is_documented() {
        let documentation = include_str!("../../docs/SCENE_FILES.md");
        let undocumented = |key: &str| {
            let [alone, of_table] = [format!("`{key}`"), format!(" {key}")];
            !documentation.contains(&alone) && !documentation.contains(&of_table)
        };
        let settings: Vec<String> = Settings::describe().into_iter().map(|d| d.key).collect();
        let missing: Vec<String> = patterns()
            .into_iter()
            .filter(|key| !settings.contains(key))
            .filter(|key| key.rsplit('.').next().is_some_and(undocumented))
            .collect();
        assert!(missing.is_empty(), "docs/SCENE_FILES.md lacks {missing:?}");
        assert!(
            undocumented("colour_bitz"),
            "a key that is not there is missed"
        );
    }

    #[test]
    fn names_are_listed_as_a_person_would() {
        assert_eq!(alternatives(&["a", "b", "c"]), "\"a\", \"b\" or \"c\"");
        assert_eq!(alternatives(&["a"]), "\"a\"");
    }
}
