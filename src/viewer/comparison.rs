//! Two frames of one view: side by side, their difference, and what mirrors show in each.

use catoptric::Result;
use catoptric::measure::quality::{MirrorPicture, Reference};
use eframe::egui::{Color32, ColorImage};
use glam::DVec3;

use super::buffers::Buffer;
use super::letters::{Layer, Shown};

/// How much brighter differences are shown than they are.
const DIFFERENCE: u8 = 4;

/// What a frame is beside another of the same view.
pub(super) struct Comparison {
    /// The numbers of both frames.
    pub(super) numbers: [u64; 2],
    /// The other frame.
    pub(super) with: Layer,
    /// Where they differ: grey, four times as bright.
    pub(super) difference: ColorImage,
    /// Names and values, for people, of what mirrors show; the other frame is the reference.
    pub(super) lines: Vec<(&'static str, String)>,
}

impl Comparison {
    /// Compares `frame` with another.
    ///
    /// # Errors
    /// Where the two differ in size.
    pub(super) fn new(frame: &Shown, with: &Shown, buffer: Buffer, origin: DVec3) -> Result<Self> {
        let layers = [frame, with].map(|shown| Layer::new(shown, buffer));
        let pixels = layers[0].image.pixels.iter().zip(&layers[1].image.pixels);
        let difference = ColorImage::new(
            layers[0].image.size,
            pixels.map(|(a, b)| difference(*a, *b)).collect(),
        );
        let mut lines = vec![("time", format!("{:.0} ms, {:.0} ms", frame.ms, with.ms))];
        let mirrors = [frame, with].map(|shown| shown.products.mirror.as_ref());
        if let [Some(mirror), Some(reference)] = mirrors {
            let reference = Reference::of(reference, origin);
            let picture = MirrorPicture::new(mirror, origin);
            let quality = reference.quality(&picture)?;
            let psnr = reference.albedo_psnr(&picture)?;
            lines.push(("albedo", format!("{psnr:.1} dB")));
            lines.push(("recall", format!("{:.1} %", quality.recall * 100.0)));
            lines.push(("coverage", format!("{:.1} %", quality.coverage * 100.0)));
        }
        let [_, other] = layers;
        Ok(Self {
            numbers: [frame.request.number, with.request.number],
            with: other,
            difference,
            lines,
        })
    }
}

fn difference(a: Color32, b: Color32) -> Color32 {
    let channels = a.to_array().into_iter().zip(b.to_array());
    let largest = channels.map(|(a, b)| a.abs_diff(b)).max();
    Color32::from_gray(largest.unwrap_or(0).saturating_mul(DIFFERENCE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_black_where_there_is_none() {
        let (a, b) = (
            Color32::from_rgb(10, 200, 30),
            Color32::from_rgb(10, 205, 30),
        );
        assert_eq!(difference(a, a), Color32::BLACK);
        assert_eq!(difference(a, b), Color32::from_gray(20));
        assert_eq!(difference(Color32::BLACK, Color32::WHITE), Color32::WHITE);
    }
}
