//! A model that other programs wrote, and damaged ones.
#![allow(clippy::unwrap_used, clippy::panic)]

mod pack;

use std::path::PathBuf;

use half::f16;
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::Value;

use super::*;
use pack::{archive, members};
use potamoi_base::sh;
use potamoi_gaussians::{rotation, sigmoid};

fn parse(bytes: &[u8], origin: &str) -> Result<Compact, FileError> {
    Compact::parse(bytes, origin, None).map(|(model, _)| model)
}

/// A file of `golden/tests/fixtures/compact`, which `tools/compact-fixtures`
/// makes.
fn fixture(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/compact");
    std::fs::read(PathBuf::from(folder).join(name)).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Covariances to the rounding of a log scale to 32 bits (2^-24 of up to 8,
/// doubled by the square, so 1e-6 of the largest), twice that for quaternions;
/// colours to that of a coefficient (2^-24 of up to 4) and of the levels'
/// scales, which are found in 32 bits: a unit in the last place of 4096 moves a
/// place by 2.4e-4 vertices, and features by that times their range, below 0.3.
#[test]
fn the_fixture_is_what_numpy_says() {
    let model = parse(&fixture("tiny.npz"), "tiny.npz").unwrap();
    let expected: Value = serde_json::from_slice(&fixture("tiny.json")).unwrap();
    let cloud = model.gaussians();
    let covariances = expected["covariances"].as_array().unwrap();
    let opacities = numbers(&expected["opacities"]);
    assert_eq!([cloud.len(), covariances.len()], [72, 72]);
    assert_eq!(model.colour().shape().log2_entries, 12);
    let hashed = model.colour().tables().iter().map(|t| t.is_hashed());
    assert_eq!(hashed.filter(|h| !h).count(), 1, "both kinds of level");
    let mut worst = [0.0f64; 3];
    for i in 0..cloud.len() {
        let scale = cloud.log_scales()[i].map(|s| f64::from(s).exp());
        let axes = rotation(cloud.rotations()[i]) * glam::DMat3::from_diagonal(scale.into());
        let found = (axes * axes.transpose()).to_cols_array();
        let wanted = numbers(&covariances[i]);
        let size = wanted[0] + wanted[4] + wanted[8];
        for (a, b) in found.iter().zip(&wanted) {
            worst[0] = worst[0].max((a - b).abs() / size);
        }
        let opacity = sigmoid(f64::from(cloud.opacity_logits()[i]));
        worst[1] = worst[1].max((opacity - opacities[i]).abs());
    }
    for view in expected["views"].as_array().unwrap() {
        let eye: [f64; 3] = numbers(&view["eye"]).try_into().unwrap();
        let seen = model.seen_from(eye.into());
        for (i, wanted) in view["colours"].as_array().unwrap().iter().enumerate() {
            let found = sh::colour(seen.sh(i), DVec3::ZERO).to_array();
            for (a, b) in found.iter().zip(numbers(wanted)) {
                worst[2] = worst[2].max((a - b).abs());
            }
        }
    }
    println!(
        "covariance {:.1e}, opacity {:.1e}, colour {:.1e}",
        worst[0], worst[1], worst[2]
    );
    assert!(
        worst[0] < 2e-6 && worst[1] < 1e-6 && worst[2] < 1e-4,
        "{worst:?}"
    );
}

/// An array's member as NumPy writes it.
fn npy(kind: &str, shape: &str, bytes: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (text.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), bytes].concat()
}

/// The fixture with some arrays replaced, or left out where they are empty.
fn with(changes: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut all = members(&fixture("tiny.npz"));
    for (name, bytes) in changes {
        let name = format!("{name}.npy");
        all.retain(|(n, _)| *n != name);
        if !bytes.is_empty() {
            all.push((name, bytes.clone()));
        }
    }
    archive(&all)
}

fn halves(values: &[f32]) -> Vec<u8> {
    let words = values.iter().map(|v| f16::from_f32(*v).to_le_bytes());
    words.flatten().collect()
}

fn integers(values: &[i64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// One Gaussian of two stages of one bit: codes 1 and 0 of the scales, 0 and 1
/// of the rotations.
fn by_hand() -> Vec<(&'static str, Vec<u8>)> {
    let book = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<_>>()
    };
    let scales = [9.0, 9.0, 9.0, 0.5, 1.0, 2.0, 0.0, 1.0, 2.0, 9.0, 9.0, 9.0];
    let mut rotations = [9.0; 16];
    rotations[..4].copy_from_slice(&[0.5, 0.0, 0.0, 0.0]);
    rotations[12..].copy_from_slice(&[0.5, 0.0, 0.0, 0.0]);
    vec![
        ("xyz", npy("<f2", "(1, 3)", &halves(&[1.0, 2.0, -0.5]))),
        ("opacity", npy("<f2", "(1, 1)", &halves(&[0.5]))),
        ("scale", npy("|u1", "(1,)", &[0b1000_0000])),
        ("rotation", npy("|u1", "(1,)", &[0b0100_0000])),
        ("codebook_scale", npy("<f4", "(2, 2, 3)", &book(&scales))),
        (
            "codebook_rotation",
            npy("<f4", "(2, 2, 4)", &book(&rotations)),
        ),
        ("rvq_info", npy("<i8", "(2,)", &integers(&[2, 1]))),
    ]
}

#[test]
fn codes_are_summed_over_stages() {
    let model = parse(&with(&by_hand()), "f").unwrap();
    let cloud = model.gaussians();
    assert_eq!(cloud.means(), [[1.0, 2.0, -0.5]]);
    assert_eq!(cloud.rotations(), [[1.0, 0.0, 0.0, 0.0]]);
    assert_eq!(cloud.opacity_logits(), [0.0]);
    let expected = [0.5f64, 2.0, 4.0].map(|s| s.ln() as f32);
    assert_eq!(cloud.log_scales(), [expected]);
}

#[test]
fn what_is_wrong_is_named() {
    let refuse = |changes: &[(&'static str, Vec<u8>)], expected: &str| {
        let mut all = by_hand();
        all.extend_from_slice(changes);
        let error = parse(&with(&all), "f.npz").unwrap_err().to_string();
        assert!(
            error.starts_with("f.npz: ") && error.contains(expected),
            "{error}"
        );
        assert!(!error.contains('\n'), "{error}");
    };
    let empty = vec![];
    refuse(
        &[("xyz", empty.clone())],
        "array `xyz` is missing from codebook_",
    );
    refuse(&[("mlp", empty)], "expected xyz, opacity,");
    let table = npy("|O", "()", b"\x80\x02}.");
    refuse(
        &[("huftable_hash", table)],
        "`huftable_hash` cannot be honoured: Huffman codes of the post-",
    );
    let more = npy("<f2", "(1,)", &halves(&[0.5]));
    refuse(&[("mlp_2", more)], "`mlp_2` is out of sequence");
    for (array, kind, shape, bytes, expected) in [
        (
            "xyz",
            "<f2",
            "(0, 3)",
            vec![],
            "shape of array `xyz` is [0, 3]",
        ),
        ("xyz", "<f2", "(3,)", vec![0; 6], "(Gaussians, 3)"),
        (
            "xyz",
            "<f4",
            "(1, 3)",
            vec![0; 12],
            "type of array `xyz` is <f4: expected <f2",
        ),
        (
            "xyz",
            "<f2",
            "(9, 3)",
            vec![0; 6],
            "with 6 bytes: expected 54",
        ),
        (
            "xyz",
            "<f2",
            "(1, 3)",
            halves(&[0.0, f32::NAN, 0.0]),
            "element 1 of array `xyz`",
        ),
        ("xyz", "|O", "(1, 3)", vec![], "type of array `xyz`"),
        (
            "opacity",
            "<f2",
            "(2, 1)",
            vec![0; 4],
            "(1, 1), one a Gaussian",
        ),
        (
            "opacity",
            "<f2",
            "(1, 1)",
            halves(&[1.5]),
            "is 1.5: expected 0 to 1",
        ),
        (
            "scale",
            "|u1",
            "(2,)",
            vec![0; 2],
            "(1,): 1 Gaussians, 2 codes of 1 bits",
        ),
        ("scale", "|u1", "(1, 1)", vec![0], "shape of array `scale`"),
        (
            "rvq_info",
            "<i8",
            "(2,)",
            integers(&[2, 9]),
            "is [2, 9]: expected two",
        ),
        (
            "rvq_info",
            "<i8",
            "(2,)",
            integers(&[-1, 1]),
            "1 to 32 stages",
        ),
        (
            "rvq_info",
            "<i8",
            "(2,)",
            integers(&[i64::MAX, 1]),
            "1 to 32 stages",
        ),
        ("rvq_info", "<i4", "(3,)", vec![0; 12], "is [0, 0, 0]"),
        (
            "codebook_scale",
            "<f4",
            "(1, 4, 3)",
            vec![0; 48],
            "(2, 2, 3)",
        ),
        (
            "codebook_scale",
            "|O",
            "()",
            b"\x80\x02K\x01.".to_vec(),
            "an integer instead of",
        ),
        (
            "codebook_scale",
            "|O",
            "()",
            b"\x80\x02cos\nsystem\n.".to_vec(),
            "os.system",
        ),
        ("hash", "<f2", "(7,)", vec![0; 14], "`hash` is 7 parameters"),
        ("mlp", "<f2", "(7,)", vec![0; 14], "`mlp` is 7 parameters"),
    ] {
        refuse(&[(array, npy(kind, shape, &bytes))], expected);
    }
    let mut columns = npy("<f2", "(1, 3)", &[0; 6]);
    let at = columns.windows(5).position(|w| w == b"False").unwrap();
    columns.splice(at..at + 5, *b"True");
    columns[8] -= 1;
    refuse(&[("xyz", columns)], "rows first");
    refuse(&[("xyz", b"no array".to_vec())], "no array of NumPy");
    refuse(
        &[("xyz", npy("<f2", "(1, -3)", &[]))],
        "a side that is no number",
    );
    refuse(
        &[("xyz", b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec())],
        "a header of 4294967295",
    );
    refuse(&[("xyz", b"\x93NUMPY\x09\x00".to_vec())], "version 9");
    let huge = format!("({}, {}, {})", usize::MAX, usize::MAX, usize::MAX);
    refuse(&[("xyz", npy("<f2", &huge, &[]))], "shape of array `xyz`");
}

/// A trace has arrays too, but not these.
#[test]
fn other_archives_are_refused_by_what_they_lack() {
    let trace = archive(&[("header.npy".to_owned(), npy("|u1", "(0,)", &[]))]);
    let error = parse(&trace, "t.npz").unwrap_err().to_string();
    assert!(
        error.contains("array `xyz` is missing from header"),
        "{error}"
    );
    let error = parse(b"no archive", "t.npz").unwrap_err().to_string();
    assert!(error.starts_with("t.npz: ZIP archive: "), "{error}");
}

/// A few bytes that unpack to many are not unpacked.
#[test]
fn a_member_far_larger_than_the_file_is_refused() {
    let large = archive(&[("xyz.npy".to_owned(), vec![0; 1 << 26])]);
    assert!(large.len() < 1 << 17);
    let name = Origin("f");
    let mut npz = Npz::open(&large, name).unwrap();
    let error = npz.array("xyz").err().unwrap().to_string();
    assert!(error.contains("64 times the file"), "{error}");
}

/// Checks that a model is valid.
fn sane(read: Result<Compact, FileError>) {
    match read {
        Ok(model) => {
            let seen = model.seen_from(DVec3::new(0.1, -3.0, 2.0));
            assert!(seen.len() <= 1 << 16);
            let colours = (0..seen.len()).flat_map(|i| seen.sh(i)).flatten();
            assert!(colours.copied().all(f32::is_finite));
        }
        Err(e) => assert!(e.to_string().starts_with("f: "), "{e}"),
    }
}

fn damage() -> impl Strategy<Value = (Vec<(Index, u8)>, Option<Index>)> {
    let writes = proptest::collection::vec((any::<Index>(), any::<u8>()), 1..6);
    (writes, proptest::option::weighted(0.3, any::<Index>()))
}

fn apply(bytes: &mut Vec<u8>, within: usize, damage: &(Vec<(Index, u8)>, Option<Index>)) {
    let within = within.min(bytes.len());
    for (at, byte) in &damage.0 {
        bytes[at.index(within)] = *byte;
    }
    if let Some(cut) = &damage.1 {
        bytes.truncate(cut.index(bytes.len()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn damage_anywhere(damage in damage()) {
        let mut bytes = fixture("tiny.npz");
        apply(&mut bytes, usize::MAX, &damage);
        sane(parse(&bytes, "f"));
    }

    #[test]
    fn damage_inside_an_array(damage in damage(), member in any::<Index>(), header in any::<bool>()) {
        let mut members = members(&fixture("tiny.npz"));
        let member = member.index(members.len());
        apply(&mut members[member].1, if header { 120 } else { usize::MAX }, &damage);
        sane(parse(&archive(&members), "f"));
    }

    #[test]
    fn damage_inside_a_small_model(damage in damage(), which in any::<Index>()) {
        let mut changes = by_hand();
        let which = which.index(changes.len());
        apply(&mut changes[which].1, usize::MAX, &damage);
        sane(parse(&with(&changes), "f"));
    }

    #[test]
    fn any_header(kind in "[<|>][uif][1248]|.{0,8}", shape in "[(][0-9, -]{0,40}[)]", which in any::<Index>()) {
        let mut changes = by_hand();
        let which = which.index(changes.len());
        changes[which].1 = npy(&kind, &shape, &[0; 96]);
        sane(parse(&with(&changes), "f"));
    }
}
