//! Each format against the cloud that another program wrote.

use super::*;

/// The original in the order of a cloud read back: writers sort by place.
fn matched(found: &Cloud) -> Cloud {
    let all = original();
    assert_eq!(found.len(), COUNT);
    let distance =
        |a: &[f32; 3], b: &[f32; 3]| -> f32 { a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum() };
    let order: Vec<usize> = (found.means().iter())
        .map(|mean| {
            (0..COUNT)
                .min_by(|a, b| {
                    distance(&all.means()[*a], mean).total_cmp(&distance(&all.means()[*b], mean))
                })
                .unwrap()
        })
        .collect();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..COUNT), "each Gaussian once");
    all.select(&order).unwrap()
}

/// How far a format's values may be off, by its steps. The functions get the
/// Gaussian and the axis or channel.
struct Steps<'a> {
    mean: &'a dyn Fn(usize, usize) -> f32,
    log_scale: &'a dyn Fn(usize, usize) -> f32,
    /// Of the three components that are stored.
    rotation: f64,
    /// The component that is not, `None` for the largest.
    derived: Option<usize>,
    opacity: f64,
    constant: &'a dyn Fn(usize, usize) -> f32,
    /// Of band 1 and of the others; none to leave them to the caller.
    rest: Option<[f32; 2]>,
}

fn check(found: &Cloud, steps: &Steps<'_>) {
    let expected = matched(found);
    assert_eq!(found.degree(), 3);
    let within = |what: &str, i: usize, a: f32, b: f32, step: f32| {
        let rounding = 1e-6 * a.abs().max(1.0);
        assert!(
            (a - b).abs() <= step + rounding,
            "{what} {i}: {a} {b} {step}"
        );
    };
    let sigmoid = |x: f32| 1.0 / (1.0 + (-f64::from(x)).exp());
    for i in 0..COUNT {
        for k in 0..3 {
            let [a, b] = [&expected, found];
            within(
                "mean",
                i,
                a.means()[i][k],
                b.means()[i][k],
                (steps.mean)(i, k),
            );
            let (s, t) = (a.log_scales()[i][k], b.log_scales()[i][k]);
            within("scale", i, s, t, (steps.log_scale)(i, k));
            within(
                "constant",
                i,
                a.sh(i)[0][k],
                b.sh(i)[0][k],
                (steps.constant)(i, k),
            );
            if let Some([one, others]) = steps.rest {
                for c in 1..16 {
                    let step = if c < 4 { one } else { others };
                    within("coefficient", i, a.sh(i)[c][k], b.sh(i)[c][k], step);
                }
            }
        }
        let [a, b] = [&expected, found].map(|c| sigmoid(c.opacity_logits()[i]));
        assert!(
            (a - b).abs() <= steps.opacity + 1e-6,
            "opacity {i}: {a} {b}"
        );
        let [p, q] = [&expected, found].map(|c| c.rotations()[i].map(f64::from));
        let length = p.iter().map(|v| v * v).sum::<f64>().sqrt();
        let p = p.map(|v| v / length);
        let sign = p.iter().zip(&q).map(|(a, b)| a * b).sum::<f64>().signum();
        let largest = (0..4).max_by(|a, b| p[*a].abs().total_cmp(&p[*b].abs()));
        let derived = steps.derived.or(largest).unwrap();
        for k in 0..4 {
            let (off, step) = if k == derived {
                // |q| is 1 and the others' squares are off by 2 |q_k| e + e^2 each.
                let e = steps.rotation;
                (
                    (p[k].powi(2) - q[k].powi(2)).abs(),
                    2.0 * 3f64.sqrt() * e + 3.0 * e * e,
                )
            } else {
                ((p[k] - sign * q[k]).abs(), steps.rotation)
            };
            assert!(off <= step + 1e-6, "rotation {i}: {p:?} {q:?}");
        }
    }
}

#[test]
fn packed_ply_is_within_half_a_step_of_its_chunks() {
    let cloud = packed_cloud(&fixture("cloud.compressed.ply"), "f").unwrap();
    // Bounds are reached, so that those of what was read are those of the file.
    let range = |i: usize, value: &dyn Fn(usize) -> f32| {
        let chunk = i / 256 * 256;
        let values = (chunk..(chunk + 256).min(COUNT)).map(value);
        let fold = |f: fn(f32, f32) -> f32, v: f32| values.clone().fold(v, f);
        fold(f32::max, f32::MIN) - fold(f32::min, f32::MAX)
    };
    let most = |k: usize| if k == 1 { 1023.0 } else { 2047.0 };
    check(
        &cloud,
        &Steps {
            mean: &|i, k| range(i, &|j| cloud.means()[j][k]) / most(k) / 2.0,
            log_scale: &|i, k| range(i, &|j| cloud.log_scales()[j][k]) / most(k) / 2.0,
            rotation: 2f64.sqrt() / 1023.0 / 2.0,
            derived: None,
            opacity: 0.5 / 255.0,
            constant: &|i, k| range(i, &|j| cloud.sh(j)[0][k]) / 255.0 / 2.0,
            rest: Some([1.0 / 64.0; 2]),
        },
    );
}

