//! What can be set about the search.

use crate::{setting_choice, settings_group};

setting_choice! {
    /// How the pixel that shows a point is searched.
    pub enum Search {
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
        /// All that lie within `sscr.depth_offset` behind the nearest, averaged.
        Accumulate = "accumulate",
        /// The nearest alone.
        Nearest = "nearest",
    }
}

impl SscrSettings {
    /// Half the side of a splat at a distance from the mirror, pixels: it falls linearly to half a pixel at
    /// `sscr.mirror_far`. `diagonal` is that of the scene's box.
    pub fn splat_reach(&self, distance: f32, diagonal: f32) -> f32 {
        let far = (self.mirror_far * diagonal).max(f32::MIN_POSITIVE);
        let nearness = (1.0 - distance / far).max(0.0);
        0.5 * (1.0 + (self.max_splat - 1.0) * nearness)
    }
}

settings_group! {
    /// How mirrors are searched for what they show.
    pub struct SscrSettings in "sscr" {
        /// How the pixel that shows a point is searched.
        search: Search = Search::Interleaved;
        /// How many more random pixels of the region's box are tried for each of the two places where a search starts, if
        /// the first lies outside of the region. The first two gain most [Preiner 2010, figure 5.4]: the sphere's hit rate
        /// is 24, 34, 36 and 37 % for 0, 1, 2 and 4.
        seed_attempts: u32 = 4, 0..=64, "attempts";
        /// How often a step that leaves the region is halved before the point is given up. The first two gain most
        /// [Preiner 2010, figure 5.5]: the torus's hit rate is 6, 10, 12 and 13 % for 0, 1, 2 and 4.
        step_attempts: u32 = 2, 0..=64, "attempts";
        /// Steps of a search at most. 10 lose points, more than 20 find hardly any more; cost grows with the points that no
        /// mirror shows.
        max_steps: u32 = 24, 1..=1000, "steps";
        /// First step, along x and y, as a fraction of the region's box [Preiner 2010, section 3.4 and figure 5.2].
        /// Large ones leave narrow regions, small ones take longer: half the speed at 0.02.
        initial_step: f32 = 0.2, 0.001..=0.5, "x box";
        /// Distance of the last two steps below which the point between them is taken. More finds more points, less
        /// exactly: 2 to 4 for the thesis's mirrors [Preiner 2010, figures 3.17 and 5.2].
        threshold: f32 = 2.0, 0.1..=64.0, "pixels";
        /// How the points are shared out among the regions [Preiner 2010, section 3.6]. "uniform" starves large regions
        /// where there are many small ones.
        distribution: Distribution = Distribution::Weighted;
        /// How often all points are shared out, each time to other regions [Preiner 2010, section 5.6]. Mirrors of many
        /// regions get denser; cost grows in proportion.
        passes: u32 = 1, 1..=16, "passes";
        /// Which of the points found in a mirror pixel it shows [Preiner 2010, section 3.7 and figure 3.29].
        visibility: Visibility = Visibility::Accumulate;
        /// Size of a splat in the mirror at distance 0; it falls linearly to 1 at `sscr.mirror_far`. Larger ones leave
        /// fewer holes and smear [Preiner 2010, section 3.6 and figure 3.27]; cost grows with the square.
        max_splat: f32 = 2.0, 1.0..=64.0, "pixels";
        /// Distance from the mirror from which on splats are 1 pixel [Preiner 2010, section 3.6].
        mirror_far: f32 = 1.0, 0.001..=1000.0, "x scene diagonal";
        /// Depth by which a point may lie behind the nearest of its mirror pixel and still be averaged with it
        /// [Preiner 2010, section 4.5.3]. Mirrors that shrink what they show need more, or show only what is nearest.
        depth_offset: f32 = 14.0, 0.0..=10000.0, "x spacing";
        /// Points nearer to the mirror than this are its own, and dropped: a few would hide all that the mirror shows
        /// (they cost 9 dB on the parabola).
        self_hit: f32 = 5.0, 0.0..=10000.0, "x spacing";
        /// Halvings of the mirror's picture from which holes are filled. 4 close holes of up to 16 pixels, and fill too
        /// what reflects nothing [Preiner 2010, sections 3.6 and 4.6]; 0 leaves holes.
        pull_levels: u32 = 4, 0..=16, "levels";
    }
}
