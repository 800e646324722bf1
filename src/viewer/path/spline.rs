//! A smooth curve through keyframes: cubic Hermite pieces.
//!
//! The velocity at a keyframe is that of the parabola through it and its neighbours, but no more than three times the
//! slower of the mean velocities on either side: up to there a cubic does not overshoot along a line [de Boor and
//! Swartz 1977]. So uneven times make no loops, a pause between two equal views is one, and what moves evenly on a line
//! stays even.

use glam::DVec3;

use super::{Keyframe, Pose, sound};

/// Largest part that the velocity at a keyframe is of the slower of the mean velocities around it.
const FASTEST: f64 = 3.0;

/// The view at a time; `None` without keyframes.
pub(super) fn pose(keyframes: &[Keyframe], time: f64) -> Option<Pose> {
    let after = keyframes.partition_point(|k| k.time <= time);
    let Some(index) = after.checked_sub(1) else {
        return keyframes.first().map(|first| first.pose);
    };
    let [from, to, ..] = keyframes.get(index..)? else {
        return keyframes.last().map(|last| last.pose);
    };
    let at = |what: fn(&Pose) -> DVec3| piece(keyframes, index, time, what);
    let (a, b) = (from.pose.fov_y_degrees, to.pose.fov_y_degrees);
    // Neither wider nor narrower than on either side.
    let field = at(|pose| DVec3::X * pose.fov_y_degrees).x;
    let pose = Pose {
        position: at(|pose| pose.position),
        target: at(|pose| pose.target),
        up: at(|pose| pose.up).normalize_or(from.pose.up),
        fov_y_degrees: field.clamp(a.min(b), a.max(b)),
    };
    Some(sound(pose, from.pose))
}

/// The curve from keyframe `index` to the next.
fn piece(keyframes: &[Keyframe], index: usize, time: f64, what: fn(&Pose) -> DVec3) -> DVec3 {
    let Some([from, to, ..]) = keyframes.get(index..) else {
        return DVec3::ZERO;
    };
    let (p, q, seconds) = (what(&from.pose), what(&to.pose), to.time - from.time);
    let [m, n] = [index, index + 1].map(|k| velocity(keyframes, k, what) * seconds);
    let u = ((time - from.time) / seconds).clamp(0.0, 1.0);
    let v = 1.0 - u;
    let bend = m * (u * v * v) - n * (u * u * v);
    // From the nearer end, so that both are met exactly and large coordinates keep their digits.
    if u <= 0.5 {
        p + ((q - p) * (u * u * (3.0 - 2.0 * u)) + bend)
    } else {
        q - ((q - p) * (v * v * (3.0 - 2.0 * v)) - bend)
    }
}

/// At a keyframe, per second.
fn velocity(keyframes: &[Keyframe], index: usize, what: fn(&Pose) -> DVec3) -> DVec3 {
    let mean = |k: usize| {
        let (from, to) = (keyframes.get(k)?, keyframes.get(k + 1)?);
        let seconds = to.time - from.time;
        Some(((what(&to.pose) - what(&from.pose)) / seconds, seconds))
    };
    let before = index.checked_sub(1).and_then(mean);
    match (before, mean(index)) {
        (Some((before, long)), Some((after, short))) => {
            let parabola = (before * short + after * long) / (long + short);
            parabola.clamp_length_max(FASTEST * before.length().min(after.length()))
        }
        // At an end it does not accelerate.
        (Some((only, _)), None) if index > 1 => end(only, velocity(keyframes, index - 1, what)),
        (None, Some((only, _))) if index + 2 < keyframes.len() => {
            end(only, velocity(keyframes, index + 1, what))
        }
        (Some((only, _)), None) | (None, Some((only, _))) => only,
        (None, None) => DVec3::ZERO,
    }
}

/// The velocity at an end, from the mean velocity of its piece and that at the piece's other end.
fn end(mean: DVec3, inner: DVec3) -> DVec3 {
    ((mean * 3.0 - inner) * 0.5).clamp_length_max(FASTEST * mean.length())
}
