//! The oracle against what an independent renderer says of the same scenes (`CATOPTRIC_TRUTH` names the folder).

use std::path::PathBuf;

use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use rayon::prelude::*;

use crate::analytic::{Hit, Kind, Oracle, View, WALLS, reflect};
use crate::generate::claim;
use crate::npz::Npz;

/// The folder of reference results, where the caller has one.
fn truth() -> Option<PathBuf> {
    std::env::var_os("CATOPTRIC_TRUTH").map(PathBuf::from)
}

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![claim(a_view_from_elsewhere_shows_the_same_points)];
    for scene in ["sphere", "parabola", "plane"] {
        let name = format!("oracle::{scene}_agrees_with_an_independent_renderer");
        let test = move || agrees_with_an_independent_renderer(scene);
        trials.push(Trial::test(name, test).with_ignored_flag(truth().is_none()));
        let name = format!("oracle::direct_light_of_{scene}_agrees_with_an_independent_renderer");
        let test = move || direct_light_agrees(scene);
        trials.push(Trial::test(name, test).with_ignored_flag(truth().is_none()));
    }
    trials
}

/// Residuals of the oracle's implicit forms and what it hits must agree from any side.
fn a_view_from_elsewhere_shows_the_same_points() {
    for name in [
        "sphere", "parabola", "blob", "torus", "plane", "bumps", "multi",
    ] {
        let oracle = Oracle::named(name);
        let view = View {
            width: 80,
            height: 60,
            ..View::REFERENCE
        };
        let elsewhere = DVec3::new(0.3, 0.2, 0.7);
        let mut mirrors = 0;
        for hit in oracle.view(&view) {
            let Kind::Mirror(number) = hit.kind else {
                continue;
            };
            mirrors += 1;
            let again = oracle.cast(elsewhere, hit.position - elsewhere);
            let hidden = again.t < 1.0 - 1e-6 || hit.normal.dot(elsewhere - hit.position) < 1e-3;
            let same = again.kind == Kind::Mirror(number)
                && (again.position - hit.position).length() < 1e-6;
            assert!(
                hidden || same,
                "{name}: {hit:?} looks like {again:?} from elsewhere"
            );
        }
        assert!(
            mirrors > 100,
            "{name}: {mirrors} pixels show a mirror, too few to tell"
        );
    }
}

/// Whether a hit lies on an edge of the room, where it may show either wall.
fn on_edge(hit: &Hit) -> bool {
    WALLS
        .iter()
        .filter(|w| (hit.position[w.1] - w.2).abs() < 1e-6)
        .count()
        > 1
}

/// The value that a part of a list does not exceed.
fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part) as usize]
}

/// Differences between what the oracle and the reference see.
#[derive(Debug)]
struct Differences {
    /// Pixels that show different things, directly or by the mirror.
    kind: usize,
    /// Largest, metres.
    distance: f64,
    /// Largest, degrees.
    normal: f64,
    /// Of what the mirror shows: 99.9 % are nearer, metres.
    reflected: f64,
    /// Pixels that the mirror colours differently.
    albedo: usize,
}

impl Differences {
    fn small(&self) -> bool {
        // The reference is stored in 32 bits; outlines and edges of squares may fall to either side.
        self.kind < 10
            && self.distance < 1e-6
            && self.normal < 1e-5
            && self.reflected < 1e-6
            && self.albedo < 20
    }
}

