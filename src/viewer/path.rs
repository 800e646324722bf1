//! Where the camera goes with time: through keyframes, or once about a pivot.

mod file;
mod spline;
#[cfg(test)]
mod tests;
mod turntable;

use catoptric::camera::Camera;
use glam::{DVec3, UVec2};

use super::navigation::Navigator;

pub(super) use file::{is_path_file, read, text};
pub(super) use turntable::Turntable;

/// Keyframes of a path, at most.
pub(super) const MAX_KEYFRAMES: usize = 1000;

/// Longest path, seconds.
pub(super) const MAX_SECONDS: f64 = 86_400.0;

/// Pictures of a path, at most.
pub(super) const MAX_PICTURES: usize = 100_000;

/// Pictures a second.
pub(super) const RATES: std::ops::RangeInclusive<f64> = 0.1..=240.0;

/// Keyframes are at least this far apart, seconds.
const GAP: f64 = 1e-3;

/// From the last keyframe to one that is added, seconds.
const STEP: f64 = 2.0;

/// No coordinate is larger, so that none overflows on the way.
const MAX_COORDINATE: f64 = 1e12;

/// Narrowest field of view, degrees.
const NARROWEST: f64 = 0.001;

/// A view: where the camera is and looks. The names are those of `[camera]` in a scene file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) position: DVec3,
    pub(super) target: DVec3,
    pub(super) up: DVec3,
    /// Vertical, degrees.
    pub(super) fov_y_degrees: f64,
}

/// A view that the path passes through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Keyframe {
    /// Seconds.
    pub(super) time: f64,
    pub(super) pose: Pose,
}

/// Where the camera goes with time. Where there is a turntable, that is where it goes.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct CameraPath {
    /// By time, each at its own.
    keyframes: Vec<Keyframe>,
    pub(super) turntable: Option<Turntable>,
}

impl Pose {
    pub(super) fn of(camera: &Camera) -> Self {
        Self {
            position: camera.position,
            target: camera.target,
            up: camera.up,
            fov_y_degrees: camera.fov_y_degrees,
        }
    }

    /// The camera, which is `like` another but for this.
    pub(super) fn camera(&self, like: &Camera) -> Camera {
        Camera {
            position: self.position,
            target: self.target,
            up: self.up,
            fov_y_degrees: self.fov_y_degrees,
            ..*like
        }
    }

    /// A sentence where no picture can be made from here.
    pub(super) fn check(&self) -> Result<(), String> {
        if ![self.position, self.target, self.up]
            .into_iter()
            .all(is_in_range)
        {
            return Err(format!(
                "position, target and up must be finite numbers of at most {MAX_COORDINATE:e}"
            ));
        }
        if self.fov_y_degrees < NARROWEST {
            return Err(format!(
                "fov_y_degrees is {}; it must be at least {NARROWEST}",
                self.fov_y_degrees
            ));
        }
        let like = Camera {
            position: DVec3::ZERO,
            target: DVec3::ZERO,
            up: DVec3::ZERO,
            fov_y_degrees: 60.0,
            near: 1.0,
            far: 2.0,
            size: UVec2::ONE,
        };
        match self.camera(&like).pinhole(self.position) {
            Ok(_) => Ok(()),
            Err(refusal) => Err(refusal.to_string()),
        }
    }
}

impl CameraPath {
    /// By time.
    pub(super) fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    pub(super) fn is_empty(&self) -> bool {
        self.keyframes.is_empty() && self.turntable.is_none()
    }

    /// Adds a keyframe behind the last one; gives its time.
    ///
    /// # Errors
    /// A sentence where there are too many, or they last too long.
    pub(super) fn add(&mut self, pose: Pose) -> Result<f64, String> {
        let time = self.keyframes.last().map_or(0.0, |last| last.time + STEP);
        self.put(time, pose)?;
        Ok(time)
    }

