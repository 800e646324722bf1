//! What a frame runs, and why: decided from facts of the scene and the settings before anything is built.

use serde::Serialize;

use crate::error::Result;
use crate::reflect::sscr::heat::require_search;
use crate::settings::Settings;

/// The stages of a frame, in the order in which they run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Passes depth, visibility, average: the camera's G-buffer.
    Splat,
    /// Closes small holes.
    Fill,
    /// Smooths the surfaces of mirrors.
    Smooth,
    /// The depth map of every light.
    LightDepth,
    /// Direct light.
    Shade,
    /// Indirect light.
    Indirect,
    /// Eye-dome lighting.
    Edl,
    /// What the mirrors show.
    Reflect,
    /// Where the searches of mirrors end; only where asked for.
    SearchHeat,
    /// What the virtual lights are, with their shadow maps; only where asked for.
    VirtualLights,
}

/// Whether a stage runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state", content = "reason")]
pub enum State {
    /// It runs, for this reason.
    Run(String),
    /// It runs where the camera sees a mirror, for this reason.
    IfMirrorSeen(String),
    /// It is not built and does not run, for this reason.
    Skip(String),
}

/// A stage and whether it runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// The stage.
    pub stage: Stage,
    /// Whether it runs, and why.
    #[serde(flatten)]
    pub state: State,
}

/// What the plan needs to know of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneFacts {
    /// Points in all.
    pub points: u64,
    /// Points that are mirrors.
    pub mirror_points: u64,
    /// Lights.
    pub lights: usize,
    /// Whether there is light from everywhere.
    pub environment: bool,
}

/// What a frame runs, stage by stage.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Plan {
    /// One row a stage, in the order in which they run.
    pub rows: Vec<Row>,
}

impl Plan {
    /// The plan for a scene.
    pub fn new(facts: &SceneFacts, settings: &Settings) -> Self {
        let run = |reason: String| State::Run(reason);
        let skip = |reason: &str| State::Skip(reason.into());
        let count = |n: u64, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let lights = count(facts.lights as u64, "light");
        // An environment is made of virtual lights.
        let by_environment = facts.environment && settings.gi.vpl_count > 0;
        let unlit = facts.lights == 0 && !by_environment;
        let rows = vec![
            (Stage::Splat, run(count(facts.points, "point"))),
            (
                Stage::Fill,
                match settings.splat.fill {
                    0 => skip("splat.fill is 0"),
                    rings => run(format!(
                        "holes up to {} wide",
                        count(u64::from(rings) * 2, "pixel")
                    )),
                },
            ),
            (
                Stage::Smooth,
                match (facts.mirror_points, settings.splat.smooth) {
                    (0, _) => skip("no point is a mirror"),
                    (_, 0.0) => skip("splat.smooth is 0"),
                    (n, _) => State::IfMirrorSeen(count(n, "mirror point")),
                },
            ),
            (
                Stage::LightDepth,
                if facts.lights > 0 {
                    run(lights.clone())
                } else {
                    skip("no light")
                },
            ),
            (
                Stage::Shade,
                match facts.lights {
                    0 if unlit => skip("no light"),
                    0 => run("the environment".into()),
                    _ => run(lights),
                },
            ),
            (
                Stage::Indirect,
                match (facts.lights, settings.gi.vpl_count) {
                    (_, n) if by_environment => run(format!(
                        "the environment, of {}, and {}",
                        count(n.into(), "virtual light"),
                        count(settings.gi.bounces.into(), "bounce")
                    )),
                    (_, 0) if facts.environment => skip(
                        "gi.vpl_count is 0, and without virtual lights the environment has no light",
                    ),
                    (0, _) => skip("no light"),
                    (_, 0) => skip("gi.vpl_count is 0"),
                    _ if settings.gi.bounces == 0 => skip("gi.bounces is 0"),
                    (_, n) => run(format!(
                        "{} of the first of {}",
                        count(n.into(), "virtual light"),
                        count(settings.gi.bounces.into(), "bounce")
                    )),
                },
            ),
            (
                Stage::Edl,
                match (unlit, settings.image.edl_strength) {
                    (true, 0.0) => {
                        run("no light: the albedo as it is, image.edl_strength being 0".into())
                    }
                    (true, _) => run("no light: the albedo, shaded by depth".into()),
                    _ if facts.lights == 0 => skip("the environment lights the scene"),
                    _ => skip("the scene has a light"),
                },
            ),
            (
                Stage::Reflect,
                match facts.mirror_points {
                    0 => skip("no point is a mirror"),
                    n => State::IfMirrorSeen(count(n, "mirror point")),
                },
            ),
        ];
        Self {
            rows: rows
                .into_iter()
                .map(|(stage, state)| Row { stage, state })
                .collect(),
        }
    }

