//! The extremes of mirrors, cameras and clouds: each test says what happens. Both searches and traced rays render every one of them, and no
//! value of any buffer may be other than a number ([`Opened::render`] sees to that).

mod cameras;
mod clouds;
mod precision;

use catoptric::renderer::Products;
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::rendered::{Opened, Way};
use crate::shown::{Figures, Shown};

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = cameras::tests();
    trials.extend(clouds::tests());
    trials.extend(precision::tests());
    trials
}

/// A scene as one way renders it, and how well its mirrors show what they ought to.
struct Seen {
    way: Way,
    products: Products,
    figures: Figures,
}

/// An analytic scene of so many points, every way.
fn each(scene: &str, points: usize, view: &View) -> [Seen; 3] {
    let truth = Shown::new(&Oracle::named(scene), view);
    let mut opened = Opened::generated(scene, points, view);
    Way::ALL.map(|way| {
        let products = opened.by(way);
        let mirror = products.mirror.as_ref().expect("the camera sees a mirror");
        let figures = Figures::of(&truth, mirror);
        println!(
            "{scene}, {way:?}: {:?}, {figures:?}, {} mirror pixels, {} by the oracle",
            products.bounces[0],
            products.coverage.mirror,
            truth.pixels()
        );
        Seen {
            way,
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
