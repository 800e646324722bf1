//! What can be set about the search.

use super::prefix::Budget;
use crate::gbuffer::SplatSettings;
use crate::{setting_choice, settings_group};

setting_choice! {
    /// How the pixel that shows a point is searched.
    pub enum Search {
        /// Every place where a mirror shows the point: Gauss-Newton steps from where a chart of the mirror reflects towards
        /// it.
        Guided = "guided",
        /// Interleaved bracketing and bisection, one region a point [Preiner 2010, algorithm 3.1].
        Interleaved = "interleaved",
    }
}

setting_choice! {
    /// How the points are shared out among the regions.
    pub enum Distribution {
        /// Each region gets its share of the mirrors' pixels.
        Weighted = "weighted",
        /// Each region gets as many as any other.
        Uniform = "uniform",
    }
}

setting_choice! {
    /// Which of the points found in a mirror pixel it shows.
    pub enum Visibility {
        /// All that lie within `sscr.depth_offset` ("guided": `splat.depth_tolerance`) behind the nearest, averaged.
        Accumulate = "accumulate",
        /// The nearest alone.
        Nearest = "nearest",
    }
}

/// Settings that only the interleaved search heeds.
pub const OF_INTERLEAVED: [&str; 10] = [
    "sscr.seed_attempts",
    "sscr.step_attempts",
    "sscr.max_steps",
    "sscr.initial_step",
    "sscr.threshold",
    "sscr.distribution",
    "sscr.passes",
    "sscr.max_splat",
    "sscr.mirror_far",
    "sscr.depth_offset",
];

/// Settings that only the guided search heeds.
pub const OF_GUIDED: [&str; 1] = ["sscr.points_per_pixel"];

/// How hits become splats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splatting {
    /// Which of the points found in a pixel it shows.
    pub visibility: Visibility,
    /// Depth by which a point may lie behind the nearest of its pixel and still be averaged with it, x spacing.
    pub depth_offset: f32,
    /// The pixels of a splat: those whose ray meets the surfel's disc, of so many times its radius; squares of the hit's
    /// reach where there is none.
    pub disc: Option<f32>,
    /// Mirrors leave out their own points up to this far before them, x spacing.
    pub own_layer: f32,
    /// How much larger surfels are drawn: where a part of the points stands for all.
    pub enlarged: f32,
}

impl SscrSettings {
    /// How many points "guided" searches for mirrors of so many pixels.
    pub fn budget(&self, mirror_pixels: u64) -> Budget {
        if self.points_per_pixel > 0.0 {
            let points = f64::from(self.points_per_pixel) * mirror_pixels as f64;
            Budget::Points(points.ceil() as usize)
        } else {
            Budget::Enough { mirror_pixels }
        }
    }

    /// How hits become splats: of the guided search or the other, which searched so many of the points.
    pub fn splatting(
        &self,
        guided: bool,
        splat: &SplatSettings,
        searched: usize,
        points: usize,
    ) -> Splatting {
        let squares = Splatting {
            visibility: self.visibility,
            depth_offset: self.depth_offset,
            disc: None,
            own_layer: self.self_hit,
            enlarged: 1.0,
        };
        if !guided {
            return squares;
        }
        Splatting {
            depth_offset: splat.depth_tolerance,
            disc: Some(splat.size),
            enlarged: (points as f32 / searched.max(1) as f32).sqrt(),
            ..squares
        }
    }

    /// Half the side of a splat at a distance from the mirror, pixels: it falls linearly to half a pixel at
    /// `sscr.mirror_far`. `diagonal` is that of the scene's box.
    pub fn splat_reach(&self, distance: f32, diagonal: f32) -> f32 {
        let far = (self.mirror_far * diagonal).max(f32::MIN_POSITIVE);
        let nearness = (1.0 - distance / far).max(0.0);
        0.5 * (1.0 + (self.max_splat - 1.0) * nearness)
    }
}

setting_choice! {
    /// How holes in the mirrors are closed.
    pub enum Closing {
        /// From coarser and coarser averages of what surrounds them [Preiner 2010, sections 3.6 and 4.6].
        PullPush = "pull_push",
        /// By tracing the rays of pixels that show nothing, or something far behind what surrounds them. Needs the tree of
        /// `ray_trace`, which is most of its cost; what reflects nothing stays empty.
        Rays = "rays",
        /// Not at all.
        None = "none",
    }
}

