//! Pictures and buffers as OpenEXR: one part, float32, scan lines from the top, ZIP.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::path::Path;

use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::LayerAttributes;
use glam::{DVec3, UVec2, Vec4};

use super::atomic::write_atomically;
use crate::error::Result;
use crate::grid::Grid;
use crate::image::Background;
use crate::job::Job;

/// Primaries and white point of linear RGB here: those of sRGB [IEC 61966-2-1].
const PRIMARIES: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Length of an EXR file's magic number and version.
const HEADER_START: usize = 8;

/// What an EXR file holds: named channels of float32, and named numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrImage {
    /// Width and height, pixels.
    pub size: UVec2,
    /// A value per pixel, row by row from the top, by the channel's name ("R", "normal.X").
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Attributes of the file ("originX").
    pub numbers: BTreeMap<String, f64>,
}

impl ExrImage {
    /// An image without channels.
    pub fn new(size: UVec2) -> Self {
        Self {
            size,
            channels: BTreeMap::new(),
            numbers: BTreeMap::new(),
        }
    }

    /// The picture of radiance (W/sr/m2, alpha 1 where something is seen, else 0): R G B as it is, and A where the
    /// background is transparent. Where nothing is seen there is the background's linear colour.
    pub fn picture(radiance: &Grid<Vec4>, background: Background) -> Self {
        let empty = background.linear().extend(0.0);
        let seen = |i: usize| move |v: &Vec4| if v.w > 0.0 { v[i] } else { empty[i] };
        let mut image = Self::new(radiance.size());
        image.add_channels("", "RGB", |i| {
            radiance.values().iter().map(seen(i)).collect()
        });
        if background == Background::Transparent {
            image.add_channels("", "A", |_| {
                radiance
                    .values()
                    .iter()
                    .map(|v| f32::from(v.w > 0.0))
                    .collect()
            });
        }
        image
    }

    /// Adds a channel per letter of `letters`, with a layer's name in front unless that is empty.
    pub(super) fn add_channels(
        &mut self,
        layer: &str,
        letters: &str,
        values: impl Fn(usize) -> Vec<f32>,
    ) {
        let prefix = if layer.is_empty() {
            String::new()
        } else {
            format!("{layer}.")
        };
        for (i, letter) in letters.chars().enumerate() {
            self.channels.insert(format!("{prefix}{letter}"), values(i));
        }
    }

    /// Notes the origin that positions are relative to, in the attributes originX, originY, originZ.
    pub fn set_origin(&mut self, origin: DVec3) {
        for (axis, value) in ["originX", "originY", "originZ"]
            .into_iter()
            .zip(origin.to_array())
        {
            self.numbers.insert(axis.to_owned(), value);
        }
    }

    /// The file's bytes, the same for the same image.
    ///
    /// # Errors
    /// Where there is no channel, a channel is not as long as width times height, or a name is not plain text; and
    /// [`crate::Error::Cancelled`], passed through.
    pub fn encode(self, job: &Job) -> io::Result<Vec<u8>> {
        let pixels = self.size.x as usize * self.size.y as usize;
        let mut channels = Vec::with_capacity(self.channels.len());
        for (name, values) in self.channels {
            if values.len() != pixels {
                return Err(invalid(format!(
                    "channel {name} has {} values for {pixels} pixels",
                    values.len()
                )));
            }
            channels.push(AnyChannel::new(text(&name)?, FlatSamples::F32(values)));
        }
        if channels.is_empty() || pixels == 0 {
            return Err(invalid("the image is empty".to_owned()));
        }
        let mut attributes = LayerAttributes {
            software_name: Some(text(concat!("catoptric ", env!("CARGO_PKG_VERSION")))?),
            ..LayerAttributes::default()
        };
        for (name, &value) in &self.numbers {
            attributes
                .other
                .insert(text(name)?, AttributeValue::F64(value));
        }
        let size = Vec2(self.size.x as usize, self.size.y as usize);
        let layer = Layer::new(
            size,
            attributes,
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(channels.into()),
        );
        let mut image = Image::from_layer(layer);
        image.attributes.chromaticities = Some(PRIMARIES);

        let mut bytes = Vec::new();
        image
            .write()
            .to_buffered(Watched {
                inner: Cursor::new(&mut bytes),
                job,
            })
            .map_err(|e| match e {
                exr::error::Error::Io(passed_through) => passed_through,
                other => io::Error::other(other),
            })?;
        sort_attributes(&mut bytes);
        Ok(bytes)
    }

    /// The image of a file's bytes: its channels, as float32 whatever they are in the file, and its f64 attributes.
    ///
    /// # Errors
    /// Where the bytes are no EXR file of one part.
    pub fn decode(bytes: &[u8]) -> io::Result<Self> {
        let image = exr::image::read::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(io::Error::other)?;
        let layer = image.layer_data;
        let side = |length: usize| u32::try_from(length).map_err(io::Error::other);
        let mut read = Self::new(UVec2::new(side(layer.size.x())?, side(layer.size.y())?));
        for channel in layer.channel_data.list {
            let name = channel.name.to_string();
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
                FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
            };
            read.channels.insert(name, values);
        }
        for (name, value) in layer.attributes.other {
            if let AttributeValue::F64(number) = value {
                read.numbers.insert(name.to_string(), number);
            }
        }
        Ok(read)
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`crate::Error::Write`] where it cannot be written or encoded; what was there before is then still there.
    pub fn write(self, path: &Path) -> Result<()> {
        write_atomically(path, |file| file.write_all(&self.encode(&Job::default())?))
    }
}