/// Colours are 8 bits of 0.15 a unit, and coefficients 5 bits of 2 in band 1
/// and 4 above, after rounding to 8.
#[test]
fn spz_is_within_half_a_step() {
    for (version, rotation, derived, rest) in [
        (2, 1.0 / 255.0, Some(0), [0.5 / 128.0; 2]),
        (
            3,
            0.5 / 511.0 / 2f64.sqrt(),
            None,
            [4.5 / 128.0, 8.5 / 128.0],
        ),
        (
            4,
            0.5 / 511.0 / 2f64.sqrt(),
            None,
            [4.5 / 128.0, 8.5 / 128.0],
        ),
    ] {
        let cloud = spz_cloud(&fixture(&format!("cloud.v{version}.spz")), "f").unwrap();
        check(
            &cloud,
            &Steps {
                mean: &|_, _| 0.5 / 4096.0,
                log_scale: &|_, _| 0.5 / 16.0,
                rotation,
                derived,
                opacity: 0.5 / 255.0,
                constant: &|_, _| 0.5 / 255.0 / 0.15,
                rest: Some(rest),
            },
        );
        let ends = |end: f32| cloud.opacity_logits().iter().filter(|l| **l == end).count();
        assert!(ends(f32::INFINITY) >= 6 && ends(f32::NEG_INFINITY) >= 6);
    }
    let [three, four] = [3, 4].map(|v| fixture(&format!("cloud.v{v}.spz")));
    assert_eq!(
        spz_cloud(&three, "f").unwrap(),
        spz_cloud(&four, "f").unwrap()
    );
}

/// Centres are cut to 16 bits of their range, rotations and opacities to 8;
/// scales and colours are the nearest of 256 values.
#[test]
fn sog_is_within_its_steps() {
    let cloud = sog_cloud(&fixture("cloud.sog"), "f").unwrap();
    let range = 2.0 * 3f32.ln();
    check(
        &cloud,
        &Steps {
            mean: &|i, k| range / 65535.0 * (cloud.means()[i][k].abs() + 1.01),
            log_scale: &|_, _| 4.0 / 256.0,
            rotation: 2f64.sqrt() / 255.0,
            derived: None,
            opacity: 1.0 / 255.0,
            // The writer's images drop the colours of wholly transparent Gaussians.
            constant: &|i, _| match cloud.opacity_logits()[i] {
                f32::NEG_INFINITY => 2.0,
                _ => 2.0 / 256.0,
            },
            rest: None,
        },
    );
    // 256 entries for 300 Gaussians: most have one of their own.
    let expected = matched(&cloud);
    let alone = (0..COUNT).filter(|&i| {
        let pairs = cloud.sh(i)[1..].as_flattened().iter();
        let pairs = pairs.zip(expected.sh(i)[1..].as_flattened());
        pairs.into_iter().all(|(a, b)| (a - b).abs() < 1.0 / 64.0)
    });
    assert!(alone.count() >= COUNT / 2);
}

#[test]
fn a_folder_is_read_as_its_archive_is() {
    let bytes = fixture("cloud.sog");
    let folder = tempfile::tempdir().unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    archive.extract(folder.path()).unwrap();
    let file = folder.path().join("a.SOG");
    std::fs::write(&file, &bytes).unwrap();
    assert_eq!(
        read_cloud(folder.path()).unwrap(),
        read_cloud(&file).unwrap()
    );
    assert!(is_splats(folder.path()) && is_splats(&file));
    assert!(!is_splats(Path::new("scene.toml")) && !is_splats(Path::new("garden")));
}

/// Files of before colours had bounds: the same, less six columns of 18.
#[test]
fn packed_ply_without_colour_bounds_has_colours_of_zero_to_one() {
    let bytes = fixture("cloud.compressed.ply");
    let with = packed_cloud(&bytes, "f").unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let text = String::from_utf8(bytes[..at].to_vec()).unwrap();
    let colour = |l: &&str| !["_r", "_g", "_b"].iter().any(|e| l.ends_with(e));
    let mut old: Vec<u8> = (text.lines().filter(colour))
        .flat_map(|l| [l.as_bytes(), b"\n"].concat())
        .collect();
    let (chunks, rest) = bytes[at..].split_at(2 * 72);
    old.extend(chunks.chunks(72).flat_map(|row| &row[..48]));
    old.extend(rest);
    let without = packed_cloud(&old, "f").unwrap();
    for i in 0..COUNT {
        assert_eq!(without.means()[i], with.means()[i]);
        assert_eq!(without.sh(i)[1..], with.sh(i)[1..]);
        let word = u32::from_le_bytes(rest[16 * i + 12..16 * i + 16].try_into().unwrap());
        let codes = [24, 16, 8].map(|low| f64::from(word >> low & 255));
        for (value, code) in without.sh(i)[0].into_iter().zip(codes) {
            let colour = f64::from(value) * sh::CONSTANT + 0.5;
            assert!((colour * 255.0 - code).abs() < 1e-4);
        }
    }
    // Told apart by the header, whatever the ending says beside .ply.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.ply");
    std::fs::write(&file, &old).unwrap();
    assert_eq!(read_cloud(&file).unwrap(), without);
}

#[test]
fn splat_rows_are_read_as_defined() {
    let mut row = vec![];
    for v in [1.5f32, -2.0, 0.25, 1.0, 0.5, 0.0] {
        row.extend(v.to_le_bytes());
    }
    row.extend([255, 0, 51, 255, 0, 128, 192, 255]);
    let cloud = splat_cloud(&row, "f").unwrap();
    assert_eq!(cloud.means(), [[1.5, -2.0, 0.25]]);
    let smallest = f32::MIN_POSITIVE.ln();
    assert_eq!(cloud.log_scales(), [[0.0, 0.5f32.ln(), smallest]]);
    assert_eq!(cloud.rotations(), [[-1.0, 0.0, 0.5, 127.0 / 128.0]]);
    assert_eq!(cloud.opacity_logits(), [f32::INFINITY]);
    let expected = [0.5, -0.5, -0.3].map(|v| (v / sh::CONSTANT) as f32);
    for (found, expected) in cloud.sh(0)[0].into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6);
    }
}
