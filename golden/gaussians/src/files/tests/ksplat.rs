//! KSplat, by GaussianSplats3D's own writer, and damaged.

use super::near::{Near, check, first, of_degree};
use super::refuse::refused;
use super::*;

/// Colours and opacities are cut to bytes by the writer; half floats are cut to 11 bits.
const LEVEL_0: Near = Near {
    mean: 0.0,
    size: 0.0,
    rotation: 0.0,
    opacity: 1.0 / 255.0,
    constant: 1.0 / 255.0 / sh::CONSTANT as f32,
    rest: 0.0,
};

#[test]
fn every_level_is_what_its_writer_packed() {
    for (level, count, sections) in [(0u16, 60, 2), (1, 120, 1), (2, 120, 2)] {
        let bytes = fixture(&format!("cloud.{level}.ksplat"));
        let loaded = super::super::ksplat::parse(&bytes, "f").unwrap();
        let near = match level {
            0 => LEVEL_0,
            // Buckets have an edge of 2 and 65,535 codes.
            1 => Near {
                mean: 1.0 / 32767.0,
                size: 1.0 / 1024.0,
                rotation: 1.0 / 1024.0,
                rest: 1.0 / 2048.0,
                ..LEVEL_0
            },
            // Bytes over -0.5 to 0.5, cut.
            _ => Near {
                mean: 1.0 / 32767.0,
                size: 1.0 / 1024.0,
                rotation: 1.0 / 1024.0,
                rest: 1.0 / 255.0,
                ..LEVEL_0
            },
        };
        check(&loaded.cloud, &of_degree(&first(count), 2), &near);
        assert_eq!(loaded.facts.version.as_deref(), Some("0.1"));
        let said = |name: &str| {
            loaded
                .facts
                .more
                .iter()
                .find(|(own, _)| own == name)
                .cloned()
                .unwrap()
                .1
        };
        assert_eq!(said("compression level"), level.to_string());
        assert_eq!(said("sections"), sections.to_string());
        assert!(loaded.notes.not_used().is_empty());
        assert_eq!(loaded.notes.assumed(), ["axes right-down-front"]);
    }
}

/// A file as a streaming viewer keeps it: sections with room for more than is written.
#[test]
fn room_and_reserved_bytes_are_listed() {
    let mut bytes = fixture("cloud.0.ksplat");
    bytes[24] = 1;
    bytes[60] = 1;
    // The last row of the second section, of 20, and the sums of both.
    bytes[4096 + 1024] = 19;
    bytes[16] = 59;
    bytes.push(0);
    let loaded = super::super::ksplat::parse(&bytes, "f").unwrap();
    assert_eq!(loaded.cloud.len(), 59);
    let listed = [
        "scene centre",
        "reserved bytes of the header",
        "section 1: room for 1 more",
        "bytes after the sections (1)",
    ];
    assert_eq!(loaded.notes.not_used(), listed);
}

/// Counts that other writers leave at 0.
#[test]
fn counts_of_0_are_not_stated() {
    let mut bytes = fixture("cloud.0.ksplat");
    bytes[8..16].fill(0);
    let own = ksplat_cloud(&bytes, "f").unwrap();
    assert_eq!(own, ksplat_cloud(&fixture("cloud.0.ksplat"), "f").unwrap());
}

#[test]
fn a_size_of_0_is_told() {
    let mut bytes = fixture("cloud.0.ksplat");
    let row = 4096 + 2 * 1024;
    bytes[row + 12..row + 24].fill(0);
    let loaded = super::super::ksplat::parse(&bytes, "f").unwrap();
    assert_eq!(loaded.cloud.log_scales()[0], [f32::MIN_POSITIVE.ln(); 3]);
    assert_eq!(loaded.facts.clamped[0].1, 3);
}

#[test]
fn each_defect_is_told() {
    let set = |level: u16, at: usize, value: &[u8]| {
        let mut bytes = fixture(&format!("cloud.{level}.ksplat"));
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    let word = u32::to_le_bytes;
    let section = 4096;
    for (bytes, expected) in [
        (set(0, 0, &[1]), "version is 1.1: expected 0.1"),
        (set(0, 1, &[2]), "version is 0.2"),
        (set(0, 4, &word(0)), "number of sections is 0"),
        (
            set(0, 4, &word(u32::MAX)),
            "number of sections is 4294967295",
        ),
        (set(0, 8, &word(3)), "number of written sections is 3"),
        (
            set(0, 8, &word(1)),
            "section 1: number of Gaussians is 20: expected 0",
        ),
        (set(0, 16, &word(0)), "number of Gaussians is 0"),
        (set(0, 16, &word(59)), "of all sections is 60: expected 59"),
        (set(0, 20, &[3, 0]), "compression level is 3"),
        (
            set(2, 36, &f32::NAN.to_le_bytes()),
            "range of coefficients is NaN",
        ),
        (
            set(2, 36, &2f32.to_le_bytes()),
            "range of coefficients is 2 to",
        ),
        (
            set(1, section, &word(121)),
            "section 0: number of Gaussians is 121: expected at most 120",
        ),
        (
            set(1, section + 4, &word(u32::MAX)),
            "section 0: bytes that are left",
        ),
        (
            set(1, section + 8, &word(0)),
            "section 0: buckets is 19 (11 of them full), which hold 32",
        ),
        (set(1, section + 12, &word(18)), "section 0: bytes is"),
        (
            set(1, section + 16, &f32::NAN.to_le_bytes()),
            "edge of a bucket is NaN",
        ),
        (
            set(1, section + 20, &[13]),
            "bytes of a bucket is 13: expected 12",
        ),
        (
            set(1, section + 24, &word(70000)),
            "range of centres is 70000",
        ),
        (
            set(1, section + 32, &word(12)),
            "buckets is 19 (12 of them full)",
        ),
        (
            set(1, section + 40, &[3]),
            "section 0: degree is 3: expected 0 to 2",
        ),
        (
            set(0, section + 2048 + 12, &(-1f32).to_le_bytes()),
            "Gaussian 0: scale[0] is -1",
        ),
        (
            set(0, section + 2048, &f32::NAN.to_le_bytes()),
            "Gaussian 0: mean[0] is NaN",
        ),
        (
            fixture("cloud.0.ksplat")[..4096].to_vec(),
            "number of sections is 2: expected fewer, or a whole file: their headers end at byte 6144, and the \
             file has 4096 bytes; it is cut off or damaged",
        ),
        (
            fixture("cloud.0.ksplat")[..4000].to_vec(),
            "length in bytes is 4000",
        ),
        (
            fixture("cloud.0.ksplat")[..9000].to_vec(),
            "section 0: bytes that are left",
        ),
    ] {
        refused(ksplat_cloud, &bytes, expected);
    }
}
