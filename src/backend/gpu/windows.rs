//! Pictures in row bands: what one dispatch works on, within the size of a binding and the time of a submission.

use std::ops::Range;

use glam::UVec2;

use super::kernel::Threads;

/// Steps of a kernel's inner loop that one submission may take: about 100 ms on a slow graphics card.
pub(super) const STEPS: u64 = 1 << 28;

/// Bindings start at a multiple of these many pixels, so that even one byte a pixel is aligned.
const PIXEL_ALIGNMENT: u32 = 256;

/// Rows that a dispatch works on, and the pixels that its bindings hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Window {
    /// Rows to work on.
    pub(super) rows: Range<u32>,
    /// Pixels in reach, by number, row by row: the rows and their halo.
    pub(super) pixels: Range<u32>,
}

impl Window {
    /// A thread per pixel of the rows.
    pub(super) fn threads(&self, size: UVec2) -> Threads {
        Threads::Pixels(UVec2::new(size.x, self.rows.end - self.rows.start))
    }
}

/// What a kernel needs per pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Need {
    /// Rows above and below that it also reads.
    pub(super) halo: u32,
    /// Bytes per pixel of its largest binding.
    pub(super) bytes: u64,
    /// Steps of its inner loop per pixel.
    pub(super) steps: u64,
}

/// The pixels of so many rows, by number, from where a binding may start.
pub(super) fn rows_of(size: UVec2, rows: &Range<u32>) -> Range<u32> {
    let start = rows.start * size.x;
    start / PIXEL_ALIGNMENT * PIXEL_ALIGNMENT..rows.end * size.x
}

/// Cuts a picture into windows.
pub(super) fn windows(size: UVec2, need: Need, limits: &wgpu::Limits) -> Vec<Window> {
    let width = u64::from(size.x.max(1));
    let held = (limits.max_storage_buffer_binding_size / need.bytes)
        .saturating_sub(u64::from(PIXEL_ALIGNMENT));
    let by_binding = (held / width).saturating_sub(2 * u64::from(need.halo));
    let by_steps = STEPS / need.steps.max(1) / width;
    let rows = by_binding.min(by_steps).clamp(1, u64::from(size.y.max(1))) as u32;
    (0..size.y)
        .step_by(rows as usize)
        .map(|first| {
            let end = (first + rows).min(size.y);
            let start = first.saturating_sub(need.halo) * size.x;
            let start = start / PIXEL_ALIGNMENT * PIXEL_ALIGNMENT;
            Window {
                rows: first..end,
                pixels: start..(end + need.halo).min(size.y) * size.x,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_every_row_once_and_fit_into_a_binding() {
        let limits = wgpu::Limits::default();
        let size = UVec2::new(20_000, 9_000);
        let need = Need {
            halo: 20,
            bytes: 16,
            steps: 10,
        };
        let all = windows(size, need, &limits);
        assert!(all.len() > 1, "a picture of 2.7 GiB needs several windows");
        let mut next = 0;
        for w in &all {
            assert_eq!(w.rows.start, next, "no row is left out");
            next = w.rows.end;
            let bytes = u64::from(w.pixels.end - w.pixels.start) * need.bytes;
            assert!(
                bytes <= limits.max_storage_buffer_binding_size,
                "{w:?} takes {bytes} bytes"
            );
            assert!(
                w.pixels.start <= w.rows.start.saturating_sub(20) * size.x,
                "{w:?} lacks rows above"
            );
            assert!(
                w.pixels.end >= (w.rows.end + 20).min(size.y) * size.x,
                "{w:?} lacks rows below"
            );
        }
        assert_eq!(next, size.y, "the last row is in");
    }
}
