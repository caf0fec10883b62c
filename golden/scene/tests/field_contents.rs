//! What work is keyed by: one number of any kind of field changes it.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use glam::DVec3;
use potamoi_fields::algorithms::FIELDS;
use potamoi_fields::algorithms::efficient::EfficientNerf;
use potamoi_fields::voxels::{Grid, Layout};
use potamoi_fields::{AnyField, HashUnit};
use potamoi_scene::{Model, Scene};
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, ZipArchive};

fn fixture(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.join("../tests/fixtures").join(name)
}

/// A checkpoint, the lowest bit of the first number of its largest tensor turned if `other`.
fn checkpoint(name: &str, other: bool, to: &Path) {
    let mut archive = ZipArchive::new(File::open(fixture(name)).unwrap()).unwrap();
    let sizes: Vec<u64> = (0..archive.len())
        .map(|i| {
            let member = archive.by_index(i).unwrap();
            let is_tensor = member.name().contains("/data/");
            if is_tensor { member.size() } else { 0 }
        })
        .collect();
    let largest = (0..sizes.len()).max_by_key(|i| sizes[*i]).unwrap();
    let mut zip = ZipWriter::new(File::create(to).unwrap());
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for i in 0..archive.len() {
        let mut member = archive.by_index(i).unwrap();
        let mut bytes = vec![];
        member.read_to_end(&mut bytes).unwrap();
        if i == largest && other {
            bytes[0] ^= 1;
        }
        zip.start_file(member.name(), options).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
}

/// A snapshot, the lowest bit of its last parameter turned if `other`.
fn snapshot(unit: HashUnit, other: bool, to: &Path) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let name = match unit {
        HashUnit::Vertex => "cairn.ingp",
        HashUnit::MVoxel => "cairn-mvoxel.ingp",
    };
    let file = File::open(folder.join(name)).unwrap();
    let mut bytes = vec![];
    let mut unpacked = flate2::read::ZlibDecoder::new(file);
    unpacked.read_to_end(&mut bytes).unwrap();
    let key = b"params_binary";
    let at = bytes.windows(key.len()).position(|w| w == key).unwrap() + key.len();
    // Binary data: a mark, four bytes of its length, and the bytes.
    assert_eq!(bytes[at], 0xc6);
    let length = u32::from_be_bytes(*bytes[at + 1..].first_chunk().unwrap()) as usize;
    if other {
        bytes[at + 5 + length - 2] ^= 1;
    }
    std::fs::write(to, bytes).unwrap();
}

/// What work on a file is keyed by, of its model.
fn key_of(path: &Path) -> blake3::Hash {
    let scene = Scene::open(path.to_str().unwrap()).unwrap();
    let parts = scene.identity();
    let model = parts.iter().find(|(part, _)| *part == "model").unwrap();
    assert_eq!(model.1, scene.model().key(), "{}", path.display());
    model.1
}

/// The key of a model of an algorithm, or of one that differs from it in one number.
fn key(algorithm: &str, other: bool) -> blake3::Hash {
    let folder = tempfile::tempdir().unwrap();
    let at = |ending: &str| folder.path().join(format!("model.{ending}"));
    match algorithm {
        "stored voxels" => {
            let mut features = vec![0.5_f32; 8 * 13];
            if other {
                features[100] = 0.5_f32.next_up();
            }
            let grid = Grid::new([2; 3], DVec3::ZERO, 1.0, Layout::Linear, features);
            Model::Field(grid.unwrap().into()).key()
        }
        "EfficientNeRF" => {
            let value = if other { 0.5_f32.next_up() } else { 0.5 };
            let made = EfficientNerf::sampled([2; 3], DVec3::ZERO, 0.1, |at, to| {
                // One of the fine cells.
                let is_first = at.max_element() < 0.1;
                to[1] = if is_first { value } else { 0.25 };
                true
            });
            Model::Field(AnyField::new(made.unwrap())).key()
        }
        "DirectVoxGO" => {
            checkpoint("dvgo/tiny.tar", other, &at("tar"));
            key_of(&at("tar"))
        }
        "TensoRF" => {
            checkpoint("tensorf/tiny.th", other, &at("th"));
            key_of(&at("th"))
        }
        "Instant-NGP" => {
            snapshot(HashUnit::Vertex, other, &at("msgpack"));
            key_of(&at("msgpack"))
        }
        "Instant-NGP, hashed by MVoxel" => {
            snapshot(HashUnit::MVoxel, other, &at("msgpack"));
            key_of(&at("msgpack"))
        }
        new => panic!("{new} has no model here: make one, and another that differs in one number"),
    }
}

/// Of every algorithm that is registered.
#[test]
fn one_number_of_any_field_changes_what_work_is_keyed_by() {
    for algorithm in FIELDS {
        let name = algorithm.name;
        assert_eq!(key(name, false), key(name, false), "{name}");
        assert_ne!(key(name, false), key(name, true), "{name}");
    }
}
