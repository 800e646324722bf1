//! Reads PLY: ascii and binary, either byte order, any scalar types; lists and other elements are passed over.

pub(super) mod body;
mod columns;
pub(super) mod header;

use std::io::{BufReader, Seek, SeekFrom};

use ply_rs::ply::Encoding;

use self::body::Body;
use self::columns::{Columns, Layout};
use self::header::Header;
use super::guard::require_memory;
use super::read::Source;
use super::{RawCloud, ReadOptions};
use crate::error::Result;
use crate::job::Job;

const BUFFER: usize = 1 << 20; // bytes

/// Reads the points of a PLY file. See [`super::read_cloud`].
pub(super) fn read(mut source: Source<'_>, options: &ReadOptions, job: &Job) -> Result<RawCloud> {
    let header = Header::read(&mut source)?;
    header.check_counts(&source, header.points_index() + 1)?;
    let layout = Layout::new(&source, header.points(), options)?;
    let count = header.points().def.count;
    require_memory("the point cloud", count as u64 * layout.bytes_per_point())?;

    // Elements before the points have to be passed over; what follows them is not read.
    source
        .file
        .seek(SeekFrom::Start(header.length))
        .map_err(|e| source.io_error(e))?;
    let file = BufReader::with_capacity(BUFFER, &source.file);
    let mut body = Body::new(file, &header, &source);
    let mut columns = Columns::with_capacity(&layout, count);
    for element in header.elements().iter().take(header.points_index()) {
        body.read(element, job, |_| Ok(()))?;
    }
    body.read(&layout.element, job, |record| {
        columns.push(&record.row);
        Ok(())
    })?;
    if header.points_are_last() {
        body.finish(header.points())?;
    }

    let mut cloud = columns.into_cloud(&layout, options.colour_bits);
    cloud.up_axis = header.up_axis();
    cloud.column_names = header.points().names.clone();
    cloud.format = match header.encoding {
        Encoding::Ascii => "PLY, ascii",
        Encoding::BinaryLittleEndian => "PLY, binary little endian",
        Encoding::BinaryBigEndian => "PLY, binary big endian",
    }
    .to_owned();
    Ok(cloud)
}
