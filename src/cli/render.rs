//! `catoptric render`: from a scene or cloud to files.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catoptric::Job;
use catoptric::grid::Grid;
use catoptric::measure::{GBufferReport, Report, peak_memory_bytes};
use catoptric::output::{
    CameraDescription, OutputKind, Outputs, PictureFormat, camera_gbuffer, mirror_gbuffer,
};
use catoptric::plan::Plan;
use catoptric::reflect::MirrorGBuffer;
use catoptric::reflect::sscr::heat::{HeatSums, require_search};
use catoptric::renderer::{BackendChoice, Machine, Products, Renderer};
use catoptric::scene::{LoadedScene, Scene};
use glam::UVec2;

use super::args::{RenderArgs, backend};
use super::outputs::{Content, Output, check};
use super::{Usage, terminal};

/// A scene with its frame.
struct Rendered {
    scene: Scene,
    loaded: LoadedScene,
    plan: Plan,
    renderer: Renderer,
    products: Products,
    /// From the first byte read to the last pass, milliseconds.
    wall_ms: f64,
}

/// Renders, and writes what was asked for.
pub(super) fn render(args: &RenderArgs) -> anyhow::Result<()> {
    let choice = backend(args.backend, args.adapter.as_deref())?;
    let scene = Scene::open(&args.scene.path, &args.scene.overrides(&args.view)?)?;
    let unnamed = unnamed_picture(args);
    let picture = args.output.as_deref().or(unnamed.as_deref());
    let outputs = [
        ("--output", Content::Picture, picture),
        ("--gbuffer", Content::GBuffer, args.gbuffer.as_deref()),
        (
            "--mirror-gbuffer",
            Content::GBuffer,
            args.mirror_gbuffer.as_deref(),
        ),
        (
            "--search-heat",
            Content::Picture,
            args.search_heat.as_deref(),
        ),
        ("--camera-json", Content::Json, args.camera_json.as_deref()),
        ("--report", Content::Json, args.report.as_deref()),
    ];
    let outputs: Vec<Output<'_>> = outputs
        .into_iter()
        .filter_map(|(flag, content, path)| {
            path.map(|path| Output {
                flag,
                content,
                path,
            })
        })
        .collect();
    check(&outputs, &scene.inputs())?;

    if args.search_heat.is_some() {
        require_search(&scene.settings).map_err(|e| Usage(e.to_string()))?;
    }
    let (job, progress) = terminal::job()?;
    let rendered = frame(scene, &choice, &kinds(args, picture)?, &job)?;
    drop(progress);
    terminal::say_repairs(&rendered.loaded.facts.repairs);
    if choice == BackendChoice::Auto && rendered.renderer.backend() == "cpu" {
        terminal::say(
            "no graphics card could be used, so the CPU rendered (--backend cpu asks for it)",
        );
    }
    write(args, picture, &rendered, &job)?;
    if let Some(path) = unnamed {
        terminal::say(&format!("wrote {}", path.display()));
    }
    Ok(())
}

/// The picture that is written where no output has a name.
fn unnamed_picture(args: &RenderArgs) -> Option<PathBuf> {
    let named = [
        &args.output,
        &args.gbuffer,
        &args.mirror_gbuffer,
        &args.search_heat,
        &args.camera_json,
        &args.report,
    ];
    if named.iter().any(|path| path.is_some()) {
        return None;
    }
    Some(Path::new(args.scene.path.file_stem()?).with_added_extension("png"))
}

/// The outputs that take memory to encode.
fn kinds(args: &RenderArgs, picture: Option<&Path>) -> catoptric::Result<Vec<OutputKind>> {
    let picture = picture.map(PictureFormat::of).transpose()?;
    let heat = args.search_heat.as_deref().map(PictureFormat::of);
    let kinds = [
        picture.map(OutputKind::Picture),
        args.gbuffer.as_ref().map(|_| OutputKind::CameraGBuffer),
        (args.mirror_gbuffer.as_ref()).map(|_| OutputKind::MirrorGBuffer),
        heat.transpose()?.map(OutputKind::SearchHeat),
    ];
    Ok(kinds.into_iter().flatten().collect())
}

fn frame(
    scene: Scene,
    choice: &BackendChoice,
    outputs: &[OutputKind],
    job: &Job,
) -> catoptric::Result<Rendered> {
    // A missing adapter is noticed before the clouds are read.
    let machine = Machine::open(choice)?;
    let start = Instant::now();
    let loaded = scene.load(job)?;
    let mut plan = loaded.plan(&scene.settings);
    if outputs
        .iter()
        .any(|output| matches!(output, OutputKind::SearchHeat(_)))
    {
        plan.ask_for_search_heat(&scene.settings)?;
    }
    let mut renderer = machine.upload(&loaded.surfels)?;
    let view = loaded.view()?;
    renderer.require_memory(&view, &plan, &scene.settings, outputs)?;
    let products = renderer.render(&view, &plan, &scene.settings, job)?;
    let wall_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok(Rendered {
        scene,
        loaded,
        plan,
        renderer,
        products,
        wall_ms,
    })
}

fn write(
    args: &RenderArgs,
    picture: Option<&Path>,
    rendered: &Rendered,
    job: &Job,
) -> catoptric::Result<()> {
    let Rendered {
        scene,
        loaded,
        products,
        ..
    } = rendered;
    let origin = loaded.surfels.origin;
    let mut outputs = Outputs::default();
    if let Some(path) = picture {
        outputs.stage_picture(path, &products.radiance, &scene.settings.image, job)?;
    }
    if let Some(path) = &args.gbuffer {
        job.check()?;
        outputs.stage_exr(path, camera_gbuffer(&products.gbuffer, origin), job)?;
    }
    if let Some(path) = &args.mirror_gbuffer {
        job.check()?;
        let nothing = MirrorGBuffer::empty(loaded.camera.size);
        let mirror = products.mirror.as_ref().unwrap_or(&nothing);
        outputs.stage_exr(path, mirror_gbuffer(mirror, origin), job)?;
    }
    if let Some(path) = &args.search_heat {
        let nothing = Grid::new(loaded.camera.size, HeatSums::default());
        let heat = products.search_heat.as_ref().unwrap_or(&nothing);
        outputs.stage_search_heat(path, heat, job)?;
    }
    if let Some(path) = &args.camera_json {
        outputs.stage_json(path, &CameraDescription::new(&loaded.camera, origin)?)?;
    }
    if let Some(path) = &args.report {
        outputs.stage_json(path, &report(rendered))?;
    }
    outputs.commit(job)
}

fn report(rendered: &Rendered) -> Report {
    let Rendered {
        scene,
        loaded,
        plan,
        renderer,
        products,
        wall_ms,
    } = rendered;
    let UVec2 { x, y } = loaded.camera.size;
    Report {
        format: 1,
        version: env!("CARGO_PKG_VERSION"),
        backend: renderer.backend().to_owned(),
        adapter: renderer.adapter(),
        points: loaded.facts.points,
        repairs: loaded.facts.repairs,
        size: [x, y],
        origin: loaded.surfels.origin,
        settings: scene.settings.changed().into_iter().collect(),
        plan: plan.clone(),
        passes: products.passes.clone(),
        wall_ms: *wall_ms,
        peak_memory_bytes: peak_memory_bytes(),
        gbuffer: GBufferReport::from(products.coverage),
        sscr: products.bounces.clone(),
    }
}
