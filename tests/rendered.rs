//! Scenes through the library, from their text to what a frame gives on the processor.

use std::path::Path;

use catoptric::Job;
use catoptric::grid::Grid;
use catoptric::reflect::Method;
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{LoadedScene, Scene};
use catoptric::settings::Settings;
use glam::Vec4;

use crate::analytic::View;

/// A scene that can be rendered again and again.
pub(crate) struct Opened {
    pub(crate) settings: Settings,
    pub(crate) loaded: LoadedScene,
    renderer: Renderer,
}

impl Opened {
    /// A scene from its text, which may read files of the folder `at`.
    pub(crate) fn new(text: &str, at: &Path) -> Self {
        let scene = Scene::parse(text, &at.join("scene.toml"), &[]).expect("a sound scene");
        let loaded = scene.load(&Job::default()).expect("sound clouds");
        let renderer =
            Renderer::new(&BackendChoice::Cpu, &loaded.surfels).expect("the processor is there");
        Self {
            settings: scene.settings,
            loaded,
            renderer,
        }
    }

    /// A generated scene of so many points, seen by the oracle's camera.
    pub(crate) fn generated(name: &str, points: usize, view: &View) -> Self {
        Self::new(&generated(name, points, view), Path::new(""))
    }

    /// One frame. No value of it may be other than a number, whatever the scene.
    pub(crate) fn render(&mut self, settings: &Settings) -> Products {
        let view = self.loaded.view().expect("a sound camera");
        let plan = self.loaded.plan(settings);
        let products = self
            .renderer
            .render(&view, &plan, settings, &Job::default())
            .expect("no cancellation");
        all_numbers(&products);
        products
    }

    /// One frame by a method, the scene's settings otherwise.
    pub(crate) fn by(&mut self, method: Method) -> Products {
        let mut settings = self.settings.clone();
        settings.reflect.method = method;
        self.render(&settings)
    }
}

/// The text of a generated scene with its light, seen by the oracle's camera.
pub(crate) fn generated(name: &str, points: usize, view: &View) -> String {
    format!(
        "format = 1\n[[cloud]]\ngenerate = \"{name}\"\npoints = {points}\n\
         [[cloud.mirror]]\nproperty = \"mirror\"\n{LIGHT}{}",
        camera(view)
    )
}

/// The light of the reference scenes.
pub(crate) const LIGHT: &str = "[[light]]\nkind = \"spot\"\nposition = [-0.6, 0.9, 0.2]\n\
                                target = [1, -1, -3]\nintensity = [6, 6, 6]\n";

/// The oracle's camera, in the words of a scene.
pub(crate) fn camera(view: &View) -> String {
    let list = |v: glam::DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    format!(
        "[camera]\nposition = {}\ntarget = {}\nup = {}\nfov_y_degrees = {:?}\nsize = [{}, {}]\n",
        list(view.position),
        list(view.target),
        list(view.up),
        view.fov_y_degrees,
        view.width,
        view.height
    )
}

/// Fails where a value of a frame is infinite or no number.
pub(crate) fn all_numbers(products: &Products) {
    let gbuffer = &products.gbuffer;
    let mut grids = vec![
        ("surface", &gbuffer.surface),
        ("albedo", &gbuffer.albedo),
        ("material", &gbuffer.material),
        ("radiance", &products.radiance),
    ];
    if let Some(mirror) = &products.mirror {
        grids.extend([
            ("origin", &mirror.origin),
            ("direction", &mirror.direction),
            ("reflected surface", &mirror.surface),
            ("reflected albedo", &mirror.albedo),
            ("reflected material", &mirror.material),
        ]);
        let level = mirror.level.values().iter().position(|l| !l.is_finite());
        assert_eq!(level, None, "a level that is no number");
    }
    for (name, grid) in grids {
        let wrong = first_that_is_no_number(grid);
        assert_eq!(wrong, None, "a {name} that is no number");
    }
    for bounce in &products.bounces {
        let shares = [bounce.hit_rate, bounce.coverage, bounce.coverage_closed];
        let sound = |share: &f64| (0.0..=1.0).contains(share);
        assert!(
            shares.iter().all(sound) && bounce.mean_steps.is_finite(),
            "{bounce:?}"
        );
    }
}

fn first_that_is_no_number(grid: &Grid<Vec4>) -> Option<usize> {
    grid.values().iter().position(|v| !v.is_finite())
}