fn differences(oracle: &Oracle, view: &View, scene: &str) -> Result<Differences, Failed> {
    let npz = Npz::open(
        &truth()
            .ok_or("CATOPTRIC_TRUTH is unset")?
            .join(format!("{scene}_aov.npz")),
    )?;
    let (t, ids, mirror) = (
        npz.floats("t")?,
        npz.bytes("prim_id")?,
        npz.bytes("mirror")?,
    );
    let (positions, normals) = (npz.vectors("P")?, npz.vectors("N")?);
    let (reflected, reflected_ids) = (npz.vectors("Q")?, npz.bytes("Qid")?);
    let reflected_albedo = npz.vectors("Qalb")?;
    let (mut different, mut albedo) = (0, 0);
    let (mut distances, mut angles, mut reflections) = (Vec::new(), Vec::new(), Vec::new());
    for (i, hit) in oracle.view(view).iter().enumerate() {
        let ray = view.direction(i % view.width, i / view.width);
        let id = match hit.kind {
            Kind::Wall(number) => number,
            Kind::Mirror(_) | Kind::Back(_) => 10,
        };
        if id != ids[i] {
            different += usize::from(!on_edge(hit));
            continue;
        }
        distances.push((hit.t * ray.length() - f64::from(t[i])).abs());
        if mirror[i] == 0 {
            continue;
        }
        distances.push((hit.position - positions[i]).length());
        angles.push(hit.normal.angle_between(normals[i]).to_degrees());
        let next = oracle.cast(hit.position, reflect(ray, hit.normal));
        if matches!(next.kind, Kind::Wall(number) if number == reflected_ids[i]) {
            reflections.push((next.position - reflected[i]).length());
            albedo += usize::from((next.albedo - reflected_albedo[i]).length() > 1e-3);
        } else if reflected_ids[i] < 10 {
            different += usize::from(!on_edge(&next));
        }
    }
    Ok(Differences {
        kind: different,
        distance: quantile(distances, 1.0),
        normal: quantile(angles, 1.0),
        reflected: quantile(reflections, 0.999),
        albedo,
    })
}

fn agrees_with_an_independent_renderer(scene: &str) -> Result<(), Failed> {
    let oracle = Oracle::named(scene);
    let found = differences(&oracle, &View::REFERENCE, scene)?;
    assert!(found.small(), "{scene}: {found:?}");
    // Negative control: a camera 0.1 mm beside the right place.
    let beside = DVec3::X * 1e-4;
    let (position, target) = (
        View::REFERENCE.position + beside,
        View::REFERENCE.target + beside,
    );
    let found = differences(
        &oracle,
        &View {
            position,
            target,
            ..View::REFERENCE
        },
        scene,
    )?;
    assert!(
        !found.small() && found.distance > 1e-5,
        "{scene} from 0.1 mm beside: {found:?}"
    );
    Ok(())
}

fn direct_light_agrees(scene: &str) -> Result<(), Failed> {
    let (oracle, view) = (Oracle::named(scene), View::REFERENCE);
    for bounces in [1, 4] {
        let path = truth()
            .ok_or("CATOPTRIC_TRUTH is unset")?
            .join(format!("{scene}_direct{bounces}.exr"));
        let image = exr::prelude::read_first_rgba_layer_from_file(
            path,
            |size, _| vec![DVec3::ZERO; size.area()],
            |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| {
                pixels[at.y() * View::REFERENCE.width + at.x()] =
                    DVec3::new(r.into(), g.into(), b.into());
            },
        )?;
        let reference = image.layer_data.channel_data.pixels;
        let ours: Vec<DVec3> = (0..reference.len())
            .into_par_iter()
            .map(|i| {
                oracle.radiance(
                    view.position,
                    view.direction(i % view.width, i / view.width),
                    bounces,
                )
            })
            .collect();
        let off = |factor: f64| {
            let pairs = ours.iter().zip(&reference);
            pairs
                .filter(|(a, b)| (**a * factor - **b).length() > 0.01 * b.length() + 1e-4)
                .count() as f64
                / reference.len() as f64
        };
        let (right, brighter) = (off(1.0), off(1.03));
        assert!(
            right < 1e-3,
            "{scene}, {bounces} bounces: {right} of the pixels are off by more than 1 %"
        );
        assert!(
            brighter > 0.2,
            "{scene}, {bounces} bounces: 3 % too bright must be seen, got {brighter}"
        );
    }
    Ok(())
}
