//! SOG, version 2: WebP images of quantised values and a `meta.json` that describes them, in a
//! folder or in a ZIP file.
//!
//! Each Gaussian is a pixel, row by row. Centres take 16 bits a coordinate over a range of
//! `sign(v) ln(|v| + 1)`, the upper and the lower byte in an image each. Log scales and constant
//! coefficients are bytes that index a codebook. Rotations are three bytes over +-1/sqrt(2) and,
//! in alpha, 252 plus the index of the largest component of `w, x, y, z`, which is omitted.
//! Opacity is the alpha of the colours. Coefficients above the constant are shared: a 16-bit label
//! names an entry of a palette, 64 entries a row, of indices into a codebook. Source: the format's
//! specification in the PlayCanvas manual.

use std::f64::consts::SQRT_2;
use std::io::{Cursor, Read as _};
use std::path::{Component, Path};

use image::RgbaImage;
use rayon::prelude::*;
use zip::ZipArchive;

use super::error::{FileError, Origin};
use super::reader::{Reader, limited, whole};
use super::values;
use crate::Cloud;
use crate::file_content::{Facts, Loaded, Raw};
use meta::Meta;
use pixels::ImageNeeds;
use potamoi_base::file_keys::{Fate, Format, Notes, key, told};
use potamoi_containers::archive;

mod entries;
pub mod levels;
mod meta;
mod pixels;

/// The file that describes the images of a folder.
pub(super) const META: &str = "meta.json";
/// The largest `meta.json`, in bytes.
const LONGEST_META: u64 = 4 << 20;
/// The largest image file, in bytes.
const LARGEST_IMAGE: u64 = 1 << 30;
/// The longest file name in bytes that file systems accept.
const LONGEST_NAME: usize = 255;
/// Palette entries in a row of the image of centroids.
const PALETTE_ROW: usize = 64;

/// Keys of the format: the paths of `meta.json` fields, and members of the archive.
pub static FORMAT: Format = Format {
    name: "SOG of PlayCanvas",
    files: "`.sog`, a folder with `meta.json`, or that file: the fields of `meta.json`, and members of the archive",
    keys: &[
        key("version", Fate::Honoured, "2"),
        key("count", Fate::Honoured, "Gaussians, 1 or more"),
        key(
            "antialias",
            Fate::Honoured,
            "trained with antialiasing: true or false",
        ),
        key(
            "model",
            Fate::Honoured,
            "`antialiased` or `default`, in agreement",
        ),
        key(
            "means.mins",
            Fate::Honoured,
            "smallest `sign(v) ln(abs(v) + 1)` along each axis, not above the largest",
        ),
        key("means.maxs", Fate::Honoured, "largest"),
        key(
            "means.files",
            Fate::Honoured,
            "images of lower and upper bytes",
        ),
        key(
            "scales.codebook",
            Fate::Honoured,
            "256 logarithms of sizes; a first one of null is a mean step below the second",
        ),
        key("scales.files", Fate::Honoured, "an image of codes"),
        key(
            "quats.files",
            Fate::Honoured,
            "an image of three components of quaternions, and which is left out",
        ),
        key("sh0.codebook", Fate::Honoured, "256 constant coefficients"),
        key(
            "sh0.files",
            Fate::Honoured,
            "an image of codes and opacities",
        ),
        key(
            "shN.count",
            Fate::Honoured,
            "entries of the palette of other coefficients, 1 to 65536",
        ),
        key("shN.bands", Fate::Honoured, "their degree, 1 to 3"),
        key("shN.codebook", Fate::Honoured, "256 coefficients"),
        key(
            "shN.files",
            Fate::Honoured,
            "images of the palette and of labels",
        ),
        key("shN", Fate::Honoured, "null: none"),
        key("asset.*", Fate::Listed, "who wrote it"),
        key(
            "member *",
            Fate::Listed,
            "a file of the archive that no field names",
        ),
        key("comment of *", Fate::Listed, "of the archive"),
        key("bytes before *", Fate::Listed, "what precedes the archive"),
        key("bytes after *", Fate::Listed, "what follows the archive"),
    ],
    others: Fate::Listed,
};

/// The registry entry of the format.
pub(super) static READER: Reader = Reader {
    endings: &["sog"],
    formats: &[&FORMAT],
    read: |path, origin| raw(&whole(path)?, origin),
};

