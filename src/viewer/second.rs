//! Settings that are compared with those of the picture: the same view is rendered with both.

use catoptric::settings::Settings;
use eframe::egui;

use super::app::Viewer;
use super::comparison::Comparison;
use super::letters::{Request, Shown};
use super::pace::Detail;

/// Settings that are compared with those of the picture, in the same view.
pub(super) struct Second {
    /// For people.
    pub(super) name: String,
    pub(super) settings: Settings,
    /// The number of the frame that was asked for last, and what was said where it failed.
    asked: u64,
    pub(super) refusal: Option<String>,
    /// The last frame with them.
    pub(super) shown: Option<Shown>,
    pub(super) texture: Option<egui::TextureHandle>,
    pub(super) difference: Option<egui::TextureHandle>,
    pub(super) lines: Vec<(&'static str, String)>,
}

impl Viewer {
    /// Compares what is shown with the same view under these settings, from now on.
    pub(super) fn compare_with(&mut self, name: &str, settings: Settings) {
        self.second = Some(Second {
            name: name.to_owned(),
            settings,
            asked: 0,
            refusal: None,
            shown: None,
            texture: None,
            difference: None,
            lines: Vec::new(),
        });
        self.compare();
    }

    /// Asks for what the comparison lacks: the other frame of this view, or how the two compare.
    pub(super) fn compare(&mut self) {
        let (Some(second), Some(shown)) = (&mut self.second, &self.shown) else {
            return;
        };
        if shown.request.detail != Detail::FULL || !self.complete {
            return;
        }
        let same = |other: &&Shown| {
            other.request.camera == shown.request.camera
                && other.request.settings == second.settings
                && self.buffer.comes_with(other.request.buffer)
        };
        match second.shown.as_ref().filter(same) {
            Some(with) => self
                .worker
                .compare(shown.clone(), with.clone(), self.buffer),
            None => {
                self.number += 1;
                (second.asked, second.refusal) = (self.number, None);
                self.worker.second(Request {
                    number: self.number,
                    buffer: self.buffer,
                    settings: second.settings.clone(),
                    ..shown.request.clone()
                });
            }
        }
    }

    /// A frame could not be made; it may be the one to compare with.
    pub(super) fn refuse_comparison(&mut self, number: Option<u64>, message: &str) {
        if let Some(second) = self.second.as_mut().filter(|s| Some(s.asked) == number) {
            second.refusal = Some(message.to_owned());
        }
    }

    /// What the comparison gave, if it is of the frame that is shown.
    pub(super) fn put_comparison(&mut self, comparison: Comparison, context: &egui::Context) {
        let [number, with] = comparison.numbers;
        let shown = self
            .shown
            .as_ref()
            .is_some_and(|s| s.request.number == number);
        let Some(second) = self.second.as_mut().filter(|second| {
            shown && (second.shown.as_ref()).is_some_and(|s| s.request.number == with)
        }) else {
            return;
        };
        if comparison.with.buffer != self.buffer {
            return;
        }
        let options = egui::TextureOptions::LINEAR;
        second.texture = Some(context.load_texture("second", comparison.with.image, options));
        let difference = comparison.difference;
        second.difference = Some(context.load_texture("difference", difference, options));
        second.lines = comparison.lines;
    }
}
