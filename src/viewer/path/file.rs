//! Camera paths as small TOML files: NAME.path.toml.

use std::io::Read as _;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{
    CameraPath, GAP, Keyframe, MAX_COORDINATE, MAX_KEYFRAMES, MAX_SECONDS, Pose, Turntable,
    is_in_range,
};

/// The version of the format.
const FORMAT: u32 = 1;

/// Largest file, bytes; whatever is larger is no camera path.
const MAX_BYTES: u64 = 4 << 20;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    turntable: Option<Turn>,
    #[serde(default)]
    keyframe: Vec<Key>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Turn {
    seconds: f64,
    clockwise: bool,
    pivot: DVec3,
    position: DVec3,
    target: DVec3,
    up: DVec3,
    fov_y_degrees: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    time: f64,
    position: DVec3,
    target: DVec3,
    up: DVec3,
    fov_y_degrees: f64,
}

/// Whether a file's name says that it is a camera path.
pub(in crate::viewer) fn is_path_file(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.to_lowercase().ends_with(".path.toml")
}

/// Reads a camera path.
///
/// # Errors
/// A sentence that names the file.
pub(in crate::viewer) fn read(path: &Path) -> Result<CameraPath, String> {
    let wrong = |problem: String| format!("{}: {problem}", path.display());
    let unreadable = |e: std::io::Error| wrong(format!("cannot be read: {e}"));
    // A pipe would be waited for.
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(wrong(
            "is not a file; give the name of a camera path".into(),
        ));
    }
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(wrong(
            "is larger than 4 MiB, which no camera path is".into(),
        ));
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| wrong("is not UTF-8 text; a camera path is TOML".into()))?;
    parse(&text).map_err(wrong)
}

/// Reads the text of a camera path.
///
/// # Errors
/// A sentence about the first thing that is wrong.
pub(super) fn parse(text: &str) -> Result<CameraPath, String> {
    let file: File = toml::from_str(text).map_err(|e| {
        let message = e.message().replace('\n', " ");
        match e.span().and_then(|span| text.get(..span.start)) {
            Some(before) => format!("line {}: {message}", before.matches('\n').count() + 1),
            None => message,
        }
    })?;
    if file.format != FORMAT {
        let found = file.format;
        return Err(format!(
            "format is {found}; this program reads format {FORMAT}"
        ));
    }
    if file.keyframe.is_empty() && file.turntable.is_none() {
        return Err("has neither a [[keyframe]] nor a [turntable]; add one".into());
    }
    let count = file.keyframe.len();
    if count > MAX_KEYFRAMES {
        return Err(format!(
            "has {count} keyframes, and {MAX_KEYFRAMES} are the most; leave some out"
        ));
    }
    let mut path = CameraPath::default();
    for (index, key) in file.keyframe.into_iter().enumerate() {
        let keyframe = key.keyframe().and_then(|keyframe| {
            let before = path.keyframes.last().map_or(-GAP, |last| last.time);
            if keyframe.time >= before + GAP * 0.999 {
                Ok(keyframe)
            } else {
                Err(format!(
                    "its time is {}; it must be later than that of the one before by {GAP} seconds",
                    keyframe.time
                ))
            }
        });
        let wrong = |problem| format!("keyframe {}: {problem}", index + 1);
        path.keyframes.push(keyframe.map_err(wrong)?);
    }
    let turntable = file.turntable.map(Turn::turntable).transpose();
    path.turntable = turntable.map_err(|problem| format!("turntable: {problem}"))?;
    Ok(path)
}

/// A camera path as the text of a file.
///
/// # Errors
/// A sentence where it cannot be written as TOML.
pub(in crate::viewer) fn text(path: &CameraPath) -> Result<String, String> {
    let file = File {
        format: FORMAT,
        turntable: path.turntable.as_ref().map(Turn::of),
        keyframe: path.keyframes.iter().map(Key::of).collect(),
    };
    toml::to_string(&file).map_err(|e| format!("the camera path cannot be written: {e}"))
}

impl Key {
    fn of(keyframe: &Keyframe) -> Self {
        let Pose {
            position,
            target,
            up,
            fov_y_degrees,
        } = keyframe.pose;
        Self {
            time: keyframe.time,
            position,
            target,
            up,
            fov_y_degrees,
        }
    }

    fn keyframe(self) -> Result<Keyframe, String> {
        if !(0.0..=MAX_SECONDS).contains(&self.time) {
            return Err(format!(
                "its time is {}; it must be 0 to {MAX_SECONDS} seconds",
                self.time
            ));
        }
        let pose = Pose {
            position: self.position,
            target: self.target,
            up: self.up,
            fov_y_degrees: self.fov_y_degrees,
        };
        pose.check()?;
        Ok(Keyframe {
            time: self.time,
            pose,
        })
    }
}

impl Turn {
    fn of(turntable: &Turntable) -> Self {
        let Pose {
            position,
            target,
            up,
            fov_y_degrees,
        } = turntable.from;
        Self {
            seconds: turntable.seconds,
            clockwise: turntable.clockwise,
            pivot: turntable.pivot,
            position,
            target,
            up,
            fov_y_degrees,
        }
    }

    fn turntable(self) -> Result<Turntable, String> {
        let range = Turntable::SECONDS;
        if !range.contains(&self.seconds) {
            return Err(format!(
                "it takes {} seconds; they must be {} to {}",
                self.seconds,
                range.start(),
                range.end()
            ));
        }
        let from = Pose {
            position: self.position,
            target: self.target,
            up: self.up,
            fov_y_degrees: self.fov_y_degrees,
        };
        from.check()?;
        if !is_in_range(self.pivot) {
            return Err(format!(
                "pivot must be finite numbers of at most {MAX_COORDINATE:e}"
            ));
        }
        Ok(Turntable {
            from,
            pivot: self.pivot,
            seconds: self.seconds,
            clockwise: self.clockwise,
        })
    }
}
