//! One frame, written once for all backends: the way of the data from surfels to radiance.

use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::backend::{Backend, Cloud, LitBy};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::{Coverage, GBuffer};
use crate::gi::environment::Environment;
use crate::gi::virtual_lights::VirtualLights;
use crate::gi::{Illuminator, IndirectSources, SpotLight, vpl_pinhole};
use crate::grid::Grid;
use crate::job::Job;
use crate::measure::BounceReport;
use crate::plan::{Plan, Stage};
use crate::reflect::sscr::heat::HeatSums;
use crate::reflect::{MirrorGBuffer, Reflector};
use crate::settings::Settings;

/// Who looks, and by which light.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The camera, relative to the scene's origin.
    pub pinhole: Pinhole,
    /// The lights, relative to the scene's origin.
    pub lights: Vec<SpotLight>,
    /// Light from everywhere.
    pub environment: Option<Arc<Environment>>,
    /// The scene's box, relative to its origin: lights reach to its farthest corner.
    pub bounds: (Vec3, Vec3),
}

/// What a frame makes, where the backend keeps it.
pub struct Frame<B: Backend> {
    /// What the camera sees.
    pub gbuffer: GBuffer<B>,
    /// How much of the picture shows something.
    pub coverage: Coverage,
    /// The lights, with the maps of what they see.
    pub lights: Vec<LitBy<B>>,
    /// Radiance towards the eye, W/sr/m2 (albedo where the scene has no light); alpha 1 where valid.
    pub radiance: B::Grid<Vec4>,
    /// What the mirrors show, where the camera sees one.
    pub mirror: Option<MirrorGBuffer<B>>,
    /// What the search came to, one for each mirror bounce.
    pub bounces: Vec<BounceReport>,
    /// Where the searches of the first mirror bounce end, where the plan asks for it and the camera sees a mirror.
    pub search_heat: Option<Grid<HeatSums>>,
    /// The virtual lights and their shadow maps, where the plan asks for them and there is indirect light.
    pub virtual_lights: Option<VirtualLights>,
}

impl View {
    /// Diagonal of the scene's box.
    pub fn diagonal(&self) -> f32 {
        (self.bounds.1 - self.bounds.0).length()
    }

    /// Distance from a light to the farthest corner of the scene, a little more.
    fn reach(&self, light: &SpotLight) -> f32 {
        let (min, max) = self.bounds;
        let farthest = (light.position - min)
            .abs()
            .max((light.position - max).abs());
        (farthest.length() * 1.01).max(f32::MIN_POSITIVE * 1e10)
    }

    /// The lights, with the projections through which their virtual point lights are drawn.
    fn vpl_lights(&self) -> Vec<(SpotLight, Pinhole)> {
        let lights = self.lights.iter();
        lights
            .map(|light| (*light, vpl_pinhole(light, self.reach(light))))
            .collect()
    }
}

/// Stages that keep working memory between frames.
#[derive(Debug, Default)]
pub struct Stages {
    /// What mirrors show.
    pub reflector: Reflector,
    /// Indirect light.
    pub illuminator: Illuminator,
}

/// Renders one frame.
///
/// # Errors
/// What the backend meets, or [`crate::Error::Cancelled`].
pub fn frame<B: Backend>(
    backend: &mut B,
    stages: &mut Stages,
    cloud: &Cloud<B>,
    view: &View,
    plan: &Plan,
    settings: &Settings,
    job: &Job,
) -> Result<Frame<B>> {
    let points = &cloud.points;
    job.progress("splatting", 0, 0)?;
    let mut gbuffer = backend.splat(points, &view.pinhole, &settings.splat, job)?;
    let mut coverage = backend.coverage(&gbuffer, job)?;
    if plan.runs(Stage::Fill, false) {
        let splatted = coverage.splatted;
        backend.fill(&mut gbuffer, &settings.splat, job)?;
        coverage = Coverage {
            splatted,
            ..backend.coverage(&gbuffer, job)?
        };
    }
    if plan.runs(Stage::Smooth, coverage.mirror > 0) {
        backend.smooth(&mut gbuffer, &settings.splat, job)?;
    }
    let (mut mirror, mut bounces) = (None, Vec::new());
    if plan.runs(Stage::Reflect, coverage.mirror > 0) {
        let reflector = &mut stages.reflector;
        let diagonal = view.diagonal();
        let (seen, report) =
            reflector.reflect(backend, cloud, &gbuffer, diagonal, settings, job)?;
        mirror = Some(seen);
        bounces.push(report);
    }
    job.progress("lighting", 0, 0)?;
    let mut lights = Vec::new();
    let (mut radiance, mut shown) = if plan.runs(Stage::Shade, true) {
        lights.reserve(view.lights.len());
        for light in &view.lights {
            let map = light.pinhole(settings.gi.light_map_size, view.reach(light));
            lights.push(LitBy {
                light: *light,
                map: backend.light_map(points, &map, &settings.splat, job)?,
            });
        }
        let radiance = backend.shade(&gbuffer, &lights, &settings.gi, job)?;
        let shown = match &mirror {
            Some(mirror) => Some(backend.shade_mirror(mirror, &lights, &settings.gi, job)?),
            None => None,
        };
        (radiance, shown)
    } else {
        (backend.edl(&gbuffer, &settings.image, job)?, None)
    };
    let mut virtual_lights = None;
    if plan.runs(Stage::Indirect, true) {
        let mut receivers = vec![backend.receivers(&gbuffer, job)?];
        if let Some(mirror) = &mirror {
            let mut shown = backend.mirror_receivers(mirror, job)?;
            shown.position = backend.settle(&shown, &mirror.level, job)?;
            receivers.push(shown);
        }
        let sources = IndirectSources {
            lights: &view.vpl_lights(),
            environment: view.environment.as_deref(),
            bounds: view.bounds,
            has_mirrors: plan.runs(Stage::Reflect, true),
            splat: &settings.splat,
            gi: &settings.gi,
            keeps_lights: plan.runs(Stage::VirtualLights, true),
        };
        let illuminator = &mut stages.illuminator;
        let indirect = illuminator.indirect(backend, cloud, &sources, receivers, job)?;
        virtual_lights = indirect.lights;
        let albedos = [Some(&gbuffer.albedo), mirror.as_ref().map(|m| &m.albedo)];
        let radiances = [Some(&mut radiance), shown.as_mut()];
        for ((light, albedo), radiance) in indirect.light.iter().zip(albedos).zip(radiances) {
            if let (Some(albedo), Some(radiance)) = (albedo, radiance) {
                backend.add_indirect(albedo, light, &settings.gi, radiance, job)?;
            }
        }
    }
    if let Some(mirror) = &mirror {
        backend.blend(&mut radiance, &gbuffer, mirror, shown.as_ref(), job)?;
    }
    let search_heat = if plan.runs(Stage::SearchHeat, coverage.mirror > 0) {
        let reflector = &mut stages.reflector;
        Some(reflector.search_heat(backend, cloud, &gbuffer, settings, job)?)
    } else {
        None
    };
    Ok(Frame {
        gbuffer,
        coverage,
        lights,
        radiance,
        mirror,
        bounces,
        search_heat,
        virtual_lights,
    })
}
