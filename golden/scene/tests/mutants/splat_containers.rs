//! Files of Gaussians whose headers point into their bytes, and those that name other files.

use std::sync::Arc;

use crate::frame::flat::{self, Kind};
use crate::frame::{Files, Format, Rng, tree};
use crate::pictures::single;
use crate::splats::{SOG, judge};

const KSPLAT: [&[u8]; 3] = [
    include_bytes!("../../../tests/fixtures/splats/cloud.0.ksplat"),
    include_bytes!("../../../tests/fixtures/splats/cloud.1.ksplat"),
    include_bytes!("../../../tests/fixtures/splats/cloud.2.ksplat"),
];
/// Bytes of the header, and of that of a section.
const HEADER: usize = 4096;
const SECTION: usize = 1024;

/// Fields of the header.
const FIELDS: [(usize, Kind); 10] = [
    (0, Kind::Whole(1)),
    (1, Kind::Whole(1)),
    (4, Kind::Whole(4)),
    (8, Kind::Whole(4)),
    (12, Kind::Whole(4)),
    (16, Kind::Whole(4)),
    (20, Kind::Whole(2)),
    (24, Kind::Float),
    (36, Kind::Float),
    (40, Kind::Float),
];
/// Fields of a section's header, from its beginning.
const OF_SECTION: [(usize, Kind); 11] = [
    (0, Kind::Whole(4)),
    (4, Kind::Whole(4)),
    (8, Kind::Whole(4)),
    (12, Kind::Whole(4)),
    (16, Kind::Float),
    (20, Kind::Whole(2)),
    (24, Kind::Whole(4)),
    (28, Kind::Whole(4)),
    (32, Kind::Whole(4)),
    (36, Kind::Whole(4)),
    (40, Kind::Whole(2)),
];

/// A header, sections' headers, buckets and rows.
fn mutated_ksplat(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = rng.pick(&KSPLAT).to_vec();
    let data = HEADER + SECTION * usize::from(bytes[4]);
    for _ in 0..rng.few() {
        match rng.below(8) {
            0 | 1 => flat::field(&mut bytes, &FIELDS, rng),
            2 | 3 => {
                let at = HEADER + SECTION * rng.below(2);
                let all = OF_SECTION.map(|(own, kind)| (at + own, kind));
                flat::field(&mut bytes, &all, rng);
            }
            4 if bytes.len() > data => {
                let mut rest = bytes.split_off(data);
                flat::change(&mut rest, rng, &[4, 12, 24, 72, 140]);
                bytes.extend(rest);
            }
            5 => bytes[20] = rng.below(4) as u8,
            _ => {
                let at = data + 2 * rng.below(bytes.len().saturating_sub(data).max(2) / 2);
                let kinds = [Kind::Float, Kind::Half, Kind::Whole(4), Kind::Whole(1)];
                flat::field(&mut bytes, &kinds.map(|kind| (at, kind)), rng);
            }
        }
    }
    if rng.one_in(25) {
        rng.damage(&mut bytes);
    }
    bytes
}

const GLB: &[u8] = include_bytes!("../../../tests/fixtures/splats/few.glb");
const SPZ: &[u8] = include_bytes!("../../../tests/fixtures/splats/cloud.v3.spz");

/// The JSON and the buffer of a `.glb`.
fn split(bytes: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[12..16]);
    let length = u32::from_le_bytes(word) as usize;
    (
        bytes[20..20 + length].to_vec(),
        bytes[28 + length..].to_vec(),
    )
}

/// A `.glb` of them.
fn joined(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 28 + json.len() + binary.len();
    let words = [2, length as u32, json.len() as u32].map(u32::to_le_bytes);
    let mut all = [b"glTF", words.concat().as_slice(), b"JSON", &json].concat();
    all.extend((binary.len() as u32).to_le_bytes());
    all.extend(b"BIN\0");
    all.extend(binary);
    all
}

