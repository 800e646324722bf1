//! The header of a PLY file, and whether the file can hold what it promises.

use std::io::{Cursor, Read};

use ply_rs::parser::{Parser, Reader};
use ply_rs::ply::{DefaultElement, ElementDef, Encoding, PropertyType, ScalarType};

use crate::cloud::UpAxis;
use crate::cloud::read::Source;
use crate::error::Result;
use crate::text::short_name;

/// Longest header that is read, bytes.
const MAX_HEADER: u64 = 1 << 20;

/// Names under which the points of a PLY file go.
const POINT_ELEMENTS: [&str; 4] = ["vertex", "vertices", "point", "points"];

/// One element: its definition, in which property `i` is called `p<i>`, and the names the file gives.
pub(in crate::cloud) struct Element {
    pub(in crate::cloud) def: ElementDef,
    pub(in crate::cloud) names: Vec<String>,
    name: String,
}

/// What the header says.
pub(in crate::cloud) struct Header {
    pub(in crate::cloud) encoding: Encoding,
    /// Bytes before the first element.
    pub(in crate::cloud) length: u64,
    /// Lines before the first element.
    pub(in crate::cloud) line_count: usize,
    elements: Vec<Element>,
    points_index: usize,
    comments: Vec<String>,
}

impl Header {
    /// Reads the header at the start of the file.
    pub(in crate::cloud) fn read(source: &mut Source<'_>) -> Result<Self> {
        let mut bytes = Vec::new();
        (&source.file)
            .take(MAX_HEADER)
            .read_to_end(&mut bytes)
            .map_err(|e| source.io_error(e))?;
        let length = header_length(&bytes).ok_or_else(|| {
            source
                .error("its header has no line `end_header`; it was cut off, or is not a PLY file")
        })?;
        let text = String::from_utf8_lossy(bytes.get(..length).unwrap_or_default());

        // The parser keys properties by name and knows no other letters than ASCII: give it numbers for names.
        let mut numbered = String::with_capacity(text.len());
        let mut names: Vec<(String, Vec<String>)> = Vec::new();
        for line in text.lines() {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words.as_slice() {
                [] => numbered.push_str("comment"),
                ["element", name, count @ ..] => {
                    numbered.push_str(&format!("element e{} {}", names.len(), count.join(" ")));
                    names.push((short_name(name), Vec::new()));
                }
                ["property", "list", count, item, name @ ..] => {
                    numbered.push_str(&format!(
                        "property list {count} {item} p{}",
                        add_name(&mut names, name)
                    ));
                }
                ["property", scalar, name @ ..] => {
                    numbered.push_str(&format!(
                        "property {scalar} p{}",
                        add_name(&mut names, name)
                    ));
                }
                [_, ..] => numbered.push_str(line),
            }
            numbered.push('\n');
        }
        let mut reader = Reader::new(Cursor::new(numbered));
        let parsed = Parser::<DefaultElement>::new()
            .read_header(&mut reader)
            .map_err(|e| {
                let line = e
                    .line()
                    .map_or(String::new(), |line| format!(" in line {line}"));
                source.error(format!(
                    "its header cannot be understood{line}; the file is damaged or not a PLY file"
                ))
            })?;

        let elements: Vec<Element> = names
            .into_iter()
            .zip(parsed.elements)
            .map(|((name, names), (_, def))| Element { def, names, name })
            .collect();
        let points_index = POINT_ELEMENTS
            .iter()
            .find_map(|wanted| {
                elements
                    .iter()
                    .position(|e| e.name.eq_ignore_ascii_case(wanted))
            })
            .ok_or_else(|| source.error("it has no element `vertex`, so no points"))?;
        let comments = parsed
            .comments
            .into_iter()
            .chain(parsed.obj_infos)
            .collect();
        let line_count = text.lines().count();
        Ok(Self {
            encoding: parsed.encoding,
            length: length as u64,
            line_count,
            elements,
            points_index,
            comments,
        })
    }

    /// The element that holds the points.
    pub(in crate::cloud) fn points(&self) -> &Element {
        &self.elements[self.points_index]
    }

    /// All elements, in the file's order.
    pub(in crate::cloud) fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Which of the elements holds the points.
    pub(in crate::cloud) fn points_index(&self) -> usize {
        self.points_index
    }

    /// Whether no record follows the points.
    pub(in crate::cloud) fn points_are_last(&self) -> bool {
        let mut after = self.elements.iter().skip(self.points_index + 1);
        after.all(|element| element.def.count == 0)
    }

