//! What can be written on the command line. Defaults are the library's.

use std::path::PathBuf;

use catoptric::renderer::BackendChoice;
use catoptric::scene::Override;
use clap::{Args, Parser, Subcommand, ValueEnum};

use super::Usage;

/// Renders point clouds with global illumination, and recognises the mirrors in them.
///
/// A SCENE is a TOML file (docs/SCENE_FILES.md); a CLOUD is a point file (PLY, LAS, LAZ), for which camera and up axis
/// are chosen to fit. No light is: without one, points show their colours, shaded by depth.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, after_help = EXIT_STATUS)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

const EXIT_STATUS: &str = "\
Exit status: 0 done, 1 failed or cancelled (nothing half-written is left), 2 wrong usage.

Examples:
  catoptric generate sphere -o scenes       make a room with a mirror ball
  catoptric render scenes/sphere.toml -o sphere.png
  catoptric info scan.laz                   what is in a cloud, and what would run";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    Render(Box<RenderArgs>),
    #[cfg(feature = "viewer")]
    View(ViewerArgs),
    Info(InfoArgs),
    Generate(GenerateArgs),
    Compare(CompareArgs),
    Sweep(SweepArgs),
    Tune(TuneArgs),
}

/// Render a scene or a cloud to a picture, and its camera G-buffer to an EXR.
#[derive(Debug, Args)]
#[command(after_help = RENDER_HELP)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// The picture: .png (8-bit sRGB, exposed and tone mapped) or .exr (radiance in W/sr/m2) [default: the scene's
    /// name with .png, in the current folder, where no other output is asked for].
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,

    /// The camera's G-buffer: albedo, normal, position, depth and material per pixel, as .exr.
    #[arg(long, value_name = "FILE.exr")]
    pub(super) gbuffer: Option<PathBuf>,

    /// Write what each mirror pixel shows: the mirrors' G-buffer, as FILE.exr; empty where no mirror is seen
    #[arg(long, value_name = "FILE")]
    pub(super) mirror_gbuffer: Option<PathBuf>,

    /// Where the searches of mirrors end: steps, misses and residual, as .exr (layers) or .png (three pictures side by
    /// side, dark to bright); empty where no mirror is seen. Runs the search once more.
    #[arg(long, value_name = "FILE")]
    pub(super) search_heat: Option<PathBuf>,

    /// The camera beside the G-buffer, as JSON: what other programs need to project with it.
    #[arg(long, value_name = "FILE.json")]
    pub(super) camera_json: Option<PathBuf>,

    /// What ran, what it took and what it gave, as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub(super) report: Option<PathBuf>,

    /// Where to render. `auto` takes a graphics processor, or the CPU where there is none; `gpu` takes a software
    /// adapter too.
    #[arg(long, value_enum, default_value_t = BackendName::Auto)]
    pub(super) backend: BackendName,

    /// The graphics adapter, by a part of its name.
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,

    #[command(flatten)]
    pub(super) view: ViewArgs,
}

const RENDER_HELP: &str = "\
Flags beat --set, which beats the file, which beats the defaults.
`catoptric info --settings` lists every setting with its unit, range and default.

Examples:
  catoptric render pointclouds/sphere.toml -o sphere.png
  catoptric render scan.laz -o scan.png --size 1920x1080 --eye -10,-20,15 --target 0,0,2
  catoptric render pointclouds/sphere.toml -o /dev/null --gbuffer sphere.exr --report sphere.json
  catoptric render pointclouds/plane.toml -o plane.png --set splat.size=2 --set light.0.intensity=9,9,9";

/// A scene with what is said on top of it.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// A scene (.toml) or a point cloud.
    #[arg(value_name = "SCENE|CLOUD")]
    pub(super) path: PathBuf,

    /// The triangle mesh (PLY with faces) of a scene that is generated from one: "bunny", "multi".
    #[arg(long, value_name = "FILE.ply")]
    mesh: Option<PathBuf>,

    /// Takes the place of a setting, or of a key of camera, cloud.N, light.N or mirror.N (N from 0). Values are TOML;
    /// quotes and brackets may be left out: image.tone_map=aces, camera.position=0,0,2, camera.size=800x600. May be
    /// given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// The flags that have a key in the scene.
#[derive(Debug, Default, Args)]
pub(super) struct ViewArgs {
    /// Width and height of the picture, pixels [default: the scene's, or 800x600].
    #[arg(long, value_name = "WxH")]
    size: Option<String>,

    /// Where the eye is [default: the scene's, or where everything is seen].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    eye: Option<String>,

    /// What it looks at [default: the scene's, or its middle].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    target: Option<String>,

    /// Roughly up [default: the scene's, or along the up axis].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<String>,

    /// Vertical field of view, degrees [default: the scene's, or 60].
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    fov: Option<String>,

