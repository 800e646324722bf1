//! The records of a PLY file, one row each.

use std::io::{BufRead, ErrorKind, Read};

use ply_rs::parser::Parser;
use ply_rs::ply::{Encoding, PropertyAccess, PropertyAccessResult, PropertyType};

use super::columns::{MAX_SLOTS, Row};
use super::header::{Element, Header};
use crate::cloud::read::Source;
use crate::error::Result;
use crate::job::Job;

/// Records between two looks at the job.
const CHUNK: usize = 1 << 16;

/// Longest line of an ascii file, bytes.
const MAX_LINE: u64 = 1 << 20;

/// Reads every record of `element`; each becomes a row, in which property `<letter>` fills the slot of that number.
pub(super) fn read(
    file: &mut impl BufRead,
    header: &Header,
    element: &Element,
    source: &Source<'_>,
    job: &Job,
    mut take: impl FnMut(&Row) -> Result<()>,
) -> Result<()> {
    let parser = Parser::<Record>::new();
    let mut lines = Lines {
        line: Vec::new(),
        number: header.line_count,
    };
    let count = if element.def.properties.is_empty() {
        0
    } else {
        element.def.count
    };
    for index in 0..count {
        if index % CHUNK == 0 {
            job.progress("reading", index as u64, count as u64)?;
        }
        let record = match header.encoding {
            Encoding::Ascii => lines.read(file, element, source)?,
            Encoding::BinaryLittleEndian => parser
                .read_little_endian_element(file, &element.def)
                .map_err(|e| broken(source, element, index, &e))?,
            Encoding::BinaryBigEndian => parser
                .read_big_endian_element(file, &element.def)
                .map_err(|e| broken(source, element, index, &e))?,
        };
        take(&record.0)?;
    }
    job.progress("reading", count as u64, count as u64)
}

fn broken(
    source: &Source<'_>,
    element: &Element,
    index: usize,
    e: &ply_rs::parser::ParseError,
) -> crate::Error {
    let what = if e.kind() == ErrorKind::UnexpectedEof {
        "the file ends within"
    } else {
        "cannot understand"
    };
    source.error(format!(
        "{what} record {} of `{}`; get a whole copy",
        index + 1,
        element.name()
    ))
}

/// A record as the parser fills it: by properties' names, which are slots.
struct Record(Row);

impl Record {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        if let [slot] = name.as_bytes()
            && let Some(place) = self.0.get_mut(usize::from(*slot))
        {
            *place = value;
            PropertyAccessResult::Set
        } else {
            PropertyAccessResult::Ignored
        }
    }
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self([0.0; MAX_SLOTS])
    }

    fn set_char(&mut self, name: &str, value: i8) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_uchar(&mut self, name: &str, value: u8) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_short(&mut self, name: &str, value: i16) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_ushort(&mut self, name: &str, value: u16) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_int(&mut self, name: &str, value: i32) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_uint(&mut self, name: &str, value: u32) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        self.set(name, f64::from(value))
    }

    fn set_double(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        self.set(name, value)
    }
}

/// The lines of an ascii file. Read here, because the parser's grammar knows neither `nan` nor `1.` nor `.5`.
struct Lines {
    line: Vec<u8>,
    number: usize,
}

impl Lines {
    fn read(
        &mut self,
        file: &mut impl BufRead,
        element: &Element,
        source: &Source<'_>,
    ) -> Result<Record> {
        // Records stand one a line; empty lines are passed over.
        loop {
            self.line.clear();
            self.number += 1;
            file.by_ref()
                .take(MAX_LINE)
                .read_until(b'\n', &mut self.line)
                .map_err(|e| source.io_error(e))?;
            if self.line.is_empty() {
                return Err(source.io_error(ErrorKind::UnexpectedEof.into()));
            }
            if !self.line.trim_ascii().is_empty() {
                break;
            }
        }
        let mut record = Record::new();
        self.parse(element, &mut record).ok_or_else(|| {
            source.error(format!(
                "line {} does not hold the numbers that the header promises for a `{}`",
                self.number,
                element.name()
            ))
        })?;
        Ok(record)
    }

    fn parse(&self, element: &Element, record: &mut Record) -> Option<()> {
        let text = std::str::from_utf8(&self.line).ok()?;
        let mut words = text.split_ascii_whitespace();
        for (name, property) in &element.def.properties {
            let word = words.next()?;
            match &property.data_type {
                PropertyType::Scalar(_) => {
                    record.set(name, word.parse().ok()?);
                }
                PropertyType::List(..) => {
                    let count: usize = word.parse().ok()?;
                    if count > 0 {
                        words.nth(count - 1)?;
                    }
                }
            }
        }
        Some(())
    }
}
