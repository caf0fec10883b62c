#![allow(clippy::unwrap_used, clippy::panic)]
use super::*;
use crate::Cloud;
use potamoi_base::sh;
use proptest::prelude::*;

const NAMES: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
    "rot_0", "rot_1", "rot_2", "rot_3",
];

fn names(degree: usize) -> Vec<String> {
    let rest = 3 * (sh::coefficients(degree) - 1);
    NAMES
        .iter()
        .map(|n| (*n).to_owned())
        .chain((0..rest).map(|i| format!("f_rest_{i}")))
        .collect()
}

fn head(format: &str, count: usize, names: &[String]) -> String {
    let mut text = format!("ply\nformat {format} 1.0\ncomment c\nelement vertex {count}\n");
    for n in names {
        text += &format!("property float {n}\n");
    }
    text + "end_header\n"
}

/// A little-endian file whose value of property `i` of vertex `v` is
/// `value(v, name)`.
fn file(count: usize, names: &[String], value: impl Fn(usize, &str) -> f32) -> Vec<u8> {
    let mut bytes = head("binary_little_endian", count, names).into_bytes();
    for v in 0..count {
        for n in names {
            bytes.extend_from_slice(&value(v, n).to_le_bytes());
        }
    }
    bytes
}

/// A value that tells vertex and property.
fn tell(vertex: usize, name: &str) -> f32 {
    let all = names(3);
    let place = all.iter().position(|n| n == name).unwrap_or(99);
    vertex as f32 + place as f32 / 64.0
}

fn load(bytes: &[u8]) -> Result<Cloud, PlyError> {
    parse(bytes, bytes.len() as u64, "t.ply").map(|loaded| loaded.cloud)
}

fn refusal(bytes: &[u8]) -> String {
    let text = load(bytes).unwrap_err().to_string();
    assert!(text.contains("t.ply"), "{text}");
    assert!(!text.contains('\n'), "{text}");
    text
}

#[test]
fn every_degree_is_read_channel_major() {
    for degree in 0..=3 {
        let cloud = load(&file(3, &names(degree), tell)).unwrap();
        assert_eq!((cloud.len(), cloud.degree()), (3, degree));
        assert_eq!(cloud.means()[2], ["x", "y", "z"].map(|n| tell(2, n)));
        assert_eq!(
            cloud.rotations()[1],
            ["rot_0", "rot_1", "rot_2", "rot_3"].map(|n| tell(1, n))
        );
        assert_eq!(cloud.opacity_logits()[0], tell(0, "opacity"));
        let rest = sh::coefficients(degree) - 1;
        for c in 0..rest {
            let expected = [0, 1, 2].map(|k| tell(1, &format!("f_rest_{}", k * rest + c)));
            assert_eq!(cloud.sh(1)[c + 1], expected);
        }
    }
}

#[test]
fn order_encoding_and_extra_properties_change_nothing() {
    let plain = load(&file(4, &names(2), tell)).unwrap();
    let mut mixed = names(2);
    mixed.reverse();
    mixed.insert(5, "nx".to_owned());
    mixed.rotate_left(17);
    assert_eq!(load(&file(4, &mixed, tell)).unwrap(), plain);

    let mut big = head("binary_big_endian", 4, &mixed).into_bytes();
    let mut text = head("ascii", 4, &mixed);
    for v in 0..4 {
        for n in &mixed {
            big.extend_from_slice(&tell(v, n).to_be_bytes());
            text += &format!("{} ", tell(v, n));
        }
        text = text.trim_end().to_owned() + "\n";
    }
    assert_eq!(load(&big).unwrap(), plain);
    assert_eq!(load(text.as_bytes()).unwrap(), plain);
    assert_eq!(load(text.trim_end().as_bytes()).unwrap(), plain);
}

#[test]
fn elements_before_the_vertices_are_read_past() {
    let plain = file(2, &names(0), tell);
    let text = head("binary_little_endian", 2, &names(0)).replace(
        "element vertex",
        "element box 2\nproperty list uchar ushort corner\nproperty double size\nelement vertex",
    );
    let mut bytes = text.into_bytes();
    for corners in [0u8, 3] {
        bytes.push(corners);
        bytes.extend(std::iter::repeat_n(7, 2 * usize::from(corners) + 8));
    }
    let payload = 2 * 14 * 4;
    bytes.extend_from_slice(&plain[plain.len() - payload..]);
    assert_eq!(load(&bytes).unwrap(), load(&plain).unwrap());
}

#[test]
fn infinite_opacity_is_legal() {
    let bytes = file(2, &names(0), |v, n| match (v, n) {
        (0, "opacity") => f32::INFINITY,
        (1, "opacity") => f32::NEG_INFINITY,
        _ => 0.5,
    });
    let cloud = load(&bytes).unwrap();
    assert_eq!(cloud.opacity_logits(), [f32::INFINITY, f32::NEG_INFINITY]);
}

