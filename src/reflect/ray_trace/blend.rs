//! One ray's pixel: the discs that it meets, blended as the camera blends its splats.

use glam::{Vec3, Vec4};

use super::leaf::{Meeting, Ray, tolerance};
use super::tree::{Stack, Tree};
use crate::cloud::{Finish, Surfels, shininess_from_log};
use crate::gbuffer::SplatSettings;
use crate::gbuffer::average::Pixel;
use crate::gbuffer::disc::weight;

/// A disc whose normal is within 45 degrees of the mirror's may be of the mirror's own layer.
const PARALLEL_COSINE: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// A ray that leaves a mirror.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaving {
    pub(super) ray: Ray,
    /// The mirror's, unit length.
    pub(super) normal: Vec3,
}

/// A disc that the ray meets, with what blending needs.
#[derive(Debug, Clone, Copy)]
struct Fragment {
    meeting: Meeting,
    tolerance: f32,
    /// Whether the front of a mirror is seen.
    mirror: bool,
}

/// Traces rays one after the other; keeps its working memory.
#[derive(Debug)]
pub(super) struct Blender<'a> {
    surfels: &'a Surfels,
    settings: &'a SplatSettings,
    /// Thickness of the mirror's own layer, x radius.
    self_hit: f32,
    stack: Stack,
    fragments: Vec<Fragment>,
}

/// The nearest disc so far.
#[derive(Debug, Clone, Copy)]
struct Front {
    distance: f32,
    mirror: bool,
}

/// Weighted sums of attributes.
#[derive(Debug, Default)]
struct Sums {
    count: u32,
    weight: f32,
    behind: f32,
    normal: Vec3,
    albedo: Vec4,
    specular: f32,
    shininess: f32,
    radius: f32,
}

impl<'a> Blender<'a> {
    pub(super) fn new(surfels: &'a Surfels, settings: &'a SplatSettings, self_hit: f32) -> Self {
        Self {
            surfels,
            settings,
            self_hit,
            stack: Stack::default(),
            fragments: Vec::new(),
        }
    }

    /// What the ray shows, and of how many discs; all zero where it meets nothing.
    pub(super) fn trace(&mut self, tree: &Tree, leaving: &Leaving) -> (Pixel, u32) {
        let Self {
            surfels,
            settings,
            self_hit,
            stack,
            fragments,
        } = self;
        let mut front = Front {
            distance: f32::INFINITY,
            mirror: false,
        };
        fragments.clear();
        tree.visit(&leaving.ray, stack, |meeting| {
            let fragment = Fragment {
                meeting,
                tolerance: tolerance(meeting.radius, meeting.cosine, settings),
                mirror: meeting.cosine < 0.0 && meeting.mirror,
            };
            if meeting.distance - fragment.tolerance <= front.distance
                && !leaves_through(&meeting, leaving, *self_hit)
            {
                front = front.nearer(&fragment);
                fragments.push(fragment);
            }
            front.distance
        });
        let mut sums = Sums::default();
        for fragment in fragments.iter() {
            let behind = fragment.meeting.distance - front.distance;
            if fragment.mirror == front.mirror
                && behind <= fragment.tolerance
                && let Some(finish) = surfels.finishes.get(fragment.meeting.surfel as usize)
            {
                sums.add(fragment, *finish, behind);
            }
        }
        let pixel = sums.average(front.distance, leaving.ray.direction);
        (pixel, sums.count)
    }
}

/// Whether the ray passes through a disc of the mirror's own layer on its way out: one that faces the same way as the
/// mirror, is crossed from behind, and has a plane near to where the ray starts. A concave mirror's far side is crossed
/// from its front, and stays.
fn leaves_through(meeting: &Meeting, leaving: &Leaving, self_hit: f32) -> bool {
    meeting.cosine > 0.0
        && meeting.distance * meeting.cosine <= self_hit * meeting.radius
        && meeting.normal.dot(leaving.normal) >= PARALLEL_COSINE
}

impl Front {
    /// The nearer of the two; of discs at the same distance, the one that is no mirror.
    fn nearer(self, fragment: &Fragment) -> Self {
        let distance = fragment.meeting.distance;
        if distance < self.distance || (distance <= self.distance && !fragment.mirror) {
            Self {
                distance,
                mirror: fragment.mirror,
            }
        } else {
            self
        }
    }
}

impl Sums {
    /// Adds a disc, as the ray sees it. From behind, a diffuse surfel turns its normal, and a mirror is opaque and black.
    fn add(&mut self, fragment: &Fragment, finish: Finish, behind: f32) {
        let Meeting {
            off_centre,
            cosine,
            normal,
            radius,
            mirror,
            ..
        } = fragment.meeting;
        let w = weight(off_centre);
        self.count += 1;
        self.weight += w;
        self.behind += w * behind;
        self.radius += w * radius;
        self.normal += normal * if cosine > 0.0 { -w } else { w };
        if fragment.mirror || !mirror {
            self.albedo += finish.albedo().extend(finish.mirror()) * w;
            self.specular += w * finish.specular();
            self.shininess += w * finish.shininess_log();
        }
    }

    fn average(&self, front: f32, direction: Vec3) -> Pixel {
        if self.weight <= 0.0 {
            return Pixel::default();
        }
        let inverse = 1.0 / self.weight;
        // Opposite normals that cancel leave none: the one against the ray is as good.
        let normal = (self.normal * inverse)
            .try_normalize()
            .unwrap_or(-direction);
        Pixel {
            surface: normal.extend(front + self.behind * inverse),
            albedo: self.albedo * inverse,
            material: Vec4::new(
                self.specular * inverse,
                shininess_from_log(self.shininess * inverse),
                self.radius * inverse,
                1.0,
            ),
        }
    }
}