    /// What is shown where nothing is seen: transparent or #rrggbb (sRGB) [default: the scene's, or #000000].
    #[arg(long, value_name = "COLOUR")]
    background: Option<String>,
}

/// Look at a scene or a cloud in a window, and tune the search while watching.
///
/// F1 lists keys and mouse.
#[cfg(feature = "viewer")]
#[derive(Debug, Args)]
pub(super) struct ViewerArgs {
    /// A scene (.toml) or a point cloud; without one the window asks.
    #[arg(value_name = "SCENE|CLOUD")]
    path: Option<PathBuf>,

    /// The triangle mesh (PLY with faces) of a scene that is generated from one.
    #[arg(long, value_name = "FILE.ply", requires = "path")]
    mesh: Option<PathBuf>,

    /// Takes the place of a setting or of a key of the scene, as in `catoptric render`. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "path")]
    set: Vec<String>,

    #[command(flatten)]
    pub(super) place: WhereArgs,
}

#[cfg(feature = "viewer")]
impl ViewerArgs {
    /// The scene with what is said on top of it.
    pub(super) fn scene(&self) -> Option<SceneArgs> {
        Some(SceneArgs {
            path: self.path.clone()?,
            mesh: self.mesh.clone(),
            set: self.set.clone(),
        })
    }
}

/// Tell what is in a scene or a cloud: counts, bounds, fields, and what would run and why.
#[derive(Debug, Args)]
pub(super) struct InfoArgs {
    #[command(flatten)]
    pub(super) scene: Option<SceneArgs>,

    /// As JSON.
    #[arg(long)]
    pub(super) json: bool,

    /// List every setting instead, with what it does, its unit, range and default.
    #[arg(long, conflicts_with_all = ["path", "mesh", "set"])]
    pub(super) settings: bool,
}

/// Make a reference scene: NAME.ply (points with linear float colours) and NAME.toml (light and camera).
///
/// Each is a room of coloured walls with a mirror in it, in metres, y up.
#[derive(Debug, Args)]
pub(super) struct GenerateArgs {
    /// Which scene: sphere, parabola, blob, torus, plane, multi, bumps, or bunny (needs --mesh).
    #[arg(value_name = "NAME")]
    pub(super) name: String,

    /// The folder to write to; it is made where it is missing [default: the current one].
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,

    /// Number of points, spread evenly by area [default: 1600000].
    #[arg(long, value_name = "N")]
    pub(super) points: Option<usize>,

    /// Seed of the random numbers; the same seed makes the same points [default: 1].
    #[arg(long, value_name = "S")]
    pub(super) seed: Option<u64>,

    /// The triangle mesh of bunny (needed) and multi (which leaves its place empty without).
    #[arg(long, value_name = "FILE.ply")]
    pub(super) mesh: Option<PathBuf>,
}

/// Where a measurement runs.
#[derive(Debug, Args)]
pub(super) struct WhereArgs {
    /// Where to render, as in `catoptric render`.
    #[arg(long, value_enum, default_value_t = BackendName::Auto)]
    pub(super) backend: BackendName,

    /// The graphics adapter, by a part of its name.
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
}

/// Render a scene with named settings, side by side with the traced reference of the same points: what each costs and
/// how well its mirrors show what they ought to.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub(super) struct CompareArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// Settings to compare, with a name. May be given several times [default: interleaved, guided and ray_trace].
    #[arg(long = "variant", value_name = "NAME:KEY=VALUE,...")]
    pub(super) variants: Vec<String>,

    /// What somebody else says of the scene: an .npz archive of what mirrors show, or an .exr picture. May be given several
    /// times.
    #[arg(long = "truth", value_name = "FILE")]
    pub(super) truths: Vec<PathBuf>,

    /// Search every interleaved variant in f64, too, and tell where f32 parts from it.
    #[arg(long)]
    pub(super) precision: bool,

    /// Timed frames of each variant, in turn, after one that is not timed.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) repeats: u32,

    /// A folder for report.html, compare.json and the pictures; it is made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,

    #[command(flatten)]
    pub(super) place: WhereArgs,
}

const COMPARE_HELP: &str = "\
docs/MEASURING.md says what is measured, and how.

Examples:
  catoptric compare pointclouds/sphere.toml -o sphere
  catoptric compare scan.toml --variant few:sscr.points_per_pixel=2 --variant many:sscr.points_per_pixel=20
  catoptric compare pointclouds/sphere.toml --truth sphere_aov.npz --repeats 3";