    /// An error where the file is too short for the counts of its first `element_count` elements.
    pub(in crate::cloud) fn check_counts(
        &self,
        source: &Source<'_>,
        element_count: usize,
    ) -> Result<()> {
        let mut left = source.length.saturating_sub(self.length);
        for element in self.elements.iter().take(element_count) {
            let count = element.def.count as u64;
            let size = element.smallest_record(self.encoding);

            // The last line of an ascii file may lack its end.
            let slack = u64::from(self.encoding == Encoding::Ascii);
            let needed = count.saturating_mul(size);
            if needed > left + slack {
                return Err(source.error(format!(
                    "its header promises {count} of `{}`, but the file is too short for more than {}; it was cut off, \
                     so get a whole copy",
                    element.name,
                    left.checked_div(size).unwrap_or(0)
                )));
            }
            left = (left + slack).saturating_sub(needed);
        }
        Ok(())
    }

    /// The up axis, where a comment states it: `up_axis y`, `z up`, `Y-up` and the like.
    pub(in crate::cloud) fn up_axis(&self) -> Option<UpAxis> {
        self.comments.iter().find_map(|comment| up_axis_of(comment))
    }
}

impl Element {
    /// An element like this one, whose properties go by other names.
    pub(in crate::cloud) fn renamed(&self, name_of: impl Fn(usize) -> String) -> Self {
        let mut def = ElementDef::new(self.def.name.clone());
        def.count = self.def.count;
        for (index, (_, property)) in self.def.properties.iter().enumerate() {
            let mut property = property.clone();
            property.name = name_of(index);
            def.properties.insert(property.name.clone(), property);
        }
        Self {
            def,
            names: self.names.clone(),
            name: self.name.clone(),
        }
    }

    /// Fewest bytes that one record can take.
    pub(in crate::cloud) fn smallest_record(&self, encoding: Encoding) -> u64 {
        let sizes =
            self.def
                .properties
                .values()
                .map(|property| match (encoding, &property.data_type) {
                    (Encoding::Ascii, _) => 2, // a digit and what parts it from the next
                    (_, PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) => {
                        scalar_size(scalar)
                    }
                });
        sizes.sum()
    }

    /// The element's name, fit for messages.
    pub(in crate::cloud) fn name(&self) -> &str {
        &self.name
    }
}

fn add_name(elements: &mut [(String, Vec<String>)], words: &[&str]) -> usize {
    let Some((_, names)) = elements.last_mut() else {
        return 0;
    };
    names.push(short_name(&words.join(" ")));
    names.len() - 1
}

/// Bytes up to and with the line `end_header`.
fn header_length(bytes: &[u8]) -> Option<usize> {
    let mut length = 0;
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        length += line.len();
        if line.trim_ascii() == b"end_header" && line.ends_with(b"\n") {
            return Some(length);
        }
    }
    None
}

fn scalar_size(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn up_axis_of(comment: &str) -> Option<UpAxis> {
    let lower = comment.to_ascii_lowercase();
    let words: Vec<&str> = lower
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|w| !w.is_empty())
        .collect();
    let axis = words.iter().enumerate().find_map(|(index, &word)| {
        let rest = words.get(index + 1..).unwrap_or_default();
        match (word, rest) {
            ("yup", _) => Some("y"),
            ("zup", _) => Some("z"),
            ("up", ["axis" | "is", axis, ..] | [axis, ..]) | ("upaxis", [axis, ..]) => Some(*axis),
            (axis, ["up", ..]) => Some(axis),
            _ => None,
        }
        .filter(|axis| matches!(*axis, "y" | "z"))
    })?;
    Some(if axis == "y" { UpAxis::Y } else { UpAxis::Z })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_states_the_up_axis_in_many_ways() {
        for (comment, axis) in [
            ("up_axis y", Some(UpAxis::Y)),
            ("Up axis: Z", Some(UpAxis::Z)),
            ("y up", Some(UpAxis::Y)),
            ("exported, Z-up, metres", Some(UpAxis::Z)),
            ("upAxis = y", Some(UpAxis::Y)),
            ("y_up", Some(UpAxis::Y)),
            ("YUP", Some(UpAxis::Y)),
            ("cleaned up by hand", None),
            ("x up", None),
        ] {
            assert_eq!(up_axis_of(comment), axis, "{comment}");
        }
    }
}
