//! Whether a LAS or LAZ file can hold what its header promises. The decoders allocate by these numbers, so they are
//! checked first.

use std::io::{BufReader, Read, Seek, SeekFrom};

use las::point::Format;
use las::raw::{Header, Vlr};

use super::las_error;
use crate::cloud::read::Source;
use crate::error::{Error, Result};

/// Bytes of a variable length record before its data.
const VLR_HEADER: u64 = 54;

/// Bytes of an extended variable length record before its data, and where its length stands.
const EVLR_HEADER: u64 = 60;
const EVLR_LENGTH_AT: u64 = 20;

/// Where a compressed file's point data say where their chunk table is.
const TABLE_OFFSET_SIZE: u64 = 8;

/// Checks the header of a LAS or LAZ file against its length.
pub(super) fn check(source: &mut Source<'_>) -> Result<()> {
    let mut file = BufReader::new(&source.file);
    let header = Header::read_from(&mut file).map_err(|e| las_error(source, e))?;
    let version = header.version;
    if version.major != 1 || version.minor > 4 {
        return Err(source.error(format!("it is LAS {version}; 1.0 to 1.4 are read")));
    }
    let offset = u64::from(header.offset_to_point_data);
    let before_points = offset.saturating_sub(u64::from(header.header_size));
    if offset > source.length
        || u64::from(header.number_of_variable_length_records) * VLR_HEADER > before_points
    {
        return Err(damaged(source, "where its points begin"));
    }
    if let Some(evlr) = header.evlr {
        check_evlr(source, &mut file, evlr.start_of_first_evlr)?;
    }

    let count = match (header.number_of_point_records, header.large_file) {
        (0, Some(large)) => large.number_of_point_records,
        (count, _) => u64::from(count),
    };
    let record = u64::from(header.point_data_record_length);
    let format = Format::new(header.point_data_record_format).map_err(|e| las_error(source, e))?;
    if record < u64::from(format.len()) {
        return Err(damaged(source, "how long a point is"));
    }
    if !format.is_compressed {
        let room = (source.length - offset) / record;
        return if count > room {
            Err(too_many(source, count, room))
        } else {
            Ok(())
        };
    }
    let laszip = find_laszip(source, &mut file, &header)?;
    laszip.check(source, &mut file, offset, record, count)
}

fn damaged(source: &Source<'_>, what: &str) -> Error {
    source.error(format!(
        "its header does not rightly say {what}; the file is damaged or was cut off"
    ))
}

fn too_many(source: &Source<'_>, count: u64, room: u64) -> Error {
    source.error(format!(
        "its header promises {count} points, but the file is too short for more than {room}; it was cut off, so get a \
         whole copy"
    ))
}

fn check_evlr(source: &Source<'_>, file: &mut (impl Read + Seek), start: u64) -> Result<()> {
    let room = source
        .length
        .checked_sub(start)
        .and_then(|left| left.checked_sub(EVLR_HEADER));
    let room = room.ok_or_else(|| damaged(source, "where its extended records are"))?;
    let length = read_at::<8>(source, file, start + EVLR_LENGTH_AT).map(u64::from_le_bytes)?;
    if length > room {
        Err(damaged(source, "how long its extended records are"))
    } else {
        Ok(())
    }
}

fn read_at<const N: usize>(
    source: &Source<'_>,
    file: &mut (impl Read + Seek),
    at: u64,
) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    let read = file
        .seek(SeekFrom::Start(at))
        .and_then(|_| file.read_exact(&mut bytes));
    read.map_err(|e| source.io_error(e))?;
    Ok(bytes)
}

/// The compressor that makes no chunks.
const ONE_PIECE: u16 = 1;

/// What the `laszip encoded` record says of the compression.
struct Laszip {
    /// Points a chunk; `None` where each chunk has its own number.
    chunk_size: Option<u32>,
    /// Layers of a chunk, each of which is allocated by its stated size; 0 where there are none.
    layers: u64,
    /// Whether there are no chunks, and so no table of them.
    is_one_piece: bool,
    /// Bytes of an uncompressed point.
    record: u64,
}

fn find_laszip(
    source: &Source<'_>,
    file: &mut (impl Read + Seek),
    header: &Header,
) -> Result<Laszip> {
    file.seek(SeekFrom::Start(u64::from(header.header_size)))
        .map_err(|e| source.io_error(e))?;
    for _ in 0..header.number_of_variable_length_records {
        let vlr = Vlr::read_from(&mut *file, false).map_err(|e| las_error(source, e))?;
        if vlr.user_id.starts_with(b"laszip encoded") && vlr.record_id == 22_204 {
            return Laszip::parse(&vlr.data).ok_or_else(|| damaged(source, "how it is compressed"));
        }
    }
    Err(damaged(source, "how it is compressed"))
}