/// What the encoder writes to, block by block: no further block once the job is cancelled.
struct Watched<'a, W> {
    inner: W,
    job: &'a Job,
}

impl<W: Write> Write for Watched<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.job.check().map_err(io::Error::other)?;
        self.inner.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Watched<'_, W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

fn invalid(problem: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem)
}

/// Names as the format holds them: not empty, at most 255 bytes of ASCII.
fn text(name: &str) -> io::Result<Text> {
    let plain = !name.is_empty() && name.len() <= 255 && name.is_ascii() && !name.contains('\0');
    plain
        .then(|| Text::new_or_none(name))
        .flatten()
        .ok_or_else(|| {
            invalid(format!(
                "{name:?} is no name for a channel or attribute of an EXR file"
            ))
        })
}

/// Puts a header's attributes in the order of their names.
///
/// The encoder writes them in an order that differs from run to run. Their length in all stays, so nothing behind
/// them moves.
fn sort_attributes(file: &mut [u8]) {
    let Some(header) = file.get_mut(HEADER_START..) else {
        return;
    };
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut length = 0;
    // Each is a name and a type, both ended by a zero, the value's size, and the value; a zero ends the list.
    while let Some(attribute) = header.get(length..).and_then(first_attribute) {
        length += attribute.len();
        attributes.push(attribute.to_owned());
    }
    attributes.sort();
    if let Some(sorted) = header.get_mut(..length) {
        sorted.copy_from_slice(&attributes.concat());
    }
}

/// The attribute that `header` begins with, or `None` at the end of the list.
fn first_attribute(header: &[u8]) -> Option<&[u8]> {
    let zero = |from: usize| Some(from + header.get(from..)?.iter().position(|&b| b == 0)?);
    let name_end = zero(0).filter(|&end| end > 0)?;
    let size_start = zero(name_end + 1)? + 1;
    let size = header
        .get(size_start..size_start + 4)?
        .try_into()
        .map(u32::from_le_bytes)
        .ok()?;
    header.get(..size_start + 4 + size as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(size: UVec2) -> ExrImage {
        let mut image = ExrImage::new(size);
        let value = |i: usize, p: u32| (i as f32 + 1.0) * (p as f32 - 3.5) / 7.0;
        for (layer, letters) in [("normal", "XYZ"), ("albedo", "RGB"), ("valid", "V")] {
            image.add_channels(layer, letters, |i| {
                (0..size.element_product()).map(|p| value(i, p)).collect()
            });
        }
        image.set_origin(DVec3::new(636_001.123_456_789, -848_935.25, 0.1));
        image
    }

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        for size in [
            UVec2::ONE,
            UVec2::new(3, 2),
            UVec2::new(37, 21),
            UVec2::new(1, 50),
        ] {
            let written = image(size);
            let read = ExrImage::decode(&written.clone().encode(&Job::default()).expect("bytes"))
                .expect("an image");
            assert_eq!(read, written);
        }
    }

    #[test]
    fn equal_images_give_equal_bytes() {
        let bytes = image(UVec2::new(100, 80))
            .encode(&Job::default())
            .expect("bytes");
        for _ in 0..8 {
            assert!(
                image(UVec2::new(100, 80))
                    .encode(&Job::default())
                    .expect("bytes")
                    == bytes,
                "the bytes differ from run to run"
            );
        }
        let mut other = image(UVec2::new(100, 80));
        other.numbers.insert("originX".to_owned(), 0.0);
        assert!(
            other.encode(&Job::default()).expect("bytes") != bytes,
            "another image must give other bytes"
        );
    }

    #[test]
    fn the_picture_holds_radiance_and_alpha_only_where_transparent() {
        let radiance = Grid::from_vec(
            UVec2::new(2, 1),
            vec![Vec4::new(7.5, 0.5, 0.0, 1.0), Vec4::ONE * 0.0],
        );
        let radiance = radiance.expect("a grid");
        let picture = ExrImage::picture(&radiance, Background::Transparent);
        let channel = |name: &str| picture.channels.get(name).cloned();
        assert_eq!(channel("R"), Some(vec![7.5, 0.0]));
        assert_eq!(channel("A"), Some(vec![1.0, 0.0]));
        let on_white = ExrImage::picture(&radiance, Background::Colour([255; 3]));
        assert_eq!(on_white.channels.get("G"), Some(&vec![0.5, 1.0]));
        assert!(
            !on_white.channels.contains_key("A"),
            "no alpha without transparency"
        );
    }

    #[test]
    fn impossible_images_are_refused() {
        let mut short = image(UVec2::new(3, 2));
        short.channels.insert("R".to_owned(), vec![0.0; 5]);
        let mut named = image(UVec2::new(3, 2));
        named.channels.insert("\u{fc}ber".to_owned(), vec![0.0; 6]);
        for broken in [
            short,
            named,
            ExrImage::new(UVec2::ONE),
            ExrImage::new(UVec2::ZERO),
        ] {
            assert!(
                broken.clone().encode(&Job::default()).is_err(),
                "{broken:?} must be refused"
            );
        }
        assert!(
            ExrImage::decode(b"no EXR file").is_err(),
            "other files must be refused"
        );
    }
}
