//! Scenes through the library, from their text to what a frame gives on the processor.

use std::path::Path;

use catoptric::Job;
use catoptric::reflect::sscr::Search;
use catoptric::reflect::{Method, MirrorGBuffer};
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{LoadedScene, Scene};
use catoptric::settings::Settings;
use glam::UVec2;
use libtest_mimic::Trial;

use crate::analytic::View;
use crate::support::{claim, empty_products};

pub(crate) fn tests() -> Vec<Trial> {
    vec![claim(
        "rendered::a_value_that_is_no_number_is_noticed",
        a_value_that_is_no_number_is_noticed,
    )]
}

/// How mirrors are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    Interleaved,
    Guided,
    RayTrace,
}

impl Way {
    pub(crate) const ALL: [Self; 3] = [Self::Interleaved, Self::Guided, Self::RayTrace];
}

/// A scene that can be rendered again and again, its mirrors by the interleaved search unless told otherwise.
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
        let mut settings = scene.settings;
        settings.sscr.search = Search::Interleaved;
        Self {
            settings,
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
        assert_eq!(no_number(&products), None);
        products
    }

    /// One frame one way, the scene's settings otherwise.
    pub(crate) fn by(&mut self, way: Way) -> Products {
        let mut settings = self.settings.clone();
        (settings.reflect.method, settings.sscr.search) = match way {
            Way::Interleaved => (Method::Sscr, Search::Interleaved),
            Way::Guided => (Method::Sscr, Search::Guided),
            Way::RayTrace => (Method::RayTrace, Search::Interleaved),
        };
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

/// A value of a frame that is infinite or no number, and where, if there is one.
fn no_number(products: &Products) -> Option<String> {
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
        if let Some(at) = mirror.level.values().iter().position(|l| !l.is_finite()) {
            return Some(format!("level at {at}"));
        }
    }
    for (name, grid) in grids {
        if let Some(at) = grid.values().iter().position(|v| !v.is_finite()) {
            return Some(format!("{name} at {at}"));
        }
    }
    let wrong = products.bounces.iter().find(|bounce| {
        let shares = [bounce.hit_rate, bounce.coverage, bounce.coverage_closed];
        !shares.iter().all(|share| (0.0..=1.0).contains(share)) || !bounce.mean_steps.is_finite()
    });
    wrong.map(|bounce| format!("{bounce:?}"))
}

fn a_value_that_is_no_number_is_noticed() {
    let size = UVec2::new(4, 3);
    let sound = || {
        let mut products = empty_products(size);
        products.mirror = Some(MirrorGBuffer::empty(size));
        products
    };
    assert_eq!(no_number(&sound()), None, "nothing is wrong");
    for value in [f32::NAN, f32::INFINITY] {
        let mut products = sound();
        products.radiance.values_mut()[7].y = value;
        assert_eq!(no_number(&products).as_deref(), Some("radiance at 7"));
        let mut products = sound();
        let mirror = products.mirror.as_mut().expect("a mirror");
        mirror.surface.values_mut()[11].w = value;
        let wrong = no_number(&products);
        assert_eq!(wrong.as_deref(), Some("reflected surface at 11"));
    }
}
