//! What searches come to.

use super::scalar::Scalar;

/// Where a point is seen in the mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root<R: Scalar = f32> {
    /// Pixels (centres at + 0.5).
    pub pixel: R::Vec2,
    /// Distance from the mirror's point, in the cloud's unit.
    pub distance: R,
    /// Steps taken.
    pub steps: u32,
    /// Length of the error at the pixel.
    pub residual: R,
}

/// How the search for a point ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<R: Scalar = f32> {
    /// The mirror shows it.
    Found(Root<R>),
    /// Not found.
    Lost(End<R>),
}

/// Where a search ended without finding its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End<R: Scalar = f32> {
    /// Steps taken.
    pub steps: u32,
    /// The last place in the region, pixels; `None` where no place to start from was found.
    pub pixel: Option<R::Vec2>,
}

impl<R: Scalar> Default for End<R> {
    fn default() -> Self {
        Self {
            steps: 0,
            pixel: None,
        }
    }
}

impl<R: Scalar> Outcome<R> {
    /// Where the search ended, pixels; `None` where it did not begin.
    pub fn pixel(&self) -> Option<R::Vec2> {
        match self {
            Self::Found(root) => Some(root.pixel),
            Self::Lost(end) => end.pixel,
        }
    }
}

/// What a search came to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SearchCounts {
    /// Points that were searched for.
    pub offered: u64,
    /// Points that were found.
    pub hit: u64,
    /// Places in the mirrors where they were found.
    pub hits: u64,
    /// Steps in all.
    pub steps: u64,
}

impl std::ops::AddAssign for SearchCounts {
    fn add_assign(&mut self, more: Self) {
        self.offered += more.offered;
        self.hit += more.hit;
        self.hits += more.hits;
        self.steps += more.steps;
    }
}
