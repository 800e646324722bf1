//! From the points of a scene's clouds to surfels: clipping, colours, mirrors, packing, order.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;

use super::clean::clamp_column;
use super::guard::require_memory;
use super::normals::towards;
use super::points::{CloudPoints, LONE_RADIUS, origin_of};
use super::rules::{CLASSIFICATION, mirror_column};
use super::shuffle::shuffled;
use super::tint::{ColourBy, albedo_by, percentile};
use super::{Bounds, CloudFacts, Facts, Finish, MirrorRule, Place, RawCloud, Surfel, Surfels};
use crate::error::{Error, Result};
use crate::job::Job;

/// Memory that a point takes while it is packed and shuffled.
const BYTES_PER_POINT: u64 = 80;

/// A cloud as the scene wants it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedCloud {
    /// As read or generated.
    pub raw: RawCloud,
    /// From the cloud's frame to the scene's; must neither mirror nor flatten.
    pub transform: Option<DMat4>,
    /// How its points look.
    pub look: Look,
}

impl From<RawCloud> for PlacedCloud {
    /// Where it is, as it is.
    fn from(raw: RawCloud) -> Self {
        Self {
            raw,
            transform: None,
            look: Look {
                name: "cloud".to_owned(),
                ..Look::default()
            },
        }
    }
}

/// How the points of a cloud look: what can be changed without reading it again.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Look {
    /// For messages and reports.
    pub name: String,
    /// For points whose file says nothing else.
    pub material: Material,
    /// Which points are mirrors.
    pub mirrors: Vec<MirrorRule>,
    /// What gives points their albedo.
    pub colour: ColourBy,
    /// What normals that its file lacks turn to, in the scene's frame; `None` is that of the whole scene.
    pub viewpoint: Option<DVec3>,
    /// The cloud is cut by this box, borders included; in the scene's frame.
    pub clip: Option<Bounds>,
}

/// The specular part of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Specular reflectance, 0 to 1.
    pub specular: f32,
    /// Exponent of the normalised Phong lobe.
    pub shininess: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            specular: 0.0,
            shininess: 1.0,
        }
    }
}

/// Surfels, ready to be drawn, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// In shuffled order.
    pub surfels: Surfels,
    /// Counts, bounds, repairs.
    pub facts: Facts,
}

/// Makes surfels of the clouds of a scene: [`CloudPoints::new`] of each, then [`assemble`].
///
/// # Errors
/// As these two.
pub fn prepare(clouds: Vec<PlacedCloud>, viewpoint: DVec3, job: &Job) -> Result<Prepared> {
    let mut parts = Vec::with_capacity(clouds.len());
    for cloud in clouds {
        let points = CloudPoints::new(cloud.raw, cloud.transform.as_ref(), &cloud.look.name, job)?;
        parts.push((Arc::new(points), cloud.look));
    }
    assemble(parts, viewpoint, job)
}

/// The points that are drawn of a cloud, and what they look like.
struct Part {
    points: Arc<CloudPoints>,
    look: Look,
    /// Which of the points, where not all of them.
    kept: Option<Vec<u32>>,
    bounds: Bounds,
}

impl Part {
    fn new(points: Arc<CloudPoints>, look: Look) -> Self {
        let all = points.bounds;
        let Some(clip) = look.clip.filter(|clip| !clip.contains_box(all)) else {
            return Self {
                points,
                look,
                kept: None,
                bounds: all,
            };
        };
        let positions = &points.raw.positions;
        let kept: Vec<u32> = (0..positions.len() as u32)
            .into_par_iter()
            .filter(|&index| clip.contains(positions[index as usize]))
            .collect();
        let bounds = Bounds::of(kept.iter().map(|&index| positions[index as usize]));
        Self {
            points,
            look,
            kept: Some(kept),
            bounds,
        }
    }

    fn len(&self) -> usize {
        self.kept.as_ref().map_or(self.points.len(), Vec::len)
    }
}

/// Makes surfels of the points of clouds.
///
/// Cuts clouds by their boxes, chooses the origin, colours the points, finds mirrors, turns estimated normals towards
/// `viewpoint` (in the scene's frame), and shuffles. What was dropped and repaired is counted in [`Facts::repairs`]. The
/// result is the same for any number of threads. Points that nobody else holds are freed as soon as they are packed.
///
/// # Errors
/// [`Error::Cloud`] for a rule or a colouring whose column a cloud lacks; [`Error::Setting`] for more points than can be
/// counted; [`Error::NoPoints`], [`Error::Memory`], [`Error::Cancelled`].
pub fn assemble(
    clouds: Vec<(Arc<CloudPoints>, Look)>,
    viewpoint: DVec3,
    job: &Job,
) -> Result<Prepared> {
    let read: u64 = clouds.iter().map(|(c, _)| u64::from(c.read())).sum();
    if u32::try_from(read).is_err() {
        return Err(Error::Setting(format!(
            "the scene has {read} points, and 4294967295 can be drawn; use fewer"
        )));
    }
    job.progress("placing points", 0, read)?;
    let scale = clouds.iter().filter_map(|(c, _)| c.raw.scale);
    let scale = scale.reduce(DVec3::max);
    let parts: Vec<Part> = clouds
        .into_iter()
        .map(|(points, look)| Part::new(points, look))
        .collect();
    let count: usize = parts.iter().map(Part::len).sum();
    if count == 0 {
        return Err(no_points(&parts));
    }
    require_memory("preparing the points", count as u64 * BYTES_PER_POINT)?;
    let bounds = parts.iter().map(|part| part.bounds).reduce(Bounds::union);
    let bounds = bounds.unwrap_or_else(|| Bounds::of([]));
    let origin = origin_of(bounds, scale);

    let mut all = Surfels {
        places: Vec::with_capacity(count),
        finishes: Vec::with_capacity(count),
        source: Vec::with_capacity(count),
        origin,
    };
    let mut facts = Facts {
        points: count as u64,
        bounds,
        spacing: 0.0,
        origin,
        repairs: Default::default(),
        mirror_points: 0,
        has_specular: false,
        clouds: Vec::new(),
    };
    let mut first = 0;
    for part in parts {
        job.progress("packing", u64::from(first), read)?;
        facts.clouds.push(facts_of(&part));
        facts.repairs += part.points.repairs;
        let viewpoint = part.look.viewpoint.unwrap_or(viewpoint);
        let viewpoint = (viewpoint - origin).as_vec3();
        facts.repairs.values += pack(&part, viewpoint, first, &mut all)?;
        first += part.points.read();
    }
    let mirrors = all.finishes.par_iter().filter(|f| f.mirror() > 0.0);
    facts.mirror_points = mirrors.count() as u64;
    facts.has_specular = all.finishes.par_iter().any(|f| f.specular() > 0.0);
    let mut radii: Vec<f32> = all.places.par_iter().map(|place| place.radius).collect();
    facts.spacing = f64::from(percentile(&mut radii, 0.5).unwrap_or(LONE_RADIUS));

    job.progress("shuffling", 0, 0)?;
    Ok(Prepared {
        surfels: shuffled(all),
        facts,
    })
}

