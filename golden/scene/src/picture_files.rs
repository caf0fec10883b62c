//! Metadata of picture and depth files: chunks of PNG, attributes and channels of OpenEXR.

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused};
use potamoi_base::file_keys::{FileKeys, Format, Notes, key};

const OTHER_COLOURS: &str = "colours are taken as sRGB: save the picture in sRGB";

/// Keys of a picture: chunks of PNG.
pub(super) static PNG: Format = Format {
    name: "PNG of image sequences",
    files: "Pictures that `transforms.json` names: 8 or 16 bits, grey or colours, with or without \
            alpha, over the background.",
    keys: &[
        key("IHDR", Honoured, "size and kind of pixels"),
        key("PLTE", Honoured, "colours of a palette"),
        key("tRNS", Honoured, "what of it is clear"),
        key("IDAT", Honoured, "the pixels"),
        key("IEND", Honoured, "the end"),
        key("sRGB", Honoured, "it is what is assumed"),
        key("gAMA", Refused, OTHER_COLOURS),
        key("cICP", Refused, OTHER_COLOURS),
        key("iCCP", Listed, "colours are taken as sRGB"),
        key("cHRM", Listed, "colours are taken as sRGB"),
        key("acTL", Listed, "the still picture of an animation is read"),
        key("fcTL", Listed, "the still picture of an animation is read"),
        key("fdAT", Listed, "the still picture of an animation is read"),
        key("eXIf", Listed, "pictures are taken as they lie"),
        key(BEHIND, Listed, "bytes behind IEND are not read"),
    ],
    others: Listed,
};

/// Keys of a depth: attributes of OpenEXR.
pub(super) static EXR: Format = Format {
    name: "OpenEXR of image sequences",
    files: "Depths beside the pictures.",
    keys: &[
        key(
            "channels",
            Honoured,
            "R is the depth; G and B have to be there",
        ),
        key("channel R", Honoured, "the depth along the camera's axis"),
        key("channel *", Listed, "no depth"),
        key("compression", Honoured, "all that loses nothing or little"),
        key(
            "dataWindow",
            Honoured,
            "the pixels, which are the whole picture",
        ),
        key(
            "displayWindow",
            Honoured,
            "as dataWindow: parts of pictures are refused",
        ),
        key("lineOrder", Honoured, "any"),
        key("tiles", Honoured, "any"),
        key("type", Honoured, "lines or tiles"),
        key("version", Honoured, "of the form"),
        key("chunkCount", Honoured, "of the form"),
        key(
            "pixelAspectRatio",
            Refused,
            "pixels are squares; 1 is accepted",
        ),
        key("envmap", Refused, "only pinholes are rendered"),
        key("screenWindowCenter", Listed, "the path's camera counts"),
        key("screenWindowWidth", Listed, "the path's camera counts"),
        key("worldTo*", Listed, "the path's camera counts"),
        key("name", Listed, "of the only part"),
        key("chromaticities", Listed, "depths have no colour"),
    ],
    others: Listed,
};

/// Name under which bytes behind a picture are listed.
const BEHIND: &str = "bytes behind the picture";
const PNG_HEAD: &[u8] = b"\x89PNG\r\n\x1a\n";
const EXR_HEAD: &[u8] = b"\x76\x2f\x31\x01";
/// Bits of OpenEXR's version that mark several parts and deep pixels.
const PARTS: u32 = 1 << 12;
const DEEP: u32 = 1 << 11;
/// The PNG gamma of sRGB, in units of 1/100,000, and its rounding in files.
const GAMMA: u32 = 45_455;
const GAMMA_OFF: u32 = 500;

fn word(bytes: &[u8]) -> Option<[u8; 4]> {
    bytes.get(..4)?.try_into().ok()
}