    /// Asks for [`Stage::SearchHeat`].
    ///
    /// # Errors
    /// [`crate::Error::Setting`] where that search does not run.
    pub fn ask_for_search_heat(&mut self, settings: &Settings) -> Result<()> {
        require_search(settings)?;
        let reflects = self.runs(Stage::Reflect, true);
        let state = if reflects {
            State::IfMirrorSeen("asked for".into())
        } else {
            State::Skip("no point is a mirror".into())
        };
        self.rows.push(Row {
            stage: Stage::SearchHeat,
            state,
        });
        Ok(())
    }

    /// Asks for [`Stage::VirtualLights`].
    pub fn ask_for_virtual_lights(&mut self) {
        let state = if self.runs(Stage::Indirect, true) {
            State::Run("asked for".into())
        } else {
            State::Skip("there is no indirect light".into())
        };
        self.rows.push(Row {
            stage: Stage::VirtualLights,
            state,
        });
    }

    /// Leaves out all light: what mirrors show is found all the same, and costs the same.
    pub fn leave_out_light(&mut self) {
        for row in &mut self.rows {
            if matches!(
                row.stage,
                Stage::LightDepth | Stage::Shade | Stage::Indirect | Stage::VirtualLights
            ) {
                row.state = State::Skip("only what mirrors show is asked for".into());
            }
        }
    }

    /// Whether `stage` runs; `mirror_seen` says whether the camera sees a mirror.
    pub fn runs(&self, stage: Stage, mirror_seen: bool) -> bool {
        self.rows
            .iter()
            .filter(|row| row.stage == stage)
            .any(|row| match row.state {
                State::Run(_) => true,
                State::IfMirrorSeen(_) => mirror_seen,
                State::Skip(_) => false,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACTS: SceneFacts = SceneFacts {
        points: 100,
        mirror_points: 10,
        lights: 1,
        environment: false,
    };

    #[test]
    fn a_scene_without_light_builds_no_shadow_map() {
        let plan = Plan::new(&SceneFacts { lights: 0, ..FACTS }, &Settings::default());
        assert!(
            !plan.runs(Stage::LightDepth, true) && !plan.runs(Stage::Shade, true),
            "{plan:?}"
        );
        assert!(plan.runs(Stage::Edl, false), "{plan:?}");
    }

    #[test]
    fn a_lit_scene_is_not_shaded_by_depth() {
        let plan = Plan::new(&FACTS, &Settings::default());
        assert!(
            plan.runs(Stage::Shade, false) && !plan.runs(Stage::Edl, false),
            "{plan:?}"
        );
    }

    #[test]
    fn an_environment_is_light() {
        let sky = SceneFacts {
            lights: 0,
            environment: true,
            ..FACTS
        };
        let mut settings = Settings::default();
        settings.gi.bounces = 0;
        let plan = Plan::new(&sky, &settings);
        assert!(
            plan.runs(Stage::Indirect, false) && plan.runs(Stage::Shade, false),
            "{plan:?}"
        );
        assert!(
            !plan.runs(Stage::Edl, false) && !plan.runs(Stage::LightDepth, false),
            "{plan:?}"
        );
        settings.gi.vpl_count = 0;
        let plan = Plan::new(&sky, &settings);
        assert!(
            plan.runs(Stage::Edl, false) && !plan.runs(Stage::Shade, false),
            "nothing is left to light it: {plan:?}"
        );
    }

    #[test]
    fn virtual_lights_are_told_where_asked_for_and_where_there_are_any() {
        let mut plan = Plan::new(&FACTS, &Settings::default());
        assert!(
            !plan.runs(Stage::VirtualLights, true),
            "not asked: {plan:?}"
        );
        plan.ask_for_virtual_lights();
        assert!(plan.runs(Stage::VirtualLights, false), "{plan:?}");
        plan.leave_out_light();
        assert!(!plan.runs(Stage::VirtualLights, true), "no light: {plan:?}");
        let mut dark = Plan::new(&SceneFacts { lights: 0, ..FACTS }, &Settings::default());
        dark.ask_for_virtual_lights();
        assert!(!dark.runs(Stage::VirtualLights, true), "{dark:?}");
    }

    #[test]
    fn smoothing_waits_for_a_mirror_that_is_seen() {
        let mut settings = Settings::default();
        settings.splat.smooth = 2.0;
        let plan = Plan::new(&FACTS, &settings);
        assert!(
            plan.runs(Stage::Smooth, true) && !plan.runs(Stage::Smooth, false),
            "{plan:?}"
        );
        let plan = Plan::new(
            &SceneFacts {
                mirror_points: 0,
                ..FACTS
            },
            &settings,
        );
        assert!(!plan.runs(Stage::Smooth, true), "{plan:?}");
    }
}