/// The JSON of a `.glb` with an SPZ file.
fn with_spz() -> Vec<u8> {
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {0}}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {0}}}],
        "accessors": [{{"componentType": 5126, "count": 300, "type": "VEC3"}}],
        "meshes": [{{"primitives": [{{"mode": 0, "attributes": {{"POSITION": 0}}, "extensions":
        {{"KHR_gaussian_splatting": {{"kernel": "ellipse", "extensions":
        {{"KHR_gaussian_splatting_compression_spz_2": {{"bufferView": 0}}}}}}}}}}]}}],
        "nodes": [{{"mesh": 0, "translation": [1, 2, 3], "scale": [2, 2, 2]}}], "scenes": [{{"nodes": [0]}}]}}"#,
        SPZ.len()
    );
    text.into_bytes()
}

/// The JSON, numbers of the buffer, or the chunks' headers changed.
fn mutated_glb(rng: &mut Rng) -> Vec<u8> {
    let (mut json, mut binary) = match rng.below(3) {
        0 => (with_spz(), SPZ.to_vec()),
        _ => split(GLB),
    };
    match rng.below(6) {
        0 => flat::number(&mut binary, Kind::Float, rng),
        1 => flat::change(&mut binary, rng, &[1, 4, 12]),
        _ => json = tree::json(&json, rng),
    }
    let mut bytes = joined(&json, &binary);
    if rng.one_in(12) {
        let heads = [0, 4, 8, 12, 16, 20 + json.len().next_multiple_of(4)];
        flat::field(&mut bytes, &heads.map(|at| (at, Kind::Whole(4))), rng);
    }
    if rng.one_in(25) {
        rng.damage(&mut bytes);
    }
    bytes
}

/// A `.gltf` beside its buffer.
fn gltf(json: Vec<u8>, binary: Vec<u8>) -> Files {
    vec![("a.gltf".to_owned(), json), ("a.bin".to_owned(), binary)]
}

/// The JSON of a `.gltf` with a buffer in a file.
fn small_gltf() -> (Vec<u8>, Vec<u8>) {
    let (json, binary) = split(GLB);
    let text = String::from_utf8(json).expect("text");
    let named = text.replacen("\"buffers\":[{", "\"buffers\":[{\"uri\":\"a.bin\",", 1);
    (named.into_bytes(), binary)
}

const LEVELS: &str = r#"{"version": 1, "count": 300, "counts": [200, 100], "lodLevels": 2,
    "environment": null, "filenames": ["a.sog", "b.sog"], "tree": {"bound": {"min": [0, 0, 0]},
    "children": [{"lods": {"0": {"file": 0, "offset": 0, "count": 50}}},
    {"lods": {"0": {"file": 0, "offset": 50, "count": 150}, "1": {"file": 1, "offset": 0, "count": 100}}}]}}"#;

fn levels(meta: Vec<u8>) -> Files {
    let own = |name: &str, bytes: Vec<u8>| (name.to_owned(), bytes);
    vec![
        own("lod-meta.json", meta),
        own("a.sog", SOG.to_vec()),
        own("b.sog", SOG.to_vec()),
    ]
}

pub(crate) fn formats() -> Vec<Format> {
    let format = |name, whole: fn() -> Files, mutant: fn(&mut Rng) -> Files| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(whole),
        mutant: Arc::new(mutant),
        judge,
    };
    vec![
        format(
            "ksplat",
            || single("a.ksplat", KSPLAT[1].to_vec()),
            |rng| single("a.ksplat", mutated_ksplat(rng)),
        ),
        format(
            "glb",
            || single("a.glb", GLB.to_vec()),
            |rng| single("a.glb", mutated_glb(rng)),
        ),
        format(
            "gltf",
            || {
                let (json, binary) = small_gltf();
                gltf(json, binary)
            },
            |rng| {
                let (json, mut binary) = small_gltf();
                if rng.one_in(4) {
                    flat::change(&mut binary, rng, &[1, 4, 12]);
                }
                gltf(tree::json(&json, rng), binary)
            },
        ),
        format(
            "sog_levels",
            || levels(LEVELS.as_bytes().to_vec()),
            |rng| levels(tree::json(LEVELS.as_bytes(), rng)),
        ),
    ]
}