/// Checks the chunks of a PNG file. A truncated chunk is left to the decoder.
pub(super) fn png(bytes: &[u8], notes: &mut Notes) -> Result<(), String> {
    let mut rest = bytes.strip_prefix(PNG_HEAD).unwrap_or_default();
    let mut chunks: Vec<(String, &[u8])> = vec![];
    while let Some((length, name)) = word(rest).zip(rest.get(4..8)) {
        let length = u32::from_be_bytes(length) as usize;
        let Some(data) = rest.get(8..8 + length) else {
            break;
        };
        let name = printable(name);
        let is_end = name == "IEND";
        if !chunks.iter().any(|(known, _)| *known == name) {
            chunks.push((name, data));
        }
        rest = rest.get(12 + length..).unwrap_or_default();
        if is_end {
            break;
        }
    }
    if !rest.is_empty() && chunks.iter().any(|(name, _)| name == "IEND") {
        chunks.push((BEHIND.to_owned(), rest));
    }
    let says_srgb = chunks.iter().any(|(name, _)| name == "sRGB");
    let mut record = FileKeys::new(&PNG, chunks);
    for row in PNG.keys.iter().filter(|row| row.fate == Honoured) {
        record.take(row.name);
    }
    let gamma = record.peek("gAMA").and_then(|data| word(data));
    let usual = |v: [u8; 4]| u32::from_be_bytes(v).abs_diff(GAMMA) <= GAMMA_OFF;
    // Where both are there, PNG says that sRGB counts.
    if says_srgb || gamma.is_some_and(usual) {
        record.take("gAMA");
    }
    // Primaries of BT.709, the transfer of sRGB, full range.
    if record.peek("cICP") == Some(&&[1, 13, 0, 1][..]) {
        record.take("cICP");
    }
    record.finish(notes).map_err(|e| e.to_string())
}

/// A zero-terminated text, and the bytes behind it.
fn text(bytes: &[u8]) -> Option<(String, &[u8])> {
    let end = bytes.iter().take(256).position(|b| *b == 0)?;
    Some((printable(&bytes[..end]), &bytes[end + 1..]))
}

/// A name of a file with control characters as escapes: a message that quotes it stays one line.
fn printable(name: &[u8]) -> String {
    let text = String::from_utf8_lossy(name);
    let each = text.chars().map(|own| match own.is_control() {
        true => own.escape_default().to_string(),
        false => own.to_string(),
    });
    each.collect()
}

/// The names in a list of channels; each name is followed by 16 bytes of properties.
fn channels(mut list: &[u8]) -> Vec<String> {
    let mut names = vec![];
    while let Some((name, rest)) = text(list).filter(|(name, _)| !name.is_empty()) {
        names.push(name);
        list = rest.get(16..).unwrap_or_default();
    }
    names
}

