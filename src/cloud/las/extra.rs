//! Columns that a LAS file describes for itself, in its record of extra bytes. LAS 1.4 R15, table 24.

use crate::text::short_name;
use las::Header;

/// Bytes of one description.
const DESCRIPTION: usize = 192;

/// Record that holds the descriptions.
const RECORD_ID: u16 = 4;

/// Marks in a description's options: the column has a scale, an offset.
const HAS_SCALE: u8 = 1 << 3;
const HAS_OFFSET: u8 = 1 << 4;

/// A column of extra bytes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ExtraColumn {
    pub(super) name: String,
    /// Bytes from the start of a record.
    at: usize,
    number: Number,
    scale: f64,
    offset: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Number {
    fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::U8,
            2 => Self::I8,
            3 => Self::U16,
            4 => Self::I16,
            5 => Self::U32,
            6 => Self::I32,
            7 => Self::U64,
            8 => Self::I64,
            9 => Self::F32,
            10 => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

impl ExtraColumn {
    /// The column's value in a record; 0 where the record is too short for it.
    pub(super) fn value(&self, record: &[u8]) -> f32 {
        (self.raw_value(record).unwrap_or(0.0) * self.scale + self.offset) as f32
    }

    fn raw_value(&self, record: &[u8]) -> Option<f64> {
        let bytes = record.get(self.at..)?;
        Some(match self.number {
            Number::U8 => f64::from(u8::from_le_bytes(*bytes.first_chunk()?)),
            Number::I8 => f64::from(i8::from_le_bytes(*bytes.first_chunk()?)),
            Number::U16 => f64::from(u16::from_le_bytes(*bytes.first_chunk()?)),
            Number::I16 => f64::from(i16::from_le_bytes(*bytes.first_chunk()?)),
            Number::U32 => f64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            Number::I32 => f64::from(i32::from_le_bytes(*bytes.first_chunk()?)),
            Number::U64 => u64::from_le_bytes(*bytes.first_chunk()?) as f64,
            Number::I64 => i64::from_le_bytes(*bytes.first_chunk()?) as f64,
            Number::F32 => f64::from(f32::from_le_bytes(*bytes.first_chunk()?)),
            Number::F64 => f64::from_le_bytes(*bytes.first_chunk()?),
        })
    }
}

/// The columns that the file describes, those of a single number each.
pub(super) fn extra_columns(header: &Header) -> Vec<ExtraColumn> {
    let format = header.point_format();
    let mut at = usize::from(format.len()) - usize::from(format.extra_bytes);
    let end = usize::from(format.len());
    let record = header
        .all_vlrs()
        .find(|vlr| vlr.user_id == "LASF_Spec" && vlr.record_id == RECORD_ID);
    let mut columns = Vec::new();
    for description in record
        .map(|vlr| vlr.data.as_slice())
        .unwrap_or_default()
        .chunks_exact(DESCRIPTION)
    {
        let &[_, _, code, options, ref rest @ ..] = description else {
            break;
        };

        // Undocumented bytes keep their number in the options; old vectors of numbers are not read on.
        let Some(number) = Number::from_code(code) else {
            if code != 0 {
                break;
            }
            at += usize::from(options);
            continue;
        };
        let name = rest
            .iter()
            .take(32)
            .take_while(|&&byte| byte != 0)
            .copied()
            .collect::<Vec<u8>>();
        let f64_at = |at: usize| {
            description
                .get(at..)?
                .first_chunk()
                .map(|bytes| f64::from_le_bytes(*bytes))
        };
        let stated = |mark: u8, at: usize| {
            f64_at(at).filter(|value| options & mark != 0 && value.is_finite())
        };
        if at + number.size() > end {
            break;
        }
        columns.push(ExtraColumn {
            name: short_name(&String::from_utf8_lossy(&name)),
            at,
            number,
            scale: stated(HAS_SCALE, 112).unwrap_or(1.0),
            offset: stated(HAS_OFFSET, 136).unwrap_or(0.0),
        });
        at += number.size();
    }
    columns
}