    /// Puts a keyframe at a time; one that is there already takes this view.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub(super) fn put(&mut self, time: f64, pose: Pose) -> Result<(), String> {
        if !(0.0..=MAX_SECONDS).contains(&time) {
            return Err(format!("a camera path lasts at most {MAX_SECONDS} seconds"));
        }
        pose.check()?;
        let near = |k: &&mut Keyframe| (k.time - time).abs() < GAP;
        if let Some(there) = self.keyframes.iter_mut().find(near) {
            there.pose = pose;
            return Ok(());
        }
        if self.keyframes.len() >= MAX_KEYFRAMES {
            return Err(format!(
                "a camera path has at most {MAX_KEYFRAMES} keyframes; remove some first"
            ));
        }
        let index = self.keyframes.partition_point(|k| k.time < time);
        self.keyframes.insert(index, Keyframe { time, pose });
        Ok(())
    }

    /// Gives a keyframe another view.
    pub(super) fn replace(&mut self, index: usize, pose: Pose) {
        if let Some(keyframe) = self.keyframes.get_mut(index) {
            keyframe.pose = pose;
        }
    }

    pub(super) fn remove(&mut self, index: usize) {
        if index < self.keyframes.len() {
            self.keyframes.remove(index);
        }
    }

    /// Moves a keyframe in time, past others too; it stays where another one is at that time.
    pub(super) fn set_time(&mut self, index: usize, time: f64) {
        let sound = (0.0..=MAX_SECONDS).contains(&time);
        let mut others = self.keyframes.iter().enumerate();
        let free = others.all(|(k, other)| k == index || (other.time - time).abs() >= GAP);
        if sound
            && free
            && let Some(keyframe) = self.keyframes.get_mut(index)
        {
            keyframe.time = time;
            self.keyframes.sort_by(|a, b| a.time.total_cmp(&b.time));
        }
    }

    /// When it begins and ends, seconds.
    pub(super) fn span(&self) -> (f64, f64) {
        if let Some(turntable) = &self.turntable {
            return (0.0, turntable.seconds);
        }
        let ends = self.keyframes.first().zip(self.keyframes.last());
        ends.map_or((0.0, 0.0), |(first, last)| (first.time, last.time))
    }

    /// The view at a time, before the beginning and after the end that of there; `None` where there is no path.
    pub(super) fn pose(&self, time: f64) -> Option<Pose> {
        match &self.turntable {
            Some(turntable) => Some(turntable.pose(time)),
            None => spline::pose(&self.keyframes, time),
        }
    }

    /// How many pictures it is at a rate, pictures a second. A turntable's last picture is not its first again.
    ///
    /// # Errors
    /// A sentence where they are none or too many.
    pub(super) fn pictures(&self, rate: f64) -> Result<usize, String> {
        if self.is_empty() {
            return Err("add keyframes or take a turntable first".into());
        }
        if !RATES.contains(&rate) {
            let (least, most) = (RATES.start(), RATES.end());
            return Err(format!(
                "take {least} to {most} pictures a second, not {rate}"
            ));
        }
        let (start, end) = self.span();
        // The end has a picture of its own, unless rounding hides it.
        let count = match &self.turntable {
            Some(_) => ((end - start) * rate).round().max(1.0),
            None => ((end - start) * rate + 1e-6).floor() + 1.0,
        };
        if count > MAX_PICTURES as f64 {
            return Err(format!(
                "these are {count} pictures, and {MAX_PICTURES} are the most; take fewer a second"
            ));
        }
        Ok(count as usize)
    }

    /// When a picture is taken, seconds.
    pub(super) fn time_of(&self, picture: usize, rate: f64) -> f64 {
        let (start, end) = self.span();
        let step = match self.pictures(rate) {
            // Whole steps fill the circle.
            Ok(count) if self.turntable.is_some() => (end - start) / count as f64,
            _ => rate.recip(),
        };
        (start + picture as f64 * step).min(end)
    }
}

fn is_in_range(v: DVec3) -> bool {
    v.is_finite() && v.abs().max_element() <= MAX_COORDINATE
}

/// The first of these that a picture can be made from: the view itself, one that keeps off the pole, or `other`.
fn sound(pose: Pose, other: Pose) -> Pose {
    if pose.check().is_ok() {
        return pose;
    }
    let like = other.camera(&Camera {
        position: DVec3::ZERO,
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        near: 1.0,
        far: 2.0,
        size: UVec2::ONE,
    });
    let off_the_pole = Pose::of(&Navigator::of(&pose.camera(&like)).camera(&like));
    let pose = Pose {
        fov_y_degrees: pose.fov_y_degrees,
        ..off_the_pole
    };
    if pose.check().is_ok() { pose } else { other }
}