/// Checks the attributes of an OpenEXR file. A truncated attribute is left to the decoder.
pub(super) fn exr(bytes: &[u8], notes: &mut Notes) -> Result<(), String> {
    let Some(version) = bytes.strip_prefix(EXR_HEAD).and_then(word) else {
        return Ok(());
    };
    let version = u32::from_le_bytes(version);
    if version & PARTS != 0 {
        return Err("it has several parts: expected one, with channels R, G and B".to_owned());
    }
    if version & DEEP != 0 {
        return Err("it has several depths a pixel: expected one".to_owned());
    }
    let mut entries: Vec<(String, &[u8])> = vec![];
    let mut rest = &bytes[8..];
    while let Some((name, behind)) = text(rest).filter(|(name, _)| !name.is_empty()) {
        let parsed = text(behind).and_then(|(_, behind)| {
            let length = u32::from_le_bytes(word(behind)?) as usize;
            Some((behind.get(4..4 + length)?, &behind[4 + length..]))
        });
        let Some((value, behind)) = parsed else {
            break;
        };
        entries.push((name, value));
        rest = behind;
    }
    let named = |wanted: &str| entries.iter().find(|(name, _)| name == wanted).map(|e| e.1);
    if let Some(list) = named("channels") {
        let names = channels(list);
        if !["R", "G", "B"]
            .iter()
            .all(|wanted| names.iter().any(|name| name == wanted))
        {
            let names = names.join(", ");
            return Err(format!(
                "its channels are {names}: expected R, G and B, the depth in R"
            ));
        }
        entries.extend(
            names
                .into_iter()
                .map(|name| (format!("channel {name}"), &[][..])),
        );
    }
    let named = |wanted: &str| entries.iter().find(|(name, _)| name == wanted).map(|e| e.1);
    if named("dataWindow") != named("displayWindow") {
        return Err(
            "its `dataWindow` is not its `displayWindow`: expected the whole picture".to_owned(),
        );
    }
    let mut record = FileKeys::new(&EXR, entries);
    for row in EXR.keys.iter().filter(|row| row.fate == Honoured) {
        record.take(row.name);
    }
    record.take_neutral(|value| word(value) == Some(1f32.to_le_bytes()));
    record.finish(notes).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use image::{ImageBuffer, ImageFormat, Rgb};

    use super::*;
    use potamoi_base::file_keys::Fate;

    fn encoded(format: ImageFormat) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(vec![]);
        match format {
            ImageFormat::Png => ImageBuffer::from_pixel(3, 2, Rgb([1u8, 2, 3]))
                .write_to(&mut bytes, format)
                .unwrap(),
            _ => ImageBuffer::from_pixel(3, 2, Rgb([1f32, 2.0, 3.0]))
                .write_to(&mut bytes, format)
                .unwrap(),
        }
        bytes.into_inner()
    }

    /// With a chunk behind the header.
    fn with_chunk(name: &str, data: &[u8]) -> Vec<u8> {
        let plain = encoded(ImageFormat::Png);
        let (head, rest) = plain.split_at(33);
        let length = (data.len() as u32).to_be_bytes();
        [head, &length, name.as_bytes(), data, &[0; 4], rest].concat()
    }

    /// With an attribute behind the version.
    fn with_attribute(name: &str, value: &[u8]) -> Vec<u8> {
        let plain = encoded(ImageFormat::OpenExr);
        let (head, rest) = plain.split_at(8);
        let length = (value.len() as u32).to_le_bytes();
        [head, name.as_bytes(), b"\0float\0", &length, value, rest].concat()
    }

    fn said(
        judge: fn(&[u8], &mut Notes) -> Result<(), String>,
        bytes: &[u8],
    ) -> Result<String, String> {
        let mut notes = Notes::default();
        judge(bytes, &mut notes).map(|()| notes.not_used().join(", "))
    }

    #[test]
    fn chunks_of_png_are_honoured_refused_or_listed() {
        assert_eq!(said(png, &encoded(ImageFormat::Png)).unwrap(), "");
        for row in PNG
            .keys
            .iter()
            .map(|row| (row.name, row.fate))
            .filter(|(name, _)| !["IEND", BEHIND].contains(name))
            .chain([("prVt", Listed)])
        {
            let (name, fate) = row;
            let found = said(png, &with_chunk(name, &100_000u32.to_be_bytes()));
            match fate {
                Honoured | Fate::Whole => assert_eq!(found.unwrap(), "", "{name}"),
                Listed => assert_eq!(found.unwrap(), name),
                Refused => assert!(found.unwrap_err().contains(&format!("`{name}`"))),
            }
        }
        assert_eq!(
            said(png, &with_chunk("gAMA", &45_455u32.to_be_bytes())).unwrap(),
            ""
        );
        assert_eq!(said(png, &with_chunk("cICP", &[1, 13, 0, 1])).unwrap(), "");
        let behind = [&encoded(ImageFormat::Png)[..], b"more"].concat();
        assert_eq!(said(png, &behind).unwrap(), BEHIND);
        // Behind a chunk that is cut off there is nothing to judge.
        assert_eq!(said(png, &with_chunk("gAMA", &[0; 4])[..40]).unwrap(), "");
    }

    #[test]
    fn attributes_of_exr_are_honoured_refused_or_listed() {
        let plain = "channel B, channel G, screenWindowCenter, screenWindowWidth";
        let found = said(exr, &encoded(ImageFormat::OpenExr)).unwrap();
        let mut sorted: Vec<_> = found.split(", ").collect();
        sorted.sort_unstable();
        assert_eq!(sorted.join(", "), plain);
        for (name, value, refused) in [
            ("pixelAspectRatio", 2f32, true),
            ("envmap", 0.0, true),
            ("worldToNDC", 1.0, false),
            ("owner", 1.0, false),
        ] {
            match said(exr, &with_attribute(name, &value.to_le_bytes())) {
                Ok(found) => assert!(!refused && found.contains(name), "{name}: {found}"),
                Err(error) => assert!(refused && error.contains(name), "{error}"),
            }
        }
        let window = said(exr, &with_attribute("dataWindow", &[1; 16])).unwrap_err();
        assert!(window.contains("whole picture"), "{window}");
        let depth = with_attribute("channels", b"Z\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\0");
        let error = said(exr, &depth).unwrap_err();
        assert_eq!(
            error,
            "its channels are Z: expected R, G and B, the depth in R"
        );
        let damaged = with_attribute("channels", b"\n\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\0");
        let error = said(exr, &damaged).unwrap_err();
        assert!(error.contains("its channels are \\n: expected"), "{error}");
        let mut parts = encoded(ImageFormat::OpenExr);
        parts[5] |= 0x10;
        assert!(said(exr, &parts).unwrap_err().contains("several parts"));
    }
}
