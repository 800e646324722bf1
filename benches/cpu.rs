//! What the CPU's stages cost: `cargo bench`. Compare by ratio within one run; docs/PERFORMANCE.md keeps the figures.

use std::sync::Arc;

use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::generate::{SceneName, generate};
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::gbuffer::SplatSettings;
use catoptric::gbuffer::splat::Splatter;
use catoptric::job::Job;
use catoptric::timing::Timings;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{DVec3, UVec2};

fn main() {
    divan::main();
}