/// Where the table of chunks is, as the decoder finds it: the points begin with its place, or, where the writer could
/// not go back, the file ends with it.
fn table_position(source: &Source<'_>, file: &mut (impl Read + Seek), offset: u64) -> Result<u64> {
    let last = source.length.saturating_sub(TABLE_OFFSET_SIZE);
    for at in [offset, last] {
        let table = i64::from_le_bytes(read_at(source, file, at)?);
        if let Ok(table) = u64::try_from(table)
            && table > offset
        {
            let sound = table >= offset + TABLE_OFFSET_SIZE && table <= last;
            return if sound {
                Ok(table)
            } else {
                Err(damaged(source, "where its chunks are"))
            };
        }
    }
    Err(damaged(source, "where its chunks are"))
}

impl Laszip {
    fn parse(data: &[u8]) -> Option<Self> {
        let u16_at = |at: usize| Some(u16::from_le_bytes(data.get(at..at + 2)?.try_into().ok()?));
        let chunk_size = u32::from_le_bytes(data.get(12..16)?.try_into().ok()?);
        let (mut record, mut layers) = (0, 0);
        for item in 0..usize::from(u16_at(32)?) {
            let at = 34 + item * 6;
            let (kind, size, version) = (u16_at(at)?, u64::from(u16_at(at + 2)?), u16_at(at + 4)?);
            record += size;

            // Only versions 3 and 4 are layered: point, RGB, RGB and NIR, wave packet, extra bytes.
            layers += match (version, kind) {
                (3 | 4, 10) => 9,
                (3 | 4, 11 | 13) => 1,
                (3 | 4, 12) => 2,
                (3 | 4, 14) => size,
                _ => 0,
            };
        }
        let is_one_piece = u16_at(0)? == ONE_PIECE;
        let chunk_size = (chunk_size != 0 && chunk_size != u32::MAX).then_some(chunk_size);
        let sound = record > 0 && !(is_one_piece && layers > 0);
        sound.then_some(Self {
            chunk_size,
            layers,
            is_one_piece,
            record,
        })
    }

    fn check(
        &self,
        source: &Source<'_>,
        file: &mut (impl Read + Seek),
        offset: u64,
        record: u64,
        count: u64,
    ) -> Result<()> {
        if self.record != record {
            return Err(damaged(source, "how long a point is"));
        }
        if self.is_one_piece {
            return Ok(());
        }
        let data = offset + TABLE_OFFSET_SIZE;
        let table = table_position(source, file, offset)?;

        // Every chunk begins with a whole point.
        let [_, _, _, _, chunks @ ..] = read_at::<8>(source, file, table)?;
        let chunks = u64::from(u32::from_le_bytes(chunks));
        if chunks > table.saturating_sub(data) / record {
            return Err(damaged(source, "how many chunks it has"));
        }
        let room = match self.chunk_size {
            Some(size) => chunks * u64::from(size),
            None => chunks.saturating_mul(u64::from(u32::MAX)),
        };
        if count > room {
            return Err(too_many(source, count, room));
        }
        if self.layers > 0 {
            self.check_layers(source, file, data..table, count)
        } else {
            Ok(())
        }
    }

    /// Walks from chunk to chunk as far as `count` points reach: no layer may be longer than what is left.
    fn check_layers(
        &self,
        source: &Source<'_>,
        file: &mut (impl Read + Seek),
        data: std::ops::Range<u64>,
        count: u64,
    ) -> Result<()> {
        let (mut at, mut points) = (data.start, 0_u64);
        while points < count {
            // A chunk: its first point, the number of points, the layers' sizes, the layers.
            let sizes_at = at + self.record + 4;
            let layers_at = sizes_at + 4 * self.layers;
            if layers_at > data.end {
                return Err(too_many(source, count, points));
            }
            let in_chunk = u64::from(u32::from_le_bytes(read_at(source, file, sizes_at - 4)?));
            let mut sizes = vec![0; (4 * self.layers) as usize];
            file.read_exact(&mut sizes)
                .map_err(|e| source.io_error(e))?;
            let sizes = sizes
                .as_chunks::<4>()
                .0
                .iter()
                .map(|size| u64::from(u32::from_le_bytes(*size)));
            at = layers_at + sizes.sum::<u64>();
            if at > data.end {
                return Err(source.error(
                    "a chunk of its points is longer than the file; it was cut off or is damaged",
                ));
            }
            points += self.chunk_size.map_or(in_chunk, u64::from);
        }
        Ok(())
    }
}