#[test]
fn values_that_are_no_numbers_are_named() {
    for (property, value) in [
        ("scale_1", f32::NAN),
        ("z", f32::INFINITY),
        ("opacity", f32::NAN),
    ] {
        let bytes = file(3, &names(1), |v, n| {
            if v == 2 && n == property { value } else { 0.5 }
        });
        let text = refusal(&bytes);
        assert!(
            text.contains("vertex 2") && text.contains(&format!("`{property}`")),
            "{text}"
        );
    }
    let bytes = file(
        1,
        &names(0),
        |_, n| if n == "scale_2" { 100.0 } else { 0.5 },
    );
    assert!(refusal(&bytes).contains("log scale[2] is 100"));
    // A double that no f32 holds.
    let text = head("binary_little_endian", 1, &names(0)).replace("float x", "double x");
    let mut bytes = text.into_bytes();
    bytes.extend_from_slice(&1e300f64.to_le_bytes());
    bytes.extend_from_slice(&[0; 13 * 4]);
    let said = refusal(&bytes);
    let expected = "`x` is 1e300: expected a finite number from -3.4e38 to 3.4e38";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn headers_that_lie_or_lack_are_refused() {
    let good = file(2, &names(1), tell);
    let header = head("binary_little_endian", 2, &names(1));
    let with = |from: &str, to: &str| {
        let mut bytes = header.replace(from, to).into_bytes();
        bytes.extend_from_slice(&good[header.len()..]);
        refusal(&bytes)
    };
    assert!(with("ply\n", "plx\n").contains("not a PLY"));
    assert!(with("vertex 2", "vertex 0").contains("no Gaussian"));
    assert!(with("vertex 2", "face 2").contains("no Gaussian"));
    assert!(with("vertex 2", "vertex 99999999999999999").contains("cut off"));
    assert!(with("vertex 2", "vertex 99999999999999999999999").contains("header"));
    assert!(with("vertex 2", "vertex -1").contains("header"));
    assert!(with("float rot_3", "float rot_4").contains("`rot_3`"));
    assert!(with("float x", "float y").contains("second property `y`"));
    assert!(with("float x", "list uchar float x").contains("list"));
    assert!(with("float f_rest_8\n", "float f_rest_9\n").contains("`f_rest_8`"));
    assert!(with("property float f_rest_8\n", "").contains("8 properties"));
    assert!(with("binary_little_endian", "binary").contains("header"));
    assert!(with("format binary_little_endian 1.0\n", "").contains("header"));
    assert!(with("comment c", "element vertex 1").contains("second element"));
    let endless = with("comment c", "element nothing 9999999999999");
    assert!(endless.contains("`nothing` has no property"));
    assert!(with("comment c", "nonsense").contains("header"));
    assert!(refusal(b"").contains("not a PLY"));
    assert!(refusal(b"ply\n").contains("end_header"));
    let endless = format!("ply\n{}", "comment x\n".repeat(100_000));
    assert!(refusal(endless.as_bytes()).contains("end_header"));
    let long_line = format!("ply\ncomment {}", "x".repeat(1 << 20));
    assert!(refusal(long_line.as_bytes()).contains("end_header"));
    let degree_4 = file(
        1,
        &{
            let mut n = names(3);
            n.extend((45..72).map(|i| format!("f_rest_{i}")));
            n
        },
        tell,
    );
    assert!(refusal(&degree_4).contains("72 properties"));
}

#[test]
fn text_files_with_bad_lines_are_refused() {
    let header = head("ascii", 2, &names(0));
    let line = "1 ".repeat(13);
    for (body, expected) in [
        (format!("{line}1\n{line}\n"), "vertex` 1"),
        (
            format!("{line}1\n{line}one\n"),
            "vertex` 1: value 14 of its line is `one`: expected a number",
        ),
        (
            format!("{line}1\n1 2,5 {line}\n"),
            "vertex` 1: value 2 of its line is `2,5`",
        ),
        (
            format!("{line}1 7\n{line}1\n"),
            "value 15 of its line is `7`: expected the line to end before it",
        ),
        (
            format!("{line}nan\n{line}1\n"),
            "vertex 0, property `rot_3` is NaN",
        ),
        (format!("{line}1\n"), "cut off"),
        (format!("{line}{line}{line}1\n"), "vertex` 0"),
    ] {
        let text = refusal((header.clone() + &body).as_bytes());
        assert!(text.contains(expected), "{body}: {text}");
    }
}

#[test]
fn paths_that_are_no_files_are_refused() {
    let missing = read(Path::new("no/such/file.ply")).unwrap_err();
    assert!(missing.to_string().contains("no/such/file.ply"));
    let folder = read(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
    assert!(matches!(folder, PlyError::File(PlyFileError::Read { .. })));
}

proptest! {
    #[test]
    fn no_cut_is_taken_for_a_whole_file(at in 0usize..2000) {
        let good = file(5, &names(1), tell);
        let at = at % good.len();
        prop_assert!(load(&good[..at]).is_err());
    }

    #[test]
    fn noise_never_panics(mut bytes in proptest::collection::vec(any::<u8>(), 0..300), change in any::<[u16; 4]>()) {
        let _ = load(&bytes);
        let mut good = file(2, &names(0), tell);
        for (i, c) in change.into_iter().enumerate() {
            let at = usize::from(c) % good.len();
            good[at] = good[at].wrapping_add(i as u8 + 1);
        }
        let _ = load(&good);
        bytes.splice(0..0, *b"ply\nformat ascii 1.0\nelement vertex 3\n");
        let _ = load(&bytes);
    }
}
