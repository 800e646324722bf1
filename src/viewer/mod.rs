//! The viewer: people look at scans with mirrors, and tune the search while they watch.
//!
//! The interface runs in one thread and never waits. Everything long runs in another (`worker`,
//! `studio`), which tells by events (`letters`).
//! What is pure is apart, and tested without a window: how the camera moves (`navigation`), how much is drawn while it
//! does (`pace`), where it goes with time (`path`), layers in colours (`buffers`), undo and the command line (`history`), where the scene is in the window
//! (`screen`), what comes of a shape that is dragged (`handles`), outlines (`wireframe`).

mod app;
mod buffers;
mod canvas;
mod changes;
mod comparison;
mod document;
mod editing;
mod events;
mod film;
mod gizmo;
mod handles;
mod history;
mod letters;
mod navigation;
mod opening;
mod pace;
mod panels;
mod path;
mod pick;
mod probe;
mod screen;
mod second;
mod shadow_maps;
mod studio;
mod take;
mod trail;
mod virtual_lights;
mod wireframe;
mod worker;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use catoptric::renderer::BackendChoice;
use catoptric::scene::Override;
use eframe::egui;

/// What the viewer starts with.
#[derive(Debug, Clone, Default)]
pub(crate) struct Start {
    /// A scene or a point cloud.
    pub(crate) path: Option<PathBuf>,
    /// What is said on top of it.
    pub(crate) overrides: Vec<Override>,
    /// The same, as words of a command line.
    pub(crate) given: Vec<String>,
    /// Where pictures are made; the interface takes any adapter.
    pub(crate) choice: BackendChoice,
}

/// Opens the window; returns when it is closed.
///
/// # Errors
/// A sentence where there is no display or no adapter for the interface.
pub(crate) fn run(start: Start) -> anyhow::Result<()> {
    if !has_display() {
        anyhow::bail!(
            "no display was found for the window; catoptric render makes pictures without one"
        );
    }
    if catoptric::backend::gpu::adapter_names().is_empty() {
        anyhow::bail!(
            "no graphics adapter was found for the window, not even one in software (Mesa's lavapipe is one); catoptric \
             render makes pictures without one"
        );
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("catoptric")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([640.0, 420.0])
            .with_drag_and_drop(true),
        ..eframe::NativeOptions::default()
    };
    eframe::run_native(
        "catoptric",
        options,
        Box::new(move |context| {
            let viewer = app::Viewer::new(&context.egui_ctx, context.storage, start)?;
            Ok(Box::new(viewer))
        }),
    )
    .map_err(|e| anyhow::anyhow!("the window could not be opened: {e}"))
}

/// Elsewhere than on X11 and Wayland there is always one.
fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos")))
        || set("DISPLAY")
        || set("WAYLAND_DISPLAY")
        || set("WAYLAND_SOCKET")
}