fn no_points(parts: &[Part]) -> Error {
    let cut: usize = parts.iter().map(|part| part.points.len()).sum();
    if cut > 0 {
        return Error::NoPoints(format!(
            "the clip box leaves none of {cut}; make it larger or remove it"
        ));
    }
    let lost = parts.iter().map(|part| part.points.repairs);
    let lost = lost.fold((0, 0), |sum, r| (sum.0 + r.not_finite, sum.1 + r.withheld));
    Error::NoPoints(match lost {
        (0, 0) => "name a cloud that has some".to_owned(),
        (lost, withheld) => {
            format!(
                "{lost} have no finite coordinates up to 1e15 and {withheld} are withheld by their file"
            )
        }
    })
}

fn facts_of(part: &Part) -> CloudFacts {
    let raw = &part.points.raw;
    CloudFacts {
        name: part.look.name.clone(),
        format: raw.format.clone(),
        points: part.len() as u64,
        has_colour: raw.albedo.is_some(),
        has_normals: part.points.states_normals(),
        has_intensity: raw.intensity.is_some(),
        classes: classes_of(part),
        column_names: raw.column_names.clone(),
        unit: raw.unit.clone(),
        up_axis: raw.up_axis,
    }
}

fn classes_of(part: &Part) -> BTreeMap<u8, u64> {
    let mut columns = part.points.raw.columns.iter();
    let column = columns.find(|(name, _)| name.eq_ignore_ascii_case(CLASSIFICATION));
    let mut counts = [0_u64; 256];
    let mut count = |class: f32| {
        // What is no whole number from 0 to 255 is no class.
        let known = (0.0..=255.0).contains(&class) && class.fract() == 0.0;
        if let Some(count) = counts.get_mut(class as usize).filter(|_| known) {
            *count += 1;
        }
    };
    match (column, &part.kept) {
        (Some((_, values)), None) => values.iter().for_each(|class| count(*class)),
        (Some((_, values)), Some(kept)) => {
            let drawn = kept.iter().filter_map(|&i| values.get(i as usize));
            drawn.for_each(|class| count(*class));
        }
        (None, _) => {}
    }
    (0..=u8::MAX)
        .zip(counts)
        .filter(|(_, count)| *count > 0)
        .collect()
}

/// Adds the surfels of one cloud, whose first point has the index `first` among all sources, to `all`; gives the number of
/// values that were clamped.
fn pack(part: &Part, viewpoint: Vec3, first: u32, all: &mut Surfels) -> Result<u64> {
    let (points, look) = (&*part.points, &part.look);
    let raw = &points.raw;
    let mut mirror = mirror_column(raw, &raw.positions, &look.mirrors, &look.name)?;
    let clamped = clamp_column(&mut mirror, 1.0);
    let albedo = albedo_by(look.colour, raw, &look.name)?;
    let origin = all.origin;
    let value = |column: &Option<Vec<f32>>, index: usize, default: f32| {
        column.as_ref().map_or(default, |c| c[index])
    };
    let surfel = |index: usize| {
        let position = (raw.positions[index] - origin).as_vec3();
        let mut normal = points.normals[index];
        if points.estimated.at(index) {
            normal = towards(viewpoint, position, normal);
        }
        let surfel = Surfel {
            position,
            radius: points.radii[index],
            normal,
            albedo: albedo[index],
            mirror: value(&mirror, index, 0.0),
            specular: value(&raw.specular, index, look.material.specular),
            shininess: value(&raw.shininess, index, look.material.shininess),
        };
        let place = Place {
            position: surfel.position,
            radius: surfel.radius,
        };
        (place, Finish::pack(&surfel))
    };
    let (places, finishes): (Vec<Place>, Vec<Finish>) = match &part.kept {
        None => (0..points.len()).into_par_iter().map(surfel).unzip(),
        Some(kept) => kept.par_iter().map(|&i| surfel(i as usize)).unzip(),
    };
    all.places.extend(places);
    all.finishes.extend(finishes);
    let source = |index: usize| first + points.source_of(index);
    match &part.kept {
        None => all.source.extend((0..points.len()).map(source)),
        Some(kept) => all.source.extend(kept.iter().map(|&i| source(i as usize))),
    }
    Ok(clamped)
}
