//! Pass `guided` on the device. Twin: `src/reflect/sscr/guided.rs`.
//!
//! Fields and charts are made on the processor: a picture's mirrors are read back for them, and their tables go to the
//! device.

use glam::{UVec2, Vec2, Vec3, Vec4};

use super::buffers::{Binding, Buffer, STORAGE};
use super::kernel::{Kernel, POINT_GROUP, Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::GUIDED;
use super::{Gpu, GpuGrid, GpuHits, GpuPoints};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::sscr::accumulate::LARGEST_REACH;
use crate::reflect::sscr::beam::Beam;
use crate::reflect::sscr::beam_tree::Kind;
use crate::reflect::sscr::charts::Seeds;
use crate::reflect::sscr::field::MirrorField;
use crate::reflect::sscr::guided::Guide;
use crate::reflect::sscr::prefix::{Budget, Prefix};
use crate::reflect::sscr::root_find::SearchCounts;
use crate::reflect::{Eye, Surface};
use crate::timing::Timings;

gpu_struct! {
    /// Where a picture's field lies.
    pub(super) struct FieldParams {
        /// Pixel (centres at + 0.5) of the place (0, 0).
        origin: Vec2,
        /// Of the field, pixels.
        size: UVec2,
    }
}

gpu_struct! {
    /// What one dispatch of `guided` works on.
    pub(super) struct GuidedParams {
        /// The mirrors.
        field: FieldParams,
        /// First of the order, of this dispatch.
        first: u32,
        /// One past its last.
        end: u32,
        /// Number of the band's first point in the cloud.
        band_start: u32,
        /// Points in the band.
        band_count: u32,
        /// Charts.
        chart_count: u32,
        /// Number of the dispatch: its counts have a place of their own.
        chunk: u32,
        /// Over the local spacing.
        self_hit: f32,
        /// Half width of a surfel's disc over its radius.
        splat_size: f32,
    }
}

gpu_struct! {
    /// A chart, or a part of its tree.
    pub(super) struct BeamNode {
        /// Of the ball.
        centre: Vec3,
        /// Of the ball.
        radius: f32,
        /// Of the cone, unit vector.
        axis: Vec3,
        /// Of the cone's half angle.
        cosine: f32,
        /// Of the cone's half angle.
        sine: f32,
        /// Squared distance up to which every point may be shown.
        near_squared: f32,
        /// 0 children, 1 a leaf, 2 a map.
        kind: u32,
        /// First child, or place of the map.
        first: u32,
        /// Children.
        count: u32,
        /// As it says.
        pad: u32,
        /// Where searches start in a leaf.
        start: Vec2,
    }
}

const CHILDREN: u32 = 0;
const LEAF: u32 = 1;
const MAP: u32 = 2;

/// Points of one dispatch: none runs much longer than 100 ms, also on trees; of fewer where there are many charts.
const CHUNK: u32 = 1 << 14;

/// Charts that halve the points of a dispatch.
const MANY_CHARTS: u32 = 512;

/// Counters of a dispatch: points with hits, hits, steps, and the area of splats.
const COUNTERS: usize = 4;

/// Pixels that a unit of the area counter stands for.
const AREA: f64 = 16.0;

/// Hits a point that the list has room for at first.
const EXPECTED_HITS: f64 = 2.0;

/// The guide of a picture, on the device.
struct Tables {
    params: GuidedParams,
    texels: Table,
    nodes: Table,
    seeds: Table,
}

/// Values that a kernel reads.
struct Table {
    buffer: Buffer,
    bytes: u64,
}

impl Table {
    fn binding(&self) -> Binding {
        self.buffer.first(self.bytes)
    }
}

/// What a batch of dispatches came to.
struct Batch {
    /// Hits in the list, those that it could not hold included.
    listed: u64,
    counts: SearchCounts,
    /// Most pixels of a splat, on average over a dispatch.
    area: f32,
}

fn node(beam: &Beam, kind: u32, first: usize, count: u32, start: Vec2) -> BeamNode {
    BeamNode {
        centre: beam.centre,
        radius: beam.radius,
        axis: beam.axis,
        cosine: beam.cosine,
        sine: beam.sine,
        near_squared: beam.near_squared,
        kind,
        first: first as u32,
        count,
        pad: 0,
        start,
    }
}

/// The charts as the device reads them: a node each, then the nodes of their trees; and the maps of those that have one.
fn tables(guide: &Guide<'_>) -> (Vec<BeamNode>, Vec<Vec4>) {
    let (mut nodes, mut trees, mut seeds) = (Vec::new(), Vec::new(), Vec::new());
    let charts = guide.charts.len();
    for chart in guide.charts {
        match &chart.seeds {
            Seeds::Map(map) => {
                nodes.push(node(&chart.beam, MAP, seeds.len(), 0, Vec2::ZERO));
                let [right, up, axis] = map.axes();
                seeds.extend([right.extend(map.scale()), up.extend(0.0), axis.extend(0.0)]);
                let pairs = map.places().chunks(2);
                seeds.extend(pairs.map(|p| match *p {
                    [a, b] => Vec4::new(a.x, a.y, b.x, b.y),
                    [a] => a.extend(0.0).extend(0.0),
                    _ => Vec4::ZERO,
                }));
            }
            Seeds::Tree(tree) => {
                // The root is the chart's own node; children lie behind all charts.
                let offset = (charts + trees.len()).saturating_sub(1);
                let of = |n: &crate::reflect::sscr::beam_tree::Node| match n.kind {
                    Kind::Children { first, count } => {
                        let first = offset + first as usize;
                        node(&n.beam, CHILDREN, first, count, Vec2::ZERO)
                    }
                    Kind::Leaf { start } => {
                        let start = tree.starts().get(start as usize);
                        let at = start.map_or(Vec2::ZERO, |s| s.at);
                        node(&n.beam, LEAF, 0, 0, at)
                    }
                };
                let mut all = tree.nodes().iter().map(of);
                nodes.extend(all.next());
                trees.extend(all);
            }
        }
    }
    nodes.extend(trees);
    (nodes, seeds)
}

impl Gpu {
    /// A copy of a grid in main memory.
    fn copy<T: bytemuck::Pod>(grid: &GpuGrid<T>) -> Result<Grid<T>> {
        Grid::from_vec(grid.size(), grid.download()?.into_owned())
            .ok_or_else(|| Error::Gpu("it returned a picture of another size".into()))
    }

    /// Adds times of stages on the processor.
    fn add_timings(&mut self, timings: &Timings) {
        for pass in &timings.passes {
            let wall = std::time::Duration::from_secs_f64(pass.wall_ms / 1e3);
            self.timings.add(&pass.name, wall);
        }
    }

    /// The field and classes of the mirrors, which are read back for them.
    pub(super) fn run_mirror_field(
        &mut self,
        surface: &Surface<Self>,
        curvature: &Grid<u8>,
        job: &Job,
    ) -> Result<(MirrorField, Grid<u8>)> {
        let surface = Surface {
            size: surface.size,
            point: Self::copy(&surface.point)?,
            normal: Self::copy(&surface.normal)?,
            eye: match &surface.eye {
                Eye::Point(eye) => Eye::Point(*eye),
                Eye::PerPixel(eyes) => Eye::PerPixel(Self::copy(eyes)?),
            },
        };
        let mut cpu = Cpu::default();
        let made = cpu.mirror_field(&surface, curvature, job);
        self.add_timings(cpu.timings());
        made
    }

    /// Values for a kernel to read; a kernel binds at least one.
    fn table<T: bytemuck::Pod>(&mut self, what: &str, values: &[T]) -> Result<Table> {
        let bytes = (size_of_val(values) as u64).max(size_of::<T>() as u64);
        let budget = self.device.limits.max_storage_buffer_binding_size;
        if bytes > budget {
            return Err(Error::Memory {
                what: format!("searching the mirrors ({what})"),
                needed: bytes,
                budget,
            });
        }
        let buffer = self.pool.take(what, bytes, STORAGE)?;
        buffer.upload(0, bytemuck::cast_slice(values))?;
        Ok(Table { buffer, bytes })
    }

    /// Pass `guided`.
    pub(super) fn run_guided(
        &mut self,
        points: &GpuPoints,
        guide: &Guide<'_>,
        prefix: &mut Prefix,
        budget: Budget,
        job: &Job,
    ) -> Result<(GpuHits, SearchCounts, usize)> {
        let mut hits = GpuHits::new(LARGEST_REACH);
        hits.area = 1.0;
        let (nodes, seeds) = tables(guide);
        let tables = Tables {
            params: GuidedParams {
                field: FieldParams {
                    origin: guide.field.pixel_of_place(Vec2::ZERO),
                    size: guide.field.size(),
                },
                chart_count: guide.charts.len() as u32,
                self_hit: guide.self_hit,
                splat_size: guide.splat_size,
                ..bytemuck::Zeroable::zeroed()
            },
            texels: self.table("the mirrors' field", guide.field.texels())?,
            nodes: self.table("the mirrors' beams", &nodes)?,
            seeds: self.table("the mirrors' directions", &seeds)?,
        };
        let places = &points.surfels.places;
        let mut ordering = Timings::default();
        let found = prefix.grow(places, budget, &mut ordering, |order, _| {
            self.search_part(points, &tables, order, &mut hits, job)
        });
        self.add_timings(&ordering);
        let (counts, searched) = found?;
        Ok((hits, counts, searched))
    }

    /// Searches for the points of one part, in as many batches as the list of hits asks for.
    fn search_part(
        &mut self,
        points: &GpuPoints,
        tables: &Tables,
        order: &[u32],
        hits: &mut GpuHits,
        job: &Job,
    ) -> Result<SearchCounts> {
        let kernel = self.kernels.get(&self.device, &GUIDED)?;
        let limits = self.device.limits.clone();
        let most = u64::from(GpuHits::band_limit(&limits));
        let (mut counts, mut rest) = (SearchCounts::default(), order);
        let listed_indices = (limits.max_storage_buffer_binding_size / 4) as usize;
        let (mut batch, mut expected) = (order.len().min(listed_indices), EXPECTED_HITS);
        while !rest.is_empty() && !tables.is_empty() {
            let now = &rest[..batch.clamp(1, rest.len())];
            let least = ((now.len() as f64 * expected) as u64 + u64::from(CHUNK)).min(most);
            let band = hits.band(&self.pool, &limits, least as u32, least)?;
            let (listed, room, list) = (band.count, u64::from(band.room()), band.whole());
            let done = self.search_batch(points, tables, now, &kernel, (list, listed), job)?;
            let more = done.listed - u64::from(listed);
            if more > room {
                // Searched again, with room for what there is, or for fewer points.
                expected = more as f64 / now.len() as f64 * 1.05;
                if more + u64::from(CHUNK) > most {
                    batch = now.len() / 2;
                }
                continue;
            }
            let band = hits.band(&self.pool, &limits, 0, least)?;
            band.count = done.listed as u32;
            hits.area = hits.area.max(done.area);
            counts += done.counts;
            rest = &rest[now.len()..];
        }
        if tables.is_empty() {
            counts.offered = order.len() as u64;
        }
        Ok(counts)
    }

    /// Searches for these points, chunk by chunk, and appends to a list that holds so many hits already.
    fn search_batch(
        &mut self,
        points: &GpuPoints,
        tables: &Tables,
        order: &[u32],
        kernel: &std::sync::Arc<Kernel>,
        (list, listed): (Binding, u32),
        job: &Job,
    ) -> Result<Batch> {
        let indices = self.table("the order of the points", order)?;
        let points_each = CHUNK / (1 + tables.params.chart_count / MANY_CHARTS);
        let points_each = points_each.max(POINT_GROUP);
        let chunks = order.len().div_ceil(points_each as usize) * points.bands.len();
        let mut values = vec![0u32; 1 + COUNTERS * chunks];
        values[0] = listed;
        let counters = self.table("counting hits", &values)?;
        let mut pass = Pass::new(GUIDED.name, &self.device, &self.pool, self.stamps.as_ref());
        let (mut chunk, mut band_start) = (0, 0);
        for band in &points.bands {
            for first in (0..order.len() as u32).step_by(points_each as usize) {
                let end = (first + points_each).min(order.len() as u32);
                let params = GuidedParams {
                    first,
                    end,
                    band_start,
                    band_count: band.count,
                    chunk,
                    ..tables.params
                };
                pass.compute(kernel, &params)
                    .read(indices.binding())
                    .read(band.places())
                    .read(band.finishes())
                    .read(tables.texels.binding())
                    .read(tables.nodes.binding())
                    .read(tables.seeds.binding())
                    .write(list.clone())
                    .write(counters.binding())
                    .dispatch(Threads::Points(end - first))?;
                chunk += 1;
            }
            band_start += band.count;
        }
        pass.finish(&mut self.timings, job)?;
        let values = counters.buffer.download::<u32>(values.len() as u64)?;
        let mut batch = Batch {
            listed: u64::from(values.first().copied().unwrap_or(listed)),
            counts: SearchCounts {
                offered: order.len() as u64,
                ..SearchCounts::default()
            },
            area: 1.0,
        };
        for chunk in values.get(1..).unwrap_or_default().chunks_exact(COUNTERS) {
            batch.counts.hit += u64::from(chunk[0]);
            batch.counts.hits += u64::from(chunk[1]);
            batch.counts.steps += u64::from(chunk[2]);
            let area = f64::from(chunk[3]) * AREA / f64::from(chunk[1].max(1));
            batch.area = batch.area.max(area as f32);
        }
        Ok(batch)
    }
}

impl Tables {
    /// Whether there is no mirror to search in.
    fn is_empty(&self) -> bool {
        self.params.chart_count == 0
    }
}
