//! `catoptric view`: a window.

use super::args::{ViewArgs, ViewerArgs};
use crate::viewer::{Start, run};

/// Opens the window.
pub(super) fn view(args: &ViewerArgs) -> anyhow::Result<()> {
    let choice = args.place.choice()?;
    let start = match args.scene() {
        None => Start {
            choice,
            ..Start::default()
        },
        Some(scene) => Start {
            overrides: scene.overrides(&ViewArgs::default())?,
            given: scene.given(),
            path: Some(scene.path),
            choice,
        },
    };
    run(start)
}
