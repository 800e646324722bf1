//! Pictures as PNG: 8-bit sRGB, said so in the file.

use std::io::{self, Write};

use crate::grid::Grid;
use crate::image::Background;
use crate::job::Job;

/// Bytes that are compressed at a time.
const CHUNK: usize = 1 << 16;

/// Writes a picture (sRGB and straight alpha) as PNG: RGB, or RGBA where the background is transparent.
///
/// # Errors
/// What the writer says, that the picture is too large for a PNG, or [`crate::Error::Cancelled`], passed through.
pub fn encode_png(
    file: &mut dyn Write,
    picture: &Grid<[u8; 4]>,
    background: Background,
    job: &Job,
) -> io::Result<()> {
    let mut encoder = png::Encoder::new(file, picture.size().x, picture.size().y);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let channels = match background {
        Background::Transparent => {
            encoder.set_color(png::ColorType::Rgba);
            4
        }
        Background::Auto | Background::Colour(_) => {
            encoder.set_color(png::ColorType::Rgb);
            3
        }
    };
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer_with_size(CHUNK)?;
    let mut bytes = Vec::with_capacity(CHUNK);
    for pixels in picture.values().chunks(CHUNK / 4) {
        job.check().map_err(io::Error::other)?;
        bytes.clear();
        bytes.extend(pixels.iter().flat_map(|pixel| &pixel[..channels]));
        stream.write_all(&bytes)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    fn back(picture: &Grid<[u8; 4]>, background: Background) -> (png::OutputInfo, Vec<u8>, bool) {
        let mut bytes = Vec::new();
        encode_png(&mut bytes, picture, background, &Job::default()).expect("a PNG");
        let mut reader = png::Decoder::new(io::Cursor::new(bytes))
            .read_info()
            .expect("a header");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut pixels).expect("pixels");
        let says_srgb = reader.info().srgb.is_some();
        (info, pixels, says_srgb)
    }

    #[test]
    fn pixels_come_back_as_they_were_and_are_srgb() {
        for size in [UVec2::ONE, UVec2::new(3, 2), UVec2::new(37, 21)] {
            let values =
                (0..size.element_product()).map(|i| [i as u8, (i * 7) as u8, (i * 31) as u8, 255]);
            let picture = Grid::from_vec(size, values.collect()).expect("a picture");
            let (info, pixels, says_srgb) = back(&picture, Background::Colour([0; 3]));
            assert_eq!(
                (info.width, info.height, info.color_type),
                (size.x, size.y, png::ColorType::Rgb)
            );
            let expected: Vec<u8> = picture
                .values()
                .iter()
                .flat_map(|p| p[..3].to_vec())
                .collect();
            assert_eq!(pixels, expected);
            assert!(
                says_srgb,
                "a reader must not have to guess the colour space"
            );
        }
    }

    #[test]
    fn alpha_is_there_only_where_the_background_is_transparent() {
        let picture =
            Grid::from_vec(UVec2::new(2, 1), vec![[9, 8, 7, 255], [0; 4]]).expect("a picture");
        let (info, pixels, _) = back(&picture, Background::Transparent);
        assert_eq!(info.color_type, png::ColorType::Rgba);
        assert_eq!(pixels, [9, 8, 7, 255, 0, 0, 0, 0]);
    }
}
