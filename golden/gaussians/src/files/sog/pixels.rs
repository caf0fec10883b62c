//! The images of an SOG file. Their pixels are codes, so any image that is lossy or lacks a
//! channel is refused.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, Limits, RgbaImage};

use super::super::error::{FileError, Origin};
use super::PALETTE_ROW;

/// Pixels that an image may have beyond four a Gaussian.
const SPARE_PIXELS: u64 = 1 << 20;
/// The remedy for an image that is refused.
const AGAIN: &str = "WebP without loss, or PNG, of 8 bits, red, green and blue";

/// Requirements on an image.
pub(super) struct ImageNeeds {
    /// Minimum number of pixels, one a Gaussian.
    pub(super) count: usize,
    /// Required width and minimum height, in place of the number of pixels.
    pub(super) size: Option<[u32; 2]>,
    /// Whether alpha holds codes, too.
    pub(super) with_alpha: bool,
}

/// Decodes an image; its size is checked before memory is reserved.
pub(super) fn read(
    bytes: &[u8],
    file: &str,
    wanted: ImageNeeds,
    name: Origin<'_>,
) -> Result<RgbaImage, FileError> {
    let fail = || name.part(file, "it is no image that can be read, such as WebP");
    let wrong = |value: &str| Err(name.field(format!("image `{file}`"), value, AGAIN));
    let from = Cursor::new(bytes);
    // Decoders by their names: a reader of any format builds those of all formats.
    let mut decoder: Box<dyn ImageDecoder + '_> = match image::guess_format(bytes) {
        Ok(ImageFormat::WebP) if is_lossy(bytes) => {
            return wrong("WebP with loss, which changes codes");
        }
        Ok(ImageFormat::WebP) => Box::new(WebPDecoder::new(from).map_err(|_| fail())?),
        Ok(ImageFormat::Png) => {
            let decoder = PngDecoder::with_limits(from, Limits::default());
            Box::new(decoder.map_err(|_| fail())?)
        }
        Ok(_) => return wrong("of another format"),
        Err(_) => return Err(fail()),
    };
    decoder.set_limits(Limits::default()).map_err(|_| fail())?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    let count = wanted.count as u64;
    let most = 4 * count + SPARE_PIXELS;
    let (right, expected) = match wanted.size {
        Some([w, h]) => (
            width == w && (h..=h + PALETTE_ROW as u32).contains(&height),
            format!("{w} x {h}"),
        ),
        None => (
            (count..=most).contains(&pixels),
            format!("{count} to {most} pixels, one a Gaussian"),
        ),
    };
    if !right {
        let field = format!("size of `{file}`");
        return Err(name.field(field, format!("{width} x {height}"), expected));
    }
    match decoder.color_type() {
        ColorType::Rgba8 => {}
        ColorType::Rgb8 if !wanted.with_alpha => {}
        ColorType::Rgb8 => {
            let expected = "one with alpha, which holds codes";
            let field = format!("image `{file}`");
            return Err(name.field(field, "without alpha", expected));
        }
        ColorType::L8 | ColorType::La8 => return wrong("grey"),
        _ => return wrong("of more than 8 bits"),
    }
    let image = DynamicImage::from_decoder(decoder).map_err(|_| fail())?;
    Ok(image.into_rgba8())
}

/// Whether a chunk of a WebP file holds lossy pixels.
fn is_lossy(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(12..).unwrap_or_default();
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        if head.starts_with(b"VP8 ") {
            return true;
        }
        let length = u32::from_le_bytes([head[4], head[5], head[6], head[7]]) as usize;
        // Chunks have an even number of bytes.
        let next = length.saturating_add(length % 2);
        rest = after.get(next..).unwrap_or_default();
    }
    false
}
