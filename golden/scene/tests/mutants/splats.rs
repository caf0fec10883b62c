//! Files of Gaussians.

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use image::{ImageFormat, RgbaImage};
use potamoi_gaussians::Cloud;
use potamoi_scene::{Model, Scene};
use ruzstd::decoding::StreamingDecoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use zip::CompressionMethod;

use crate::frame::flat::{self, Kind};
use crate::frame::{Format, Rng, Verdict, npy, ply, tree, zips};
use crate::pictures::{picture, single};

/// Finite values, rotations that can be made unit ones, opacities, bounds, and a picture.
pub(crate) fn judge(path: &Path) -> Verdict {
    Verdict::of(Scene::open(&path.to_string_lossy()), |scene| {
        match scene.model() {
            Model::Splats(cloud) => gaussians(cloud)?,
            Model::Compact(model) => gaussians(&model.seen_from(scene.camera().position()))?,
            other => return Err(format!("it is {}", other.algorithm())),
        }
        picture(scene)
    })
}

fn gaussians(cloud: &Cloud) -> Result<(), String> {
    for i in 0..cloud.len() {
        let numbers = cloud.means()[i].iter().chain(&cloud.log_scales()[i]);
        if let Some(value) = numbers
            .chain(cloud.sh(i).as_flattened())
            .find(|v| !v.is_finite())
        {
            return Err(format!("Gaussian {i} has {value}"));
        }
        let square: f64 = cloud.rotations()[i]
            .iter()
            .map(|q| f64::from(*q).powi(2))
            .sum();
        let norm: f64 = cloud.rotations()[i]
            .iter()
            .map(|q| f64::from(*q) / square.sqrt())
            .map(|q| q * q)
            .sum();
        if square != 0.0 && (norm - 1.0).abs() > 1e-9 {
            return Err(format!("rotation {i} is {:?}", cloud.rotations()[i]));
        }
        let opacity = 1.0 / (1.0 + (-f64::from(cloud.opacity_logits()[i])).exp());
        if !(0.0..=1.0).contains(&opacity) {
            return Err(format!("opacity {i} is {opacity}"));
        }
    }
    let [low, high] = cloud.bounds();
    if (0..3).any(|axis| low[axis] > high[axis] || low[axis].is_nan()) {
        return Err(format!("bounds are {low:?} and {high:?}"));
    }
    Ok(())
}

