//! The records of a PLY file, one row each.

use std::io::{BufRead, ErrorKind, Read};

use ply_rs::parser::Parser;
use ply_rs::ply::{Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::header::{Element, Header};
use crate::cloud::read::Source;
use crate::error::Result;
use crate::job::Job;

/// Records between two looks at the job.
const CHUNK: usize = 1 << 16;

/// Longest line of an ascii file, bytes: a polygon of a million corners fits.
const MAX_LINE: u64 = 16 << 20;

/// Most properties that are kept of a record.
pub(in crate::cloud) const MAX_SLOTS: usize = 64;

/// Name of the one list property that is kept.
pub(in crate::cloud) const LIST: &str = "list";

/// The scalars of one record, by slot.
pub(in crate::cloud) type Row = [f64; MAX_SLOTS];

/// The records of an open file, after its header.
pub(in crate::cloud) struct Body<'a, R> {
    file: R,
    header: &'a Header,
    source: &'a Source<'a>,
    lines: Lines,
}

impl<'a, R: BufRead> Body<'a, R> {
    /// The records that `file` holds from here.
    pub(in crate::cloud) fn new(file: R, header: &'a Header, source: &'a Source<'a>) -> Self {
        Self {
            file,
            header,
            source,
            lines: Lines {
                line: Vec::new(),
                number: header.line_count,
            },
        }
    }

    /// Reads every record of `element`, the next one. The property whose name is one letter fills the slot of that
    /// number; that called [`LIST`], the list.
    pub(in crate::cloud) fn read(
        &mut self,
        element: &Element,
        job: &Job,
        mut take: impl FnMut(&Record) -> Result<()>,
    ) -> Result<()> {
        let parser = Parser::<Record>::new();
        let (file, source) = (&mut self.file, self.source);
        let count = if element.def.properties.is_empty() {
            0
        } else {
            element.def.count
        };
        for index in 0..count {
            if index % CHUNK == 0 {
                job.progress("reading", index as u64, count as u64)?;
            }
            let record = match self.header.encoding {
                Encoding::Ascii => self.lines.read(file, element, source, index)?,
                Encoding::BinaryLittleEndian => parser
                    .read_little_endian_element(file, &element.def)
                    .map_err(|e| broken(source, element, index, e.kind()))?,
                Encoding::BinaryBigEndian => parser
                    .read_big_endian_element(file, &element.def)
                    .map_err(|e| broken(source, element, index, e.kind()))?,
            };
            take(&record)?;
        }
        job.progress("reading", count as u64, count as u64)
    }

    /// Refuses what is left of the file after `element`, its last: a header that promises too few records is wrong.
    pub(in crate::cloud) fn finish(self, element: &Element) -> Result<()> {
        let Self {
            file,
            header,
            source,
            ..
        } = self;
        let surplus = match header.encoding {
            Encoding::Ascii => file
                .bytes()
                .find(|byte| !byte.as_ref().is_ok_and(u8::is_ascii_whitespace))
                .transpose()
                .map_err(|e| source.io_error(e))?
                .is_some(),
            // Less than a record is padding.
            Encoding::BinaryLittleEndian | Encoding::BinaryBigEndian => {
                let size = element.smallest_record(header.encoding);
                let mut rest = Vec::new();
                file.take(size)
                    .read_to_end(&mut rest)
                    .map_err(|e| source.io_error(e))?;
                size > 0 && rest.len() as u64 == size
            }
        };
        if surplus {
            return Err(source.error(format!(
                "it goes on after the {} of `{}` that its header promises; correct the count, or export it again",
                element.def.count,
                element.name()
            )));
        }
        Ok(())
    }
}

fn broken(source: &Source<'_>, element: &Element, index: usize, kind: ErrorKind) -> crate::Error {
    let what = if kind == ErrorKind::UnexpectedEof {
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
pub(in crate::cloud) struct Record {
    /// Its kept scalars.
    pub(in crate::cloud) row: Row,
    /// Its kept list.
    pub(in crate::cloud) list: Vec<u32>,
}

impl Record {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        if let [slot] = name.as_bytes()
            && let Some(place) = self.row.get_mut(usize::from(*slot))
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
        Self {
            row: [0.0; MAX_SLOTS],
            list: Vec::new(),
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != LIST {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(list) => self.list = list,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
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
        index: usize,
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
                return Err(broken(source, element, index, ErrorKind::UnexpectedEof));
            }
            if self.line.len() as u64 == MAX_LINE && !self.line.ends_with(b"\n") {
                return Err(source.error(format!(
                    "line {} is longer than {} MiB; write each record on a line of its own",
                    self.number,
                    MAX_LINE >> 20
                )));
            }
            if !self.line.trim_ascii().is_empty() {
                break;
            }
        }
        let mut record = Record::new();
        let rest = self.parse(element, &mut record);
        let problem = match rest {
            Some(0) => return Ok(record),
            Some(_) => "holds more than",
            None => "does not hold",
        };
        Err(source.error(format!(
            "line {} {problem} the numbers that the header promises for a `{}`; export it again",
            self.number,
            element.name()
        )))
    }

    /// Fills the record; gives the number of words that are left, or `None` where one is missing or no number.
    fn parse(&self, element: &Element, record: &mut Record) -> Option<usize> {
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
                    if name == LIST {
                        // The line's length, not the count, bounds the list.
                        for _ in 0..count {
                            record.list.push(words.next()?.parse().ok()?);
                        }
                    } else if count > 0 {
                        words.nth(count - 1)?;
                    }
                }
            }
        }
        Some(words.count())
    }
}
