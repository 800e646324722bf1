//! Reads LAS 1.0 to 1.4 and LAZ, all point formats.

mod check;
mod columns;
mod extra;
mod unit;

use std::io::{BufReader, Seek};

use glam::DVec3;
use las::{Header, PointDataBuilder, Reader};

use self::columns::Columns;
use super::guard::require_memory;
use super::read::Source;
use super::{RawCloud, ReadOptions, UpAxis};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::text::short_name;

const BUFFER: usize = 1 << 20; // bytes

/// Points between two looks at the job.
const CHUNK: u64 = 1 << 16;

/// Reads the points of a LAS or LAZ file. See [`super::read_cloud`].
pub(super) fn read(mut source: Source<'_>, options: &ReadOptions, job: &Job) -> Result<RawCloud> {
    check::check(&mut source)?;
    source.file.rewind().map_err(|e| source.io_error(e))?;
    let file = source.file.try_clone().map_err(|e| source.io_error(e))?;
    let mut reader =
        Reader::new(BufReader::with_capacity(BUFFER, file)).map_err(|e| las_error(&source, e))?;
    let header = reader.header().clone();
    let scale = header.transforms();
    if [scale.x, scale.y, scale.z]
        .iter()
        .any(|t| !t.scale.is_finite() || t.scale == 0.0 || !t.offset.is_finite())
    {
        return Err(source
            .error("its header states a scale or offset that is no number; the file is damaged"));
    }
    let count = header.number_of_points();
    if count == 0 {
        return Err(source.error("it holds no points"));
    }

    let mut columns = Columns::new(&header, options);
    require_memory(
        "the point cloud",
        count.saturating_mul(columns.bytes_per_point()),
    )?;
    let mut points = PointDataBuilder::new().for_header(&header).build();
    let mut done = 0;
    while done < count {
        job.progress("reading", done, count)?;
        let read = reader
            .fill_points(CHUNK.min(count - done), &mut points)
            .map_err(|e| las_error(&source, e))?;
        if read == 0 {
            return Err(source.io_error(std::io::ErrorKind::UnexpectedEof.into()));
        }
        columns.push(&points);
        done += read;
    }
    job.progress("reading", count, count)?;

    let mut cloud = columns.into_cloud(options.colour_bits);
    cloud.scale = Some(DVec3::new(scale.x.scale, scale.y.scale, scale.z.scale).abs());
    cloud.up_axis = Some(UpAxis::Z);
    cloud.unit = unit::unit_of(&header);
    cloud.format = format_name(&header);
    Ok(cloud)
}

fn format_name(header: &Header) -> String {
    let format = header.point_format();
    let number = format
        .to_u8()
        .map_or(String::new(), |number| format!(", point format {number}"));
    let laz = if format.is_compressed { ", LAZ" } else { "" };
    format!("LAS {}{number}{laz}", header.version())
}

fn las_error(source: &Source<'_>, error: las::Error) -> Error {
    match error {
        las::Error::Io(error) => source.io_error(error),
        other => source.error(format!(
            "the LAS decoder does not understand it ({})",
            short_name(&other.to_string())
        )),
    }
}