/// Reads a cloud from a ZIP file; `origin` names it in errors.
///
/// # Errors
/// The file is not SOG of version 2, a part is damaged, or the values do not form a valid cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Loaded, FileError> {
    Ok(raw(bytes, origin)?.turned(None))
}

pub(super) fn raw(bytes: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let damaged = |_| name.part("ZIP archive", "there is none, or it is cut off");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let mut unread: Vec<String> = archive.file_names().map(str::to_owned).collect();
    let cut = |_| name.part("ZIP archive", "it is cut off");
    let beside = archive::beside(&archive, Cursor::new(bytes)).map_err(cut)?;
    if let Some(twice) = beside.twice {
        return Err(name.field(format!("member `{twice}`"), "given twice", "it once"));
    }
    // Images are packed already.
    let most = bytes.len() as u64 + LONGEST_META;
    let mut raw = decode(name, |member, limit| {
        unread.retain(|own| own != member);
        let file = (archive.by_name(member))
            .map_err(|_| name.part(member, "the archive has no such member that can be read"))?;
        let limit = limit.min(most);
        let mut content = vec![];
        file.take(limit + 1)
            .read_to_end(&mut content)
            .map_err(|_| name.part(member, "it ends early, or its checksum is wrong"))?;
        if content.len() as u64 > limit {
            let field = format!("length of `{member}`");
            return Err(name.field(field, "more", format!("at most {limit} bytes")));
        }
        Ok(content)
    })?;
    for member in unread {
        raw.notes.list(format!("member {member}"));
    }
    for own in beside.keys {
        raw.notes.list(own);
    }
    Ok(raw)
}

pub(super) fn raw_folder(folder: &Path, origin: &str) -> Result<Raw, FileError> {
    decode(Origin(origin), |member, limit| {
        limited(&folder.join(member), limit)
    })
}

/// Images with one pixel a Gaussian, and the palette.
struct Images {
    low: RgbaImage,
    high: RgbaImage,
    scales: RgbaImage,
    rotations: RgbaImage,
    colours: RgbaImage,
    palette: Option<(RgbaImage, RgbaImage)>,
}

fn decode(
    name: Origin<'_>,
    mut read: impl FnMut(&str, u64) -> Result<Vec<u8>, FileError>,
) -> Result<Raw, FileError> {
    let text = read(META, LONGEST_META)?;
    let mut notes = Notes::default();
    let meta = Meta::parse(&text, &mut notes, name)?;
    let files = meta.files();
    let mut contents = vec![];
    for (field, file) in &files {
        // A name must not lead out of the folder.
        let mut parts = Path::new(file).components();
        let is_beside = matches!(
            (parts.next(), parts.next()),
            (Some(Component::Normal(_)), None)
        );
        if !is_beside || file.len() > LONGEST_NAME {
            let expected =
                format!("the name of a file beside meta.json, of at most {LONGEST_NAME} bytes");
            return Err(name.field(*field, format!("`{}`", told(file)), expected));
        }
        contents.push(read(file, LARGEST_IMAGE)?);
    }
    let total = contents.iter().map(|c| c.len() as u64).sum::<u64>() + text.len() as u64;
    if !(1..=total).contains(&(meta.count as u64)) {
        let expected = format!("1 to {total}: a byte of the files for each at the least");
        return Err(name.field("count", meta.count, expected));
    }
    let images: Vec<Result<RgbaImage, FileError>> = files
        .par_iter()
        .zip(&contents)
        .enumerate()
        .map(|(i, ((_, file), bytes))| {
            let size = (i == Meta::CENTROIDS)
                .then(|| meta.palette_size())
                .flatten();
            let wanted = ImageNeeds {
                count: meta.count,
                size,
                with_alpha: Meta::WITH_ALPHA.contains(&i),
            };
            pixels::read(bytes, file, wanted, name)
        })
        .collect();
    // The first image that is wrong is told, whichever thread was first.
    let images: Vec<RgbaImage> = images.into_iter().collect::<Result<_, _>>()?;
    for (i, (image, (_, file))) in images.iter().zip(&files).enumerate() {
        let [own, first] = [image, &images[0]].map(RgbaImage::dimensions);
        if i != Meta::CENTROIDS && own != first {
            let expected = format!("{} x {}, as of `{}`", first.0, first.1, files[0].1);
            let value = format!("{} x {}", own.0, own.1);
            return Err(name.field(format!("size of `{file}`"), value, expected));
        }
    }
    let cloud = build(&meta, Images::sort(images, name)?, name)?;
    let mut facts = Facts::of(&FORMAT).version(2);
    facts.generator = meta.generator;
    facts.bytes = total;
    if let Some(own) = &meta.harmonics {
        facts.say("entries of the palette", own.count);
    }
    Ok(Raw::new(cloud.antialiased(meta.antialiased), notes).with(facts))
}

