//! Reading `[[light]]` and `[camera]`.

use glam::{UVec2, Vec3};

use crate::camera::MAX_SIZE;
use crate::error::Result;
use crate::scene::reader::{AMOUNT, FIELD_OF_VIEW, Field, HALF_ANGLE, LENGTH};
use crate::scene::{SceneCamera, SceneLight, keys};

/// One `[[light]]`.
pub(super) fn light(field: &Field<'_>) -> Result<SceneLight> {
    let table = field.table(keys::LIGHT)?;
    let kind = table.required("kind", "\"spot\"")?;
    if kind.choice(&["spot", "point"])? == "point" {
        return kind.error(
            "is \"point\", which this version does not light; the kinds there are: \"spot\"",
        );
    }
    let position = table.required("position", "[x, y, z]")?.point()?;
    let target_field = table.required("target", "[x, y, z]")?;
    let target = target_field.point()?;
    if (target - position).try_normalize().is_none() {
        return target_field.error("is the light's position; it must be what the light points at");
    }
    let intensity = table
        .required("intensity", "[6, 6, 6]")?
        .numbers("[red, green, blue]", &AMOUNT)?;
    let outer_field = table.get("outer_angle_degrees");
    let outer = outer_field
        .as_ref()
        .map(|f| f.number(&HALF_ANGLE))
        .transpose()?;
    let inner = table.optional("inner_angle_degrees", |f| f.number(&HALF_ANGLE))?;
    // One angle alone sets the other, so that it cannot contradict a default.
    let (inner, outer) = match (inner, outer) {
        (Some(inner), Some(outer)) => (inner, outer),
        (Some(inner), None) => (inner, inner.max(35.0)),
        (None, Some(outer)) => (outer.min(25.0), outer),
        (None, None) => (25.0, 35.0),
    };
    if let Some(field) = outer_field
        && (outer < inner || outer == 0.0)
    {
        return field.error(format!(
            "is {outer}; it must be above 0 and at least the inner angle, which is {inner}"
        ));
    }
    Ok(SceneLight {
        position,
        target,
        intensity: Vec3::from_array(intensity.map(|i| i as f32)),
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
    })
}

/// The `[camera]`.
pub(super) fn camera(field: &Field<'_>) -> Result<SceneCamera> {
    let table = field.table(keys::CAMERA)?;
    let point = |key| table.optional(key, |f| f.point());
    let length = |key| table.optional(key, |f| f.number(&LENGTH));
    let size = |f: Field<'_>| {
        let sides = f.list("[width, height]")?;
        let sides: Vec<i64> = sides
            .iter()
            .map(|s| s.whole(1, i64::from(MAX_SIZE)))
            .collect::<Result<_>>()?;
        match sides.as_slice() {
            [width, height] => Ok(UVec2::new(*width as u32, *height as u32)),
            _ => f.must_be("[width, height]"),
        }
    };
    Ok(SceneCamera {
        position: point("position")?,
        target: point("target")?,
        up: table.optional("up", |f| f.direction())?,
        fov_y_degrees: table.optional("fov_y_degrees", |f| f.number(&FIELD_OF_VIEW))?,
        near: length("near")?,
        far: length("far")?,
        size: table.optional("size", size)?,
        origin: table.last_origin().clone(),
    })
}
