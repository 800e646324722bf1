//! Undo and redo, and what settings are as TOML and on a command line.

use std::time::{Duration, Instant};

use catoptric::camera::Camera;
use catoptric::scene::Scene;
use catoptric::settings::Settings;

use super::document::Document;

/// Changes of one setting that follow one another faster than this are one: a slider that is dragged.
const TOGETHER: Duration = Duration::from_millis(800);

/// A document as it is, was and will be again.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    now: Document,
    past: Vec<Document>,
    future: Vec<Document>,
    last: Option<(String, Instant)>,
}

impl History {
    pub(super) fn new(document: Document) -> Self {
        Self {
            now: document,
            ..Self::default()
        }
    }

    pub(super) fn now(&self) -> &Document {
        &self.now
    }

    /// Takes a new state; `what` changed it: a setting's name, or a preset's.
    pub(super) fn change(&mut self, document: Document, what: &str, at: Instant) {
        if document == self.now {
            return;
        }
        let goes_on = (self.last.as_ref())
            .is_some_and(|(last, when)| last == what && at.duration_since(*when) < TOGETHER);
        if !goes_on {
            self.past.push(self.now.clone());
        }
        self.future.clear();
        self.now = document;
        self.last = Some((what.to_owned(), at));
    }

    /// Goes back to the points of `shown`, since those that there are now cannot be shown; what led to them is no step.
    pub(super) fn refuse(&mut self, shown: &Document) {
        while self
            .past
            .last()
            .is_some_and(|before| !before.has_points_of(shown))
        {
            self.past.pop();
        }
        self.replace_points(shown);
        if self.past.last() == Some(&self.now) {
            self.past.pop();
        }
        self.future.clear();
    }

    /// Takes the points of another document, without a step.
    pub(super) fn replace_points(&mut self, document: &Document) {
        let settings = std::mem::take(&mut self.now.settings);
        self.now = Document {
            settings,
            ..document.clone()
        };
        self.last = None;
    }

    pub(super) fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub(super) fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    pub(super) fn undo(&mut self) {
        if let Some(before) = self.past.pop() {
            self.future.push(std::mem::replace(&mut self.now, before));
            self.last = None;
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(after) = self.future.pop() {
            self.past.push(std::mem::replace(&mut self.now, after));
            self.last = None;
        }
    }
}

/// The settings that differ from the defaults, as the table `[settings]` of a scene file.
pub(super) fn as_toml(settings: &Settings) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for (key, value) in settings.changed() {
        let (group, name) = key.split_once('.').unwrap_or(("", &key));
        let line = format!("{name} = {value}");
        match groups.last_mut() {
            Some((last, lines)) if last == group => lines.push(line),
            _ => groups.push((group.to_owned(), vec![line])),
        }
    }
    let tables = groups.into_iter();
    let text = tables.map(|(group, lines)| format!("[settings.{group}]\n{}\n", lines.join("\n")));
    text.collect::<Vec<_>>().join("\n")
}

/// What differs of the scene's clouds and clip box from its file, as `key=value`; `None` where options cannot say it, and
/// the scene must be saved first.
pub(super) fn differences(base: &Scene, document: &Document) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let mut clouds = base.clouds.clone();
    if clouds.len() != document.clouds.len() || base.mirrors != document.mirrors {
        return None;
    }
    for (index, (was, is)) in clouds.iter_mut().zip(&document.clouds).enumerate() {
        if was.visible != is.visible {
            words.push(format!("cloud.{index}.visible={}", is.visible));
        }
        if was.colour != is.colour {
            words.push(format!("cloud.{index}.colour={}", is.colour.name()));
        }
        (was.visible, was.colour) = (is.visible, is.colour);
    }
    if base.clip != document.clip {
        let clip = document.clip?;
        for (key, corner) in [("min", clip.min), ("max", clip.max)] {
            // A side that is open cannot be said where the file closes it.
            if !corner.is_finite() && base.clip.is_some() {
                return None;
            }
            if corner.is_finite() {
                words.push(format!("clip.{key}={}", vector(corner)));
            }
        }
    }
    (clouds == document.clouds).then_some(words)
}

