//! Which points are mirrors: by a column of their file, by their class, or by where they are.

use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use super::{Bounds, RawCloud};
use crate::error::{Error, Result};

/// Names under which the class of a point goes.
pub(super) const CLASSIFICATION: &str = "classification";

/// Letters by which a name may be off and still be suggested.
const SUGGEST_WITHIN: usize = 3;

/// Makes mirrors of the points that it selects. Where several rules select a point, the largest reflectance counts.
#[derive(Debug, Clone, PartialEq)]
pub struct MirrorRule {
    /// Which points.
    pub select: Select,
    /// 0 to 1: the weight of the mirror picture over the point's own diffuse part.
    pub reflectance: f32,
}

/// A choice of points.
#[derive(Debug, Clone, PartialEq)]
pub enum Select {
    /// Those whose column of that name is not 0 (and is a number).
    Property(String),
    /// Those of one of these classes.
    Classification(Vec<u8>),
    /// Those in this box, borders included; in the scene's frame.
    Box {
        /// Smallest corner.
        min: DVec3,
        /// Largest corner.
        max: DVec3,
    },
    /// Those that are this near to a plane; in the scene's frame.
    NearPlane {
        /// A point of the plane.
        point: DVec3,
        /// Need not be of unit length.
        normal: DVec3,
        /// Largest distance to either side, in the files' unit.
        distance: f64,
        /// Only in this box, borders included, where there is one.
        within: Option<Bounds>,
    },
}

impl Select {
    /// The column that a reader must keep for it ([`super::ReadOptions::columns`]).
    pub fn column(&self) -> Option<&str> {
        match self {
            Self::Property(name) => Some(name),
            Self::Classification(_) => Some(CLASSIFICATION),
            Self::Box { .. } | Self::NearPlane { .. } => None,
        }
    }
}

/// The name in `names` that `wanted` means: the same, or but for its case, or but for the prefix that CloudCompare
/// gives to scalar fields.
pub(super) fn find_column<'a>(names: &'a [String], wanted: &str) -> Option<&'a str> {
    let exact = names.iter().find(|name| *name == wanted);
    let any_case = || names.iter().find(|name| name.eq_ignore_ascii_case(wanted));
    let prefixed = || {
        names.iter().find(|name| {
            let prefix = name
                .get(.."scalar_".len())
                .is_some_and(|prefix| prefix.eq_ignore_ascii_case("scalar_"));
            prefix
                && name
                    .get("scalar_".len()..)
                    .is_some_and(|rest| rest.eq_ignore_ascii_case(wanted))
        })
    };
    exact
        .or_else(any_case)
        .or_else(prefixed)
        .map(String::as_str)
}

/// Mirror reflectance of every point of `cloud`, whose `positions` are in the scene's frame; `None` where no point is
/// one. The file's own `mirror` column counts by itself unless a rule selects by it.
pub(super) fn mirror_column(
    cloud: &RawCloud,
    positions: &[DVec3],
    rules: &[MirrorRule],
    name: &str,
) -> Result<Option<Vec<f32>>> {
    let selects_own = |rule: &MirrorRule| matches!(&rule.select, Select::Property(p) if p.eq_ignore_ascii_case("mirror"));
    let own = cloud
        .mirror
        .as_ref()
        .filter(|_| !rules.iter().any(selects_own));
    if own.is_none() && rules.is_empty() {
        return Ok(None);
    }
    let mut mirror = own.cloned().unwrap_or_else(|| vec![0.0; positions.len()]);
    for rule in rules {
        let reflectance = rule.reflectance;
        match &rule.select {
            Select::Property(column) => {
                let values = column_of(cloud, column, "a mirror rule", name)?;
                mirror
                    .par_iter_mut()
                    .zip(values)
                    .for_each(|(mirror, &value)| {
                        if value != 0.0 && !value.is_nan() {
                            *mirror = mirror.max(reflectance);
                        }
                    });
            }
            Select::Classification(classes) => {
                let values = column_of(cloud, CLASSIFICATION, "a mirror rule", name)?;
                mirror
                    .par_iter_mut()
                    .zip(values)
                    .for_each(|(mirror, &value)| {
                        if classes.iter().any(|&class| f32::from(class) == value) {
                            *mirror = mirror.max(reflectance);
                        }
                    });
            }
            Select::Box { min, max } => select_places(&mut mirror, positions, reflectance, |p| {
                p.cmpge(*min).all() && p.cmple(*max).all()
            }),
            Select::NearPlane {
                point,
                normal,
                distance,
                within,
            } => {
                let unit = normal.try_normalize().ok_or_else(|| {
                    Error::Setting(format!(
                        "a mirror rule of {name} states a plane whose normal has no length"
                    ))
                })?;
                select_places(&mut mirror, positions, reflectance, |p| {
                    (p - *point).dot(unit).abs() <= *distance
                        && within.is_none_or(|within| within.contains(p))
                });
            }
        }
    }
    Ok(Some(mirror))
}

fn select_places(
    mirror: &mut [f32],
    positions: &[DVec3],
    reflectance: f32,
    inside: impl Fn(DVec3) -> bool + Sync,
) {
    mirror
        .par_iter_mut()
        .zip(positions)
        .for_each(|(mirror, &position)| {
            if inside(position) {
                *mirror = mirror.max(reflectance);
            }
        });
}