impl Images {
    /// The images must be in the order of [`Meta::files`].
    fn sort(images: Vec<RgbaImage>, name: Origin<'_>) -> Result<Self, FileError> {
        let mut images = images.into_iter();
        let mut next = || images.next();
        let (Some(low), Some(high), Some(scales), Some(rotations), Some(colours)) =
            (next(), next(), next(), next(), next())
        else {
            return Err(name.field("number of images", "too small", "at least 5"));
        };
        Ok(Self {
            low,
            high,
            scales,
            rotations,
            colours,
            palette: next().zip(next()),
        })
    }
}

fn build(meta: &Meta, images: Images, name: Origin<'_>) -> Result<Cloud, FileError> {
    let count = meta.count;
    let [low, high, scales, rotations, colours] = [
        &images.low,
        &images.high,
        &images.scales,
        &images.rotations,
        &images.colours,
    ]
    .map(|image| image.as_chunks::<4>().0);
    if let Some(i) = rotations[..count].iter().position(|p| p[3] < 252) {
        let field = format!("Gaussian {i}: largest component of the rotation");
        return Err(name.field(field, rotations[i][3], "252 to 255"));
    }
    let palette = match (&meta.harmonics, &images.palette) {
        (Some(harmonics), Some((centroids, labels))) => {
            let labels = labels.as_chunks::<4>().0;
            let label = |i: usize| usize::from(u16::from_le_bytes([labels[i][0], labels[i][1]]));
            if let Some(i) = (0..count).find(|i| label(*i) >= harmonics.count) {
                let field = format!("Gaussian {i}: label of `shN`");
                let expected = format!("below {}, the entries of the palette", harmonics.count);
                return Err(name.field(field, label(i), expected));
            }
            Some((harmonics, centroids.as_chunks::<4>().0, labels))
        }
        _ => None,
    };
    let logits = values::logits();
    let means = |i: usize| {
        [0, 1, 2].map(|axis| {
            let code = u16::from_le_bytes([low[i][axis], high[i][axis]]);
            let fraction = f64::from(code) / 65535.0;
            let [least, most] = [meta.means.mins[axis], meta.means.maxs[axis]];
            let value = least * (1.0 - fraction) + most * fraction;
            (value.abs().exp_m1() * value.signum()) as f32
        })
    };
    Cloud::new(
        meta.degree(),
        values::each(count, means),
        values::each(count, |i| [0, 1, 2].map(|k| meta.scale(scales[i][k]))),
        values::each(count, |i| rotation(rotations[i])),
        values::each(count, |i| logits[usize::from(colours[i][3])]),
        values::coefficients(count, meta.degree(), |i, out| {
            out[0] = [0, 1, 2].map(|k| meta.constant(colours[i][k]));
            if let Some((harmonics, centroids, labels)) = &palette {
                let label = usize::from(u16::from_le_bytes([labels[i][0], labels[i][1]]));
                let each = out.len() - 1;
                // Rows are 64 entries wide, so that entries follow each other.
                let entry = &centroids[label * each..(label + 1) * each];
                for (out, pixel) in out[1..].iter_mut().zip(entry) {
                    *out = [0, 1, 2].map(|k| harmonics.codebook[usize::from(pixel[k])]);
                }
            }
        }),
    )
    .map_err(|e| name.cloud(e))
}

fn rotation(pixel: [u8; 4]) -> [f32; 4] {
    let others = [0, 1, 2].map(|k| (f64::from(pixel[k]) / 255.0 * 2.0 - 1.0) / SQRT_2);
    values::with_largest(usize::from(pixel[3] - 252), others)
}
