//! The extremes of mirrors, cameras and clouds: each test says what happens. Both methods render every one of them, and no
//! value of any buffer may be other than a number ([`Opened::render`] sees to that).

mod cameras;
mod clouds;

use catoptric::reflect::Method;
use catoptric::renderer::Products;
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::rendered::Opened;
use crate::shown::{Figures, Shown};

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = cameras::tests();
    trials.extend(clouds::tests());
    trials
}

/// A scene as a method renders it, and how well its mirrors show what they ought to.
struct Seen {
    method: Method,
    products: Products,
    figures: Figures,
}

/// An analytic scene of so many points, by both methods.
fn both(scene: &str, points: usize, view: &View) -> [Seen; 2] {
    let truth = Shown::new(&Oracle::named(scene), view);
    let mut opened = Opened::generated(scene, points, view);
    [Method::Sscr, Method::RayTrace].map(|method| {
        let products = opened.by(method);
        let mirror = products.mirror.as_ref().expect("the camera sees a mirror");
        let figures = Figures::of(&truth, mirror);
        println!(
            "{scene}, {method:?}: {:?}, {figures:?}, {} mirror pixels, {} by the oracle",
            products.bounces[0],
            products.coverage.mirror,
            truth.pixels()
        );
        Seen {
            method,
            products,
            figures,
        }
    })
}

/// The reference camera with a small picture.
const SMALL: View = View {
    width: 160,
    height: 120,
    ..View::REFERENCE
};