fn vector(v: glam::DVec3) -> String {
    format!("[{},{},{}]", v.x, v.y, v.z)
}

/// The arguments after `catoptric` that render the same picture: what was given when the viewer was started, then what
/// differs of the scene, every setting that differs from what it was opened with, then the camera.
pub(super) fn command_line(
    path: &str,
    given: &[String],
    differences: &[String],
    opened_with: &Settings,
    settings: &Settings,
    camera: &Camera,
    output: &str,
) -> Vec<String> {
    let mut words = vec!["render".to_owned(), path.to_owned()];
    words.extend_from_slice(given);
    for difference in differences {
        words.extend(["--set".to_owned(), difference.clone()]);
    }
    let mut set = |text: String| words.extend(["--set".to_owned(), text]);
    for setting in Settings::describe() {
        let (was, is) = (
            opened_with.value(&setting.key),
            settings.value(&setting.key),
        );
        if let Some(value) = is.filter(|value| was.as_ref() != Some(value)) {
            set(format!("{}={value}", setting.key));
        }
    }
    set(format!("camera.position={}", vector(camera.position)));
    set(format!("camera.target={}", vector(camera.target)));
    set(format!("camera.up={}", vector(camera.up)));
    set(format!("camera.fov_y_degrees={}", camera.fov_y_degrees));
    set(format!("camera.near={}", camera.near));
    set(format!("camera.far={}", camera.far));
    set(format!("camera.size={}x{}", camera.size.x, camera.size.y));
    words.extend(["-o".to_owned(), output.to_owned()]);
    words
}

/// Words as a shell takes them.
pub(super) fn quoted(words: &[String]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    let quote = |word: &String| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    };
    words.iter().map(quote).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sized(size: f64) -> Settings {
        let settings = Settings::default();
        settings
            .with("splat.size", toml::Value::Float(size))
            .expect("a size")
    }

    fn document(size: f64) -> Document {
        Document {
            settings: sized(size),
            ..Document::default()
        }
    }

    #[test]
    fn a_dragged_slider_is_one_step_back() {
        let (mut history, start) = (History::default(), Instant::now());
        for k in 0..10 {
            let at = start + Duration::from_millis(50 * k);
            history.change(document(1.0 + 0.1 * k as f64), "splat.size", at);
        }
        history.undo();
        assert_eq!(history.now(), &Document::default());
        assert!(!history.can_undo());
        history.redo();
        assert_eq!(history.now(), &document(1.9));
    }

    #[test]
    fn another_setting_or_a_pause_is_a_step_of_its_own() {
        let (mut history, start) = (History::default(), Instant::now());
        history.change(document(2.0), "splat.size", start);
        history.change(document(3.0), "splat.size", start + 2 * TOGETHER);
        history.undo();
        assert_eq!(history.now(), &document(2.0));
        history.change(document(4.0), "preset", start + 2 * TOGETHER);
        assert!(!history.can_redo(), "what was undone is gone");
    }

    #[test]
    fn settings_as_toml_are_read_back() {
        let settings = sized(2.5).with("reflect.method", toml::Value::String("ray_trace".into()));
        let settings = settings.expect("a method");
        let text = as_toml(&settings);
        let read: toml::Table = text.parse().expect("TOML");
        let read: Settings = read["settings"].clone().try_into().expect("settings");
        assert_eq!(read, settings, "{text}");
        assert_eq!(as_toml(&Settings::default()), "", "nothing differs");
    }

    #[test]
    fn a_shell_reads_what_was_quoted() {
        let words = ["plain", "two words", "it's", ""].map(str::to_owned);
        assert_eq!(quoted(&words), r"plain 'two words' 'it'\''s' ''");
    }
}