/// Render a scene with all combinations of the values of some keys: what each costs and how well its mirrors show what
/// they ought to, as CSV, JSON lines, plots and a report.
///
/// An interrupted sweep goes on where it stopped when the same command is given again.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_HELP)]
pub(super) struct SweepArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// A key that --set knows, and the values that it is to have; where values hold commas, `;` separates them. May be
    /// given several times.
    #[arg(long, value_name = "KEY=A,B,C")]
    pub(super) vary: Vec<String>,

    /// Timed frames of each combination, in turn [default: 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) repeats: Option<u32>,

    /// The folder for sweep.csv, sweep.jsonl, report.html and the plots; it is made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,

    #[command(flatten)]
    pub(super) place: WhereArgs,
}

const SWEEP_HELP: &str = "\
Instead of a scene there may be a file that says scene, set, vary and repeats: docs/experiments has some.

Examples:
  catoptric sweep pointclouds/sphere.toml --vary sscr.points_per_pixel=1,2,4,8,16 -o sweep
  catoptric sweep scan.toml --vary sscr.seed_attempts=0,1,2,4 --vary camera.size=400x300,800x600 -o sweep
  catoptric sweep docs/experiments/figure_5_4.toml -o figure_5_4";

/// Find the settings to use, on this machine and for this scene: the best mirrors in a given time, or mirrors of a given
/// quality in the shortest. Prints TOML to paste into the scene, what to expect of it, and what was tried.
///
/// Ends with exit status 1 where what is wanted was not reached; the best that was is printed all the same.
#[derive(Debug, Args)]
#[command(after_help = TUNE_HELP)]
pub(super) struct TuneArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// Wall time of a frame, milliseconds, that is not to be exceeded.
    #[arg(
        long,
        value_name = "MS",
        conflicts_with = "quality",
        allow_hyphen_values = true
    )]
    pub(super) budget_ms: Option<f64>,

    /// What mirrors show is to be at least as near to the traced reference as this: PSNR of its albedo, dB.
    #[arg(long, value_name = "DB", allow_hyphen_values = true)]
    pub(super) quality: Option<f64>,

    /// The settings that may change [default: reflect.method and those of sscr that trade speed against accuracy].
    #[arg(long, value_name = "KEY,KEY,...")]
    pub(super) keys: Option<String>,

    /// How many settings are tried at first; half of them stay on, again and again.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(4..=1000))]
    pub(super) candidates: u32,

    #[command(flatten)]
    pub(super) place: WhereArgs,
}

const TUNE_HELP: &str = "\
Examples:
  catoptric tune pointclouds/sphere.toml --budget-ms 500
  catoptric tune scan.toml --quality 30 --set reflect.method=sscr --keys sscr.points_per_pixel,sscr.pull_levels";

/// Where to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BackendName {
    Auto,
    Gpu,
    Cpu,
}

impl WhereArgs {
    /// The backend that they ask for.
    pub(super) fn choice(&self) -> Result<BackendChoice, Usage> {
        backend(self.backend, self.adapter.as_deref())
    }
}

/// The backend that the flags ask for.
pub(super) fn backend(name: BackendName, adapter: Option<&str>) -> Result<BackendChoice, Usage> {
    match (name, adapter) {
        (BackendName::Cpu, Some(_)) => Err(Usage(
            "--adapter names a graphics adapter, which --backend cpu does not use; leave one out"
                .into(),
        )),
        (BackendName::Cpu, None) => Ok(BackendChoice::Cpu),
        (BackendName::Auto, None) => Ok(BackendChoice::Auto),
        (BackendName::Gpu, name) | (BackendName::Auto, name @ Some(_)) => {
            Ok(BackendChoice::Gpu(name.map(str::to_owned)))
        }
    }
}

impl SceneArgs {
    /// What is said on top of the scene, as words of a command line.
    #[cfg(feature = "viewer")]
    pub(super) fn given(&self) -> Vec<String> {
        let set = self.set.iter().flat_map(|text| ["--set", text]);
        let mut words: Vec<String> = set.map(str::to_owned).collect();
        if let Some(mesh) = &self.mesh {
            words.extend(["--mesh".to_owned(), mesh.display().to_string()]);
        }
        words
    }

    /// What is said on top of the scene; flags beat --set, so they come last.
    pub(super) fn overrides(&self, view: &ViewArgs) -> catoptric::Result<Vec<Override>> {
        let mut overrides = Vec::new();
        for set in &self.set {
            overrides.push(Override::parse(set, &format!("--set {set}"))?);
        }
        for (flag, key, text) in [
            ("--size", "camera.size", &view.size),
            ("--eye", "camera.position", &view.eye),
            ("--target", "camera.target", &view.target),
            ("--up", "camera.up", &view.up),
            ("--fov", "camera.fov_y_degrees", &view.fov),
            ("--background", "image.background", &view.background),
        ] {
            if let Some(text) = text {
                overrides.push(Override::new(key, text, &format!("{flag} {text}"))?);
            }
        }
        if let Some(mesh) = &self.mesh {
            overrides.push(Override::mesh(mesh, &format!("--mesh {}", mesh.display())));
        }
        Ok(overrides)
    }
}