settings_group! {
    /// How mirrors are searched for what they show.
    pub struct SscrSettings in "sscr" {
        /// How the pixel that shows a point is searched.
        search: Search = Search::Guided;
        /// Points searched per mirror pixel by "guided", of the shuffled cloud; 0 takes as many as the mirrors need, in
        /// doublings, until they hold four hits a pixel. Fewer blur and cost less, in proportion.
        points_per_pixel: f32 = 0.0, 0.0..=100000.0, "points";
        /// Of "interleaved": How many more random pixels of the region's box are tried for each of the two places where a search starts, if
        /// the first lies outside of the region. The first two gain most [Preiner 2010, figure 5.4]: the sphere's hit rate
        /// is 24, 34, 36 and 37 % for 0, 1, 2 and 4.
        seed_attempts: u32 = 4, 0..=64, "attempts";
        /// Of "interleaved": How often a step that leaves the region is halved before the point is given up. The first two gain most
        /// [Preiner 2010, figure 5.5]: the torus's hit rate is 6, 10, 12 and 13 % for 0, 1, 2 and 4.
        step_attempts: u32 = 2, 0..=64, "attempts";
        /// Of "interleaved": Steps of a search at most. 10 lose points, more than 20 find hardly any more; cost grows with the points that no
        /// mirror shows.
        max_steps: u32 = 24, 1..=1000, "steps";
        /// Of "interleaved": First step, along x and y, as a fraction of the region's box [Preiner 2010, section 3.4 and figure 5.2].
        /// Large ones leave narrow regions, small ones take longer: half the speed at 0.02.
        initial_step: f32 = 0.2, 0.001..=0.5, "x box";
        /// Of "interleaved": Distance of the last two steps below which the point between them is taken. More finds more points, less
        /// exactly: 2 to 4 for the thesis's mirrors [Preiner 2010, figures 3.17 and 5.2].
        threshold: f32 = 2.0, 0.1..=64.0, "pixels";
        /// Of "interleaved": How the points are shared out among the regions [Preiner 2010, section 3.6]. "uniform" starves large regions
        /// where there are many small ones.
        distribution: Distribution = Distribution::Weighted;
        /// Of "interleaved": How often all points are shared out, each time to other regions [Preiner 2010, section 5.6]. Mirrors of many
        /// regions get denser; cost grows in proportion.
        passes: u32 = 1, 1..=16, "passes";
        /// Which of the points found in a mirror pixel it shows [Preiner 2010, section 3.7 and figure 3.29].
        visibility: Visibility = Visibility::Accumulate;
        /// Of "interleaved": Size of a splat in the mirror at distance 0; it falls linearly to 1 at `sscr.mirror_far`. Larger ones leave
        /// fewer holes and smear [Preiner 2010, section 3.6 and figure 3.27]; cost grows with the square.
        max_splat: f32 = 2.0, 1.0..=64.0, "pixels";
        /// Of "interleaved": Distance from the mirror from which on splats are 1 pixel [Preiner 2010, section 3.6].
        mirror_far: f32 = 1.0, 0.001..=1000.0, "x scene diagonal";
        /// Of "interleaved": Depth by which a point may lie behind the nearest of its mirror pixel and still be averaged with it
        /// [Preiner 2010, section 4.5.3]. Mirrors that shrink what they show need more, or show only what is nearest.
        depth_offset: f32 = 14.0, 0.0..=10000.0, "x spacing";
        /// Points ("guided": mirror points) nearer to the mirror than this are its own, and dropped: a few would hide all that the mirror shows
        /// (they cost 9 dB on the parabola).
        self_hit: f32 = 5.0, 0.0..=10000.0, "x spacing";
        /// How holes in the mirrors are closed.
        closing: Closing = Closing::PullPush;
        /// Halvings of the mirror's picture from which holes are filled. 4 close holes of up to 16 pixels, and fill too
        /// what reflects nothing [Preiner 2010, sections 3.6 and 4.6]; 0 leaves holes.
        pull_levels: u32 = 4, 0..=16, "levels";
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SettingsGroup;

    #[test]
    fn what_is_of_one_search_says_so() {
        let described = SscrSettings::describe();
        let of = described
            .iter()
            .filter(|d| d.doc.starts_with("Of \"interleaved\""));
        let keys: Vec<&str> = of.map(|d| d.key.as_str()).collect();
        assert_eq!(keys, OF_INTERLEAVED);
    }
}