/// 24 Gaussians of degree 1 about the origin.
pub(crate) fn small_ply() -> Vec<u8> {
    let mut names: Vec<String> = ["x", "y", "z", "nx", "ny", "nz"].map(str::to_owned).into();
    names.extend((0..3).map(|i| format!("f_dc_{i}")));
    names.extend((0..9).map(|i| format!("f_rest_{i}")));
    names.push("opacity".to_owned());
    names.extend((0..3).map(|i| format!("scale_{i}")));
    names.extend((0..4).map(|i| format!("rot_{i}")));
    let mut text =
        "ply\nformat binary_little_endian 1.0\ncomment small\nelement vertex 24\n".to_owned();
    names
        .iter()
        .for_each(|name| text.push_str(&format!("property float {name}\n")));
    text.push_str("end_header\n");
    let mut bytes = text.into_bytes();
    for i in 0..24 {
        let turn = i as f32 * 0.9;
        let mut values = vec![turn.cos(), turn.sin(), 0.1 * i as f32 - 1.0, 0.0, 0.0, 0.0];
        values.extend([0.5, -0.3, 0.1]);
        values.extend((0..9).map(|k| ((i + k) % 5) as f32 * 0.1 - 0.2));
        values.extend([0.7, -2.0, -2.5, -1.5, 0.9, 0.1, -0.3, 0.2]);
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

/// 24 rows of a `.splat` file.
fn small_splat() -> Vec<u8> {
    let mut bytes = vec![];
    for i in 0..24 {
        let turn = i as f32 * 0.9;
        for value in [turn.cos(), turn.sin(), 0.1 * i as f32 - 1.0, 0.1, 0.2, 0.05] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([200, 100, 50, 180, 230, 140, 100, 128]);
    }
    bytes
}

fn mutated_splat(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = small_splat();
    for _ in 0..rng.few() {
        let row = 32 * rng.below(24);
        match rng.below(5) {
            0 => flat::change(&mut bytes, rng, &[1, 4, 32]),
            1 if bytes.len() == 32 * 24 => bytes[row + 28..row + 32].fill(128),
            2 if bytes.len() == 32 * 24 => bytes[row + rng.below(8) + 24] = rng.below(256) as u8,
            _ => {
                let column = 4 * rng.below(6);
                flat::field(&mut bytes, &[(row + column, Kind::Float)], rng);
            }
        }
    }
    bytes
}

const SPZ: [&[u8]; 2] = [
    include_bytes!("../../../tests/fixtures/splats/cloud.v2.spz"),
    include_bytes!("../../../tests/fixtures/splats/cloud.v3.spz"),
];
const SPZ_4: &[u8] = include_bytes!("../../../tests/fixtures/splats/cloud.v4.spz");
/// Magic, version, Gaussians, degree, fraction bits, flags and reserved.
const SPZ_HEADER: [(usize, Kind); 7] = [
    (0, Kind::Whole(4)),
    (4, Kind::Whole(4)),
    (8, Kind::Whole(4)),
    (12, Kind::Whole(1)),
    (13, Kind::Whole(1)),
    (14, Kind::Whole(1)),
    (15, Kind::Whole(1)),
];

/// A record of an extension: kind, length and content.
fn extension(rng: &mut Rng) -> Vec<u8> {
    let kind = *rng.pick(&[0xadbe_0003u32, 0xadbe_0001, 7, u32::MAX]);
    let length = *rng.pick(&[0u32, 3, 4, 8, u32::MAX]);
    let mut bytes = [kind.to_le_bytes(), length.to_le_bytes()].concat();
    bytes.extend([rng.below(12) as u8, 0, 0, 0, 0, 0, 0, 0]);
    bytes
}

/// Versions in a gzip stream: the header, the arrays, extensions behind them.
fn mutated_spz(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = vec![];
    let packed = *rng.pick(&SPZ);
    GzDecoder::new(packed)
        .read_to_end(&mut bytes)
        .expect("a whole file");
    for _ in 0..rng.few() {
        match rng.below(7) {
            0 | 1 => flat::field(&mut bytes, &SPZ_HEADER, rng),
            2 => bytes.extend(extension(rng)),
            3 => {
                let version = rng.below(6) as u8;
                bytes[4] = version;
            }
            4 => flat::change(&mut bytes, rng, &[1, 3, 9]),
            _ => {
                let at = 16 + rng.below(bytes.len().saturating_sub(16).max(1));
                flat::field(
                    &mut bytes,
                    &[(at, Kind::Whole(1)), (at, Kind::Whole(4))],
                    rng,
                );
            }
        }
    }
    if rng.one_in(25) {
        return bytes;
    }
    let mut out = GzEncoder::new(vec![], Compression::fast());
    out.write_all(&bytes).expect("memory takes it");
    let mut out = out.finish().expect("memory takes it");
    if rng.one_in(25) {
        rng.damage(&mut out);
    }
    out
}

/// Version 4: header, extensions, a table, and ZSTD streams.
fn mutated_spz_4(rng: &mut Rng) -> Vec<u8> {
    let streams = usize::from(SPZ_4[15]);
    let mut header = SPZ_4[..32].to_vec();
    let word = |at: usize| {
        let mut all = [0; 8];
        all.copy_from_slice(&SPZ_4[at..at + 8]);
        u64::from_le_bytes(all) as usize
    };
    let mut at = 32 + 16 * streams;
    let mut parts: Vec<Vec<u8>> = vec![];
    for i in 0..streams {
        let length = word(32 + 16 * i);
        let mut part = vec![];
        let mut reader = StreamingDecoder::new(&SPZ_4[at..at + length]).expect("a stream");
        reader.read_to_end(&mut part).expect("its bytes");
        parts.push(part);
        at += length;
    }
    let mut extensions = vec![];
    for _ in 0..rng.few() {
        let part = rng.below(parts.len().max(1));
        match rng.below(8) {
            0 | 1 => flat::field(&mut header, &SPZ_HEADER, rng),
            2 | 3 => extensions.extend(extension(rng)),
            4 if !parts.is_empty() => flat::change(&mut parts[part], rng, &[1, 3, 4]),
            5 if !parts.is_empty() => drop(parts.remove(part)),
            _ if !parts.is_empty() => flat::number(&mut parts[part], Kind::Whole(1), rng),
            _ => {}
        }
    }
    let place = (32 + extensions.len()) as u32;
    header[16..20].copy_from_slice(&place.to_le_bytes());
    if rng.one_in(15) {
        flat::field(
            &mut header,
            &[(16, Kind::Whole(4)), (20, Kind::Whole(4))],
            rng,
        );
    }
    let mut out = [header, extensions].concat();
    let packed: Vec<Vec<u8>> = parts
        .iter()
        .map(|p| compress_to_vec(p.as_slice(), CompressionLevel::Fastest))
        .collect();
    let table = out.len();
    for (part, packed) in parts.iter().zip(&packed) {
        out.extend((packed.len() as u64).to_le_bytes());
        out.extend((part.len() as u64).to_le_bytes());
    }
    if rng.one_in(10) && !parts.is_empty() {
        let at = table + 8 * rng.below(2 * parts.len());
        flat::field(&mut out, &[(at, Kind::Whole(8))], rng);
    }
    out.extend(packed.concat());
    if rng.one_in(25) {
        rng.damage(&mut out);
    }
    out
}

pub(crate) const SOG: &[u8] = include_bytes!("../../../tests/fixtures/splats/cloud.sog");

/// The members of a SOG file, `meta.json` or one of the pictures changed.
fn mutated_sog(rng: &mut Rng) -> Vec<(String, Vec<u8>)> {
    let mut members = zips::members(SOG);
    match rng.below(8) {
        0 => zips::mutate(&mut members, rng),
        1 | 2 => {
            let at = rng.below(members.len());
            if members[at].0 != "meta.json" {
                members[at].1 = mutated_webp(&members[at].1, rng);
            }
        }
        _ => {
            let meta = members.iter_mut().find(|(name, _)| name == "meta.json");
            let meta = &mut meta.expect("a meta.json").1;
            *meta = tree::json(meta, rng);
        }
    }
    members
}

fn mutated_webp(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut picture = image::load_from_memory(bytes)
        .expect("a picture")
        .into_rgba8();
    let (width, height) = picture.dimensions();
    match rng.below(5) {
        0 => picture = RgbaImage::new(width + 1, height),
        1 => picture = RgbaImage::new(width, height.saturating_sub(1).max(1)),
        2 => picture.fill(255),
        _ => {
            let at = rng.below(picture.len());
            picture.as_mut()[at] = *rng.pick(&[0, 1, 127, 128, 251, 252, 255]);
        }
    }
    let mut out = std::io::Cursor::new(vec![]);
    picture
        .write_to(&mut out, ImageFormat::WebP)
        .expect("memory takes it");
    let mut out = out.into_inner();
    if rng.one_in(6) {
        rng.damage(&mut out);
    }
    out
}

fn sog_of(members: Vec<(String, Vec<u8>)>) -> Vec<(String, Vec<u8>)> {
    single("a.sog", zips::packed(&members, CompressionMethod::Stored))
}

/// A folder, `meta.json` first. Names that lead elsewhere stay where they are.
fn folder_of(members: Vec<(String, Vec<u8>)>) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = members
        .into_iter()
        .filter(|(name, _)| !name.contains('/') && name.len() < 200 && !name.contains('\0'))
        .collect();
    let meta = files.iter().position(|(name, _)| name == "meta.json");
    let meta = meta.map(|at| files.remove(at));
    files.insert(0, meta.unwrap_or_else(|| ("meta.json".to_owned(), vec![])));
    files
}

const COMPACT: &[u8] = include_bytes!("../../../tests/fixtures/compact/tiny.npz");

fn mutated_compact(rng: &mut Rng) -> Vec<u8> {
    let mut members = zips::members(COMPACT);
    for _ in 0..rng.few() {
        if rng.one_in(6) {
            zips::mutate(&mut members, rng);
        } else {
            let at = rng.below(members.len());
            npy::mutate(&mut members[at].1, rng);
        }
    }
    zips::packed(&members, CompressionMethod::Stored)
}

const PACKED: &[u8] = include_bytes!("../../../tests/fixtures/splats/cloud.compressed.ply");

pub(crate) fn formats() -> Vec<Format> {
    let one = |name,
               file: &'static str,
               whole: fn() -> Vec<u8>,
               mutant: fn(&mut Rng) -> Vec<u8>| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(move || single(file, whole())),
        mutant: Arc::new(move |rng| single(file, mutant(rng))),
        judge,
    };
    vec![
        one("ply", "a.ply", small_ply, |rng| {
            ply::mutate(&small_ply(), rng)
        }),
        one(
            "packed_ply",
            "a.compressed.ply",
            || PACKED.to_vec(),
            |rng| ply::mutate(PACKED, rng),
        ),
        one("splat", "a.splat", small_splat, mutated_splat),
        one("spz", "a.spz", || SPZ[0].to_vec(), mutated_spz),
        one("spz_4", "a.spz", || SPZ_4.to_vec(), mutated_spz_4),
        one("compact", "a.npz", || COMPACT.to_vec(), mutated_compact),
        Format {
            name: "sog",
            binary: super::BINARY,
            whole: Arc::new(|| single("a.sog", SOG.to_vec())),
            mutant: Arc::new(|rng| sog_of(mutated_sog(rng))),
            judge,
        },
        Format {
            name: "sog_folder",
            binary: super::BINARY,
            whole: Arc::new(|| folder_of(zips::members(SOG))),
            mutant: Arc::new(|rng| folder_of(mutated_sog(rng))),
            judge: |path| judge(path.parent().expect("a folder")),
        },
    ]
}
