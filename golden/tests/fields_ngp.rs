//! Instant-NGP snapshots against an independent writer and renderer,
//! tools/ngp-fixtures.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use potamoi_golden::fields::ngp::Ngp;
use potamoi_golden::fields::Field as _;


use serde::Deserialize;

#[derive(Deserialize)]
struct Expected {
    hashed: Vec<bool>,
    points: Vec<Point>,
}

#[derive(Deserialize)]
struct Point {
    at: [f64; 3],
    direction: [f64; 3],
    occupied: bool,
    density: f64,
    colour: [f64; 3],
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures/ngp")
        .join(name)
}

fn expanded() -> Vec<u8> {
    let bytes = std::fs::read(fixture("cube.ingp")).unwrap();
    let mut out = vec![];
    let mut reader = flate2::read::ZlibDecoder::new(&bytes[..]);
    reader.read_to_end(&mut out).unwrap();
    out
}

/// Densities and colours of both snapshots within 1e-5 of the reference, and
/// the same cells occupied.
#[test]
fn densities_and_colours_are_those_of_an_independent_renderer() {
    for name in ["cube", "cascades"] {
        let field = Ngp::load(&fixture(&format!("{name}.ingp"))).unwrap();
        let expected = std::fs::read(fixture(&format!("{name}.json"))).unwrap();
        let expected: Expected = serde_json::from_slice(&expected).unwrap();
        let hashed: Vec<_> = field.tables().iter().map(|t| t.is_hashed()).collect();
        assert_eq!(hashed, expected.hashed, "{name}");
        let streams = (0..field.shape().levels).map(|l| !field.shape().streams(l));
        assert!(streams.eq(hashed));
        let mut places = vec![DVec3::ZERO; field.tables().len()];
        let (mut occupied, mut farthest) = (0, 0f64);
        for point in &expected.points {
            let holds = field.index(point.at.into(), &mut places);
            assert_eq!(holds, point.occupied, "{name} {:?}", point.at);
            occupied += usize::from(holds);
            if !holds {
                continue;
            }
            let mut features = vec![0.0; field.channels()];
            let mut from = 0;
            for (table, place) in field.tables().iter().zip(&places) {
                table.gather(*place, &mut features[from..from + table.channels()]);
                from += table.channels();
            }
            let density = field.density(&features);
            let off = (density - point.density).abs() / point.density.max(1.0);
            let colour = field.colour(&features, point.direction.into(), &mut vec![]);
            let shade = (colour - DVec3::from(point.colour)).abs().max_element();
            farthest = farthest.max(off).max(shade);
        }
        println!("{name}: {occupied} occupied, farthest {farthest:.1e}");
        assert!(farthest < 1e-5, "{name}: {farthest}");
        assert!((5..expected.points.len()).contains(&occupied), "{occupied}");
    }
}
