//! Passes `depth`, `visibility`, `average` and `light_depth` on the device. Twins: `src/gbuffer/{depth,visibility,average}.rs`.

use bytemuck::Zeroable;
use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::{Binding, Buffer, GpuGrid, GpuPoints, STORAGE};
use super::kernel::{Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{AVERAGE, CLEAR, DEPTH, LIGHT_CLOSE, LIGHT_DEPTH, VISIBILITY};
use super::windows::{Need, Window, windows};
use crate::backend::LightMap;
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::disc::MIN_HALF_WIDTH;
use crate::gbuffer::splat::Accumulated;
use crate::gbuffer::visibility::Sums;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::grid::Grid;
use crate::job::Job;

/// Surfels of one submission: none runs much longer than 100 ms, also where splats are large.
pub(super) const CHUNK: u32 = 1 << 18;

gpu_layout!(Pinhole {
    eye,
    focal,
    right,
    near,
    up,
    far,
    forward,
    inverse_focal,
    centre,
    size
});

gpu_struct! {
    /// What one dispatch of `light_close` works on.
    pub(super) struct LightCloseParams {
        /// Of the map, texels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first texel, row by row.
        first_pixel: u32,
        pad: u32,
    }
}

gpu_struct! {
    /// What one dispatch of a splatting pass works on.
    pub(super) struct SplatParams {
        /// How points are projected.
        pinhole: Pinhole,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// First surfel of the band.
        first_point: u32,
        /// One past the last surfel of the band.
        end_point: u32,
        /// Half width of a splat over the surfel's radius.
        size: f32,
        /// Over the surfel's radius.
        depth_tolerance: f32,
        /// Half width below which a disc could slip between pixel centres, pixels.
        min_half_width: f32,
    }
}

gpu_struct! {
    /// What one dispatch of `clear` works on.
    pub(super) struct ClearParams {
        /// Threads per row.
        width: u32,
        /// Values in all.
        pixels: u32,
    }
}

/// What the first two passes leave of a window.
struct WindowSums {
    keys: Buffer,
    counts: Buffer,
    sums: Buffer,
    pixels: u64,
}

impl WindowSums {
    fn keys(&self) -> Binding {
        self.keys.first(self.pixels * 4)
    }

    fn counts(&self) -> Binding {
        self.counts.first(self.pixels * 4)
    }

    fn sums(&self) -> Binding {
        self.sums.first(self.pixels * size_of::<Sums>() as u64)
    }
}

/// Pixels of the sums are the dearest; whatever is splatted is cut into windows by them.
const SUMS_NEED: Need = Need {
    halo: 0,
    bytes: size_of::<Sums>() as u64,
    steps: 1,
};

fn window_params(pinhole: &Pinhole, settings: &SplatSettings, window: &Window) -> SplatParams {
    SplatParams {
        pinhole: *pinhole,
        rows: UVec2::new(window.rows.start, window.rows.end),
        first_pixel: window.pixels.start,
        size: settings.size,
        depth_tolerance: settings.depth_tolerance,
        min_half_width: MIN_HALF_WIDTH,
        ..SplatParams::zeroed()
    }
}

impl Gpu {
    /// Passes `depth`, `visibility` and `average`.
    pub(super) fn run_splat(
        &mut self,
        points: &GpuPoints,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<GBuffer<Self>> {
        let grid = || GpuGrid::<Vec4>::new(&self.pool, pinhole.size);
        let (surface, albedo, material) = (grid()?, grid()?, grid()?);
        for window in windows(pinhole.size, SUMS_NEED, &self.device.limits) {
            let params = window_params(pinhole, settings, &window);
            let sums = self.accumulate_window(points, &params, &window, job)?;
            let kernel = self.kernels.get(&self.device, &AVERAGE)?;
            let mut pass = Pass::new("average", &self.device, &self.pool, self.stamps.as_ref());
            pass.compute(&kernel, &params)
                .read(sums.keys())
                .read(sums.sums())
                .write(surface.part(&window.pixels))
                .write(albedo.part(&window.pixels))
                .write(material.part(&window.pixels))
                .dispatch(window.threads(pinhole.size))?;
            pass.finish(&mut self.timings, job)?;
        }
        Ok(GBuffer {
            pinhole: *pinhole,
            surface,
            albedo,
            material,
        })
    }

    /// What passes `depth` and `visibility` leave, for comparing backends.
    ///
    /// # Errors
    /// As every stage.
    pub fn sums(
        &mut self,
        points: &GpuPoints,
        pinhole: &Pinhole,
        settings: &SplatSettings,
    ) -> Result<Accumulated> {
        let (mut keys, mut counts, mut sums) = (Vec::new(), Vec::new(), Vec::new());
        for window in windows(pinhole.size, SUMS_NEED, &self.device.limits) {
            let params = window_params(pinhole, settings, &window);
            let left = self.accumulate_window(points, &params, &window, &Job::default())?;
            // Windows overlap by what aligns their start.
            let skip = (window.rows.start * pinhole.size.x - window.pixels.start) as usize;
            keys.extend(
                left.keys
                    .download::<u32>(left.pixels)?
                    .into_iter()
                    .skip(skip),
            );
            counts.extend(
                left.counts
                    .download::<u32>(left.pixels)?
                    .into_iter()
                    .skip(skip),
            );
            sums.extend(
                left.sums
                    .download::<Sums>(left.pixels)?
                    .into_iter()
                    .skip(skip),
            );
        }
        let whole = |what: &str| crate::Error::Gpu(format!("{what} are not as many as pixels"));
        Ok(Accumulated {
            keys: Grid::from_vec(pinhole.size, keys).ok_or_else(|| whole("depth keys"))?,
            counts: Grid::from_vec(pinhole.size, counts).ok_or_else(|| whole("counts"))?,
            sums: Grid::from_vec(pinhole.size, sums).ok_or_else(|| whole("sums"))?,
        })
    }

    /// Passes `depth` and `visibility` of one window.
    fn accumulate_window(
        &mut self,
        points: &GpuPoints,
        params: &SplatParams,
        window: &Window,
        job: &Job,
    ) -> Result<WindowSums> {
        let pixels = u64::from(window.pixels.end - window.pixels.start);
        let take = |bytes: u64| self.pool.take("splatting", pixels * bytes, STORAGE);
        let left = WindowSums {
            keys: take(4)?,
            counts: take(4)?,
            sums: take(size_of::<Sums>() as u64)?,
            pixels,
        };

        let clear = self.kernels.get(&self.device, &CLEAR)?;
        let depth = self.kernels.get(&self.device, &DEPTH)?;
        let mut pass = Pass::new("depth", &self.device, &self.pool, self.stamps.as_ref());
        let width = params.pinhole.size.x;
        let clear_params = ClearParams {
            width,
            pixels: pixels as u32,
        };
        pass.compute(&clear, &clear_params)
            .write(left.keys())
            .dispatch(clear_threads(width, pixels))?;
        pass.zero(left.counts());
        for_chunks(points, params, |params, places, finishes, threads| {
            pass.compute(&depth, params)
                .read(places)
                .read(finishes)
                .write(left.keys())
                .write(left.counts())
                .dispatch(threads)
        })?;
        pass.finish(&mut self.timings, job)?;

        let visibility = self.kernels.get(&self.device, &VISIBILITY)?;
        let mut pass = Pass::new("visibility", &self.device, &self.pool, self.stamps.as_ref());
        pass.zero(left.sums());
        for_chunks(points, params, |params, places, finishes, threads| {
            pass.compute(&visibility, params)
                .read(places)
                .read(finishes)
                .read(left.keys())
                .read(left.counts())
                .write(left.sums())
                .dispatch(threads)
        })?;
        pass.finish(&mut self.timings, job)?;
        Ok(left)
    }

    /// Pass `light_depth`.
    pub(super) fn run_light_map(
        &mut self,
        points: &GpuPoints,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<LightMap<Self>> {
        let keys = GpuGrid::<u32>::new(&self.pool, pinhole.size)?;
        let clear = self.kernels.get(&self.device, &CLEAR)?;
        let depth = self.kernels.get(&self.device, &LIGHT_DEPTH)?;
        let mut pass = Pass::new(
            LIGHT_DEPTH.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        let all = windows(
            pinhole.size,
            Need {
                halo: 0,
                bytes: 4,
                steps: 1,
            },
            &self.device.limits,
        );
        // Windows overlap by what aligns their start: all are cleared before the first is drawn.
        for window in &all {
            let pixels = window.pixels.end - window.pixels.start;
            pass.compute(
                &clear,
                &ClearParams {
                    width: pinhole.size.x,
                    pixels,
                },
            )
            .write(keys.part(&window.pixels))
            .dispatch(clear_threads(pinhole.size.x, u64::from(pixels)))?;
        }
        for window in &all {
            let params = window_params(pinhole, settings, window);
            for_chunks(points, &params, |params, places, finishes, threads| {
                pass.compute(&depth, params)
                    .read(places)
                    .read(finishes)
                    .write(keys.part(&window.pixels))
                    .dispatch(threads)
            })?;
        }
        pass.finish(&mut self.timings, job)?;
        let keys = self.close_light_map(&keys, pinhole.size, job)?;
        Ok(LightMap {
            pinhole: *pinhole,
            keys,
        })
    }

    /// Pass `light_close`.
    fn close_light_map(
        &mut self,
        keys: &GpuGrid<u32>,
        size: UVec2,
        job: &Job,
    ) -> Result<GpuGrid<u32>> {
        let kernel = self.kernels.get(&self.device, &LIGHT_CLOSE)?;
        let closed = GpuGrid::<u32>::new(&self.pool, size)?;
        let mut pass = Pass::new(
            LIGHT_CLOSE.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        let need = Need {
            halo: 1,
            bytes: 4,
            steps: 9,
        };
        for window in windows(size, need, &self.device.limits) {
            let params = LightCloseParams {
                size,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                pad: 0,
            };
            pass.compute(&kernel, &params)
                .read(keys.part(&window.pixels))
                .write(closed.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(closed)
    }
}

fn clear_threads(width: u32, pixels: u64) -> Threads {
    Threads::Pixels(UVec2::new(width, pixels.div_ceil(u64::from(width)) as u32))
}

/// Calls `dispatch` for every chunk of the points.
fn for_chunks(
    points: &GpuPoints,
    params: &SplatParams,
    mut dispatch: impl FnMut(&SplatParams, Binding, Binding, Threads) -> Result<()>,
) -> Result<()> {
    for band in &points.bands {
        for first_point in (0..band.count).step_by(CHUNK as usize) {
            let end_point = (first_point + CHUNK).min(band.count);
            let params = SplatParams {
                first_point,
                end_point,
                ..*params
            };
            dispatch(
                &params,
                band.places(),
                band.finishes(),
                Threads::Points(end_point - first_point),
            )?;
        }
    }
    Ok(())
}
