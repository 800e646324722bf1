//! Reading `[[light]]`, `[environment]` and `[camera]`.

use glam::{UVec2, Vec3};

use crate::camera::MAX_SIZE;
use crate::error::Result;
use crate::scene::reader::{AMOUNT, FIELD_OF_VIEW, Field, HALF_ANGLE, LENGTH, RADIANCE};
use crate::scene::{SceneCamera, SceneEnvironment, SceneLight, keys};

/// One `[[light]]`.
pub(super) fn light(field: &Field<'_>) -> Result<SceneLight> {
    let table = field.table(keys::LIGHT)?;
    let kind = table.required("kind", "\"spot\"")?;
    let is_point = kind.choice(&["spot", "point"])? == "point";
    let position = table.required("position", "[x, y, z]")?.point()?;
    let target = if is_point {
        for key in ["target", "inner_angle_degrees", "outer_angle_degrees"] {
            table.optional(key, |f| {
                f.error::<()>("is of spots; a light of kind \"point\" shines in all directions")
            })?;
        }
        None
    } else {
        let field = table.required("target", "[x, y, z]")?;
        let target = field.point()?;
        if (target - position).try_normalize().is_none() {
            return field.error("is the light's position; it must be what the light points at");
        }
        Some(target)
    };
    let intensity = table
        .required("intensity", "[6, 6, 6]")?
        .numbers("[red, green, blue]", &AMOUNT)?;
    let half_angle = |key| table.optional(key, |f| f.number(&HALF_ANGLE));
    let outer = half_angle("outer_angle_degrees")?;
    let inner = half_angle("inner_angle_degrees")?;
    // One angle alone sets the other, so that it cannot contradict a default.
    let (inner, outer) = match (inner, outer) {
        (Some(inner), Some(outer)) => (inner, outer),
        (Some(inner), None) => (inner, inner.max(35.0)),
        (None, Some(outer)) => (outer.min(25.0), outer),
        (None, None) => (25.0, 35.0),
    };
    if outer < inner || outer == 0.0 {
        let name = &table.name;
        let origins = table.origins();
        let suspects = ["outer_angle_degrees", "inner_angle_degrees"];
        return Err(origins.to_blame(&suspects).error(format!(
            "{name}.outer_angle_degrees is {outer}; it must be above 0 and at least {name}.inner_angle_degrees, which \
             is {inner}"
        )));
    }
    Ok(SceneLight {
        position,
        target,
        intensity: Vec3::from_array(intensity.map(|i| i as f32)),
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
    })
}

/// The `[environment]`.
pub(super) fn environment(field: &Field<'_>) -> Result<SceneEnvironment> {
    let table = field.table(keys::ENVIRONMENT)?;
    let name = &table.name;
    for (one, other) in [
        ("colour", "zenith"),
        ("colour", "horizon"),
        ("colour", "map"),
        ("zenith", "map"),
        ("horizon", "map"),
    ] {
        if table.get(one).is_some() && table.get(other).is_some() {
            let origins = table.origins();
            return Err(origins.to_blame(&[other, one]).error(format!(
                "{name} has both {one} and {other}; write colour, or zenith and horizon, or map"
            )));
        }
    }
    let radiance = |field: Field<'_>| {
        let channels = field.numbers("[red, green, blue]", &RADIANCE)?;
        Ok(Vec3::from_array(channels.map(|c| c as f32)))
    };
    if let Some(map) = table.get("map") {
        return Ok(SceneEnvironment::Map { path: map.path()? });
    }
    let [zenith, horizon] = if table.get("zenith").is_some() || table.get("horizon").is_some() {
        let required = |key| radiance(table.required(key, "[1, 1, 1]")?);
        [required("zenith")?, required("horizon")?]
    } else {
        [radiance(table.required("colour", "[1, 1, 1]")?)?; 2]
    };
    Ok(SceneEnvironment::Gradient { zenith, horizon })
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
        origins: table.origins(),
    })
}