/// The column of that name, or an error that says who asks and names those there are.
pub(super) fn column_of<'a>(
    cloud: &'a RawCloud,
    wanted: &str,
    asker: &str,
    name: &str,
) -> Result<&'a [f32]> {
    let own = [
        ("mirror", &cloud.mirror),
        ("specular", &cloud.specular),
        ("shininess", &cloud.shininess),
        ("radius", &cloud.radii),
        ("intensity", &cloud.intensity),
    ];
    let kept = cloud
        .columns
        .iter()
        .find(|(column, _)| column.eq_ignore_ascii_case(wanted));
    let own = own.into_iter().find_map(|(column, values)| {
        values
            .as_ref()
            .filter(|_| column.eq_ignore_ascii_case(wanted))
    });
    kept.map(|(_, values)| values)
        .or(own)
        .map(Vec::as_slice)
        .ok_or_else(|| missing_column(cloud, wanted, asker, name))
}

fn missing_column(cloud: &RawCloud, wanted: &str, asker: &str, name: &str) -> Error {
    let there = &cloud.column_names;
    let distance =
        |other: &String| strsim::levenshtein(&other.to_lowercase(), &wanted.to_lowercase());
    let nearest = there
        .iter()
        .map(|other| (distance(other), other))
        .min_by_key(|(distance, _)| *distance);
    let hint = match nearest {
        Some((distance, nearest)) if distance <= SUGGEST_WITHIN => {
            format!("; did you mean `{nearest}`?")
        }
        _ => String::new(),
    };
    let list = if there.is_empty() {
        "none".to_owned()
    } else {
        there.join(", ")
    };
    let problem =
        format!("{asker} asks for its column `{wanted}`, which it lacks{hint} (it has: {list})");
    Error::cloud(Path::new(name), problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> RawCloud {
        RawCloud {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 0.0, 0.5)],
            columns: [("classification".to_owned(), vec![1.0, 7.0, 2.0])].into(),
            column_names: ["x", "y", "z", "classification"]
                .map(str::to_owned)
                .to_vec(),
            ..RawCloud::default()
        }
    }

    fn mirrors(cloud: &RawCloud, rules: &[MirrorRule]) -> Option<Vec<f32>> {
        mirror_column(cloud, &cloud.positions, rules, "a.ply").unwrap()
    }

    #[test]
    fn rules_add_up_and_the_largest_reflectance_wins() {
        let cloud = cloud();
        let classes = MirrorRule {
            select: Select::Classification(vec![7, 9]),
            reflectance: 0.5,
        };
        let plane = Select::NearPlane {
            point: DVec3::ZERO,
            normal: DVec3::Z * 3.0,
            distance: 0.1,
            within: None,
        };
        let plane = MirrorRule {
            select: plane,
            reflectance: 0.25,
        };
        let space = MirrorRule {
            select: Select::Box {
                min: DVec3::ZERO,
                max: DVec3::Z * 0.5,
            },
            reflectance: 0.75,
        };
        assert_eq!(
            mirrors(&cloud, &[classes.clone(), plane.clone()]),
            Some(vec![0.25, 0.5, 0.0])
        );
        assert_eq!(
            mirrors(&cloud, &[plane, classes, space]),
            Some(vec![0.75, 0.5, 0.75])
        );
        assert_eq!(mirrors(&cloud, &[]), None);
    }

    #[test]
    fn a_plane_may_end_at_a_box() {
        let cloud = RawCloud {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(2.0, 0.0, 1.0)],
            ..RawCloud::default()
        };
        let within = |max: f64| MirrorRule {
            select: Select::NearPlane {
                point: DVec3::ZERO,
                normal: DVec3::Z,
                distance: 0.1,
                within: Some(Bounds {
                    min: DVec3::splat(-0.5),
                    max: DVec3::splat(max),
                }),
            },
            reflectance: 1.0,
        };
        let marked = |max| mirrors(&cloud, &[within(max)]);
        assert_eq!(marked(0.5), Some(vec![1.0, 0.0, 0.0]));
        assert_eq!(marked(1.0), Some(vec![1.0, 1.0, 0.0]), "borders are in it");
        assert_eq!(
            marked(9.0),
            Some(vec![1.0, 1.0, 0.0]),
            "the box alone is not enough"
        );
    }

    #[test]
    fn the_files_own_mirrors_count_unless_a_rule_names_them() {
        let cloud = RawCloud {
            mirror: Some(vec![0.0, 1.0, 0.5]),
            ..cloud()
        };
        let rule = MirrorRule {
            select: Select::Property("mirror".to_owned()),
            reflectance: 0.8,
        };
        assert_eq!(mirrors(&cloud, &[]), Some(vec![0.0, 1.0, 0.5]));
        assert_eq!(mirrors(&cloud, &[rule]), Some(vec![0.0, 0.8, 0.8]));
    }

    #[test]
    fn a_missing_column_is_answered_with_those_there_are() {
        let rule = MirrorRule {
            select: Select::Property("clasification2".to_owned()),
            reflectance: 1.0,
        };
        let cloud = cloud();
        let error = mirror_column(&cloud, &cloud.positions, &[rule], "a.ply")
            .unwrap_err()
            .to_string();
        assert!(error.contains("did you mean `classification`"), "{error}");
        assert!(error.contains("x, y, z, classification"), "{error}");
    }

    #[test]
    fn columns_are_found_whatever_their_case_and_prefix() {
        let names = ["Classification".to_owned(), "scalar_Intensity".to_owned()];
        assert_eq!(
            find_column(&names, "classification"),
            Some("Classification")
        );
        assert_eq!(find_column(&names, "intensity"), Some("scalar_Intensity"));
        assert_eq!(find_column(&names, "colour"), None);
    }
}
