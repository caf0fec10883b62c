//! Numbers are checked against their types.

use super::write::{Ply, Shape, archive, members};
use super::*;

#[test]
fn whole_numbers_are_no_values_of_gaussians() {
    let folder = tempfile::tempdir().unwrap();
    let ply = Ply::of(&Shape::new(-3.2));
    for name in [
        "x",
        "y",
        "z",
        "f_dc_0",
        "f_dc_2",
        "f_rest_0",
        "f_rest_44",
        "opacity",
        "scale_0",
        "scale_2",
        "rot_0",
        "rot_3",
    ] {
        for kind in ["uchar", "ushort"] {
            let mut own = ply.clone();
            own.column(name).0 = kind;
            let said = refusal(&own.write(folder.path(), "a.ply"));
            let expected = format!("property `{name}` is {kind}: expected float or double");
            assert!(said.contains(&expected), "{said}");
        }
    }
    let mut halves = ply.clone();
    halves.columns.iter_mut().for_each(|own| own.0 = "half");
    let said = refusal(&halves.write(folder.path(), "a.ply"));
    assert!(
        said.contains("line 4: `property half x`: type `half`: expected char"),
        "{said}"
    );
    assert!(
        said.contains("PLY has no floats of 16 bits; write the file again with float"),
        "{said}"
    );
    // What is not used may be of any type.
    let mut own = ply.clone();
    own.columns
        .insert(3, ("uchar", "label".to_owned(), vec![7.0; 160]));
    let loaded = load(&own.write(folder.path(), "a.ply"));
    assert_eq!(loaded.cloud, load(&ply.write(folder.path(), "b.ply")).cloud);
    assert_eq!(loaded.notes.not_used(), ["label"]);
}

#[test]
fn quaternions_of_no_length_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let mut shape = Shape::new(-3.2);
    shape.rotations[5] = [0.0; 4];
    shape.rotations[9] = [0.0; 4];
    let assumed = notes(&Ply::of(&shape).write(folder.path(), "a.ply"));
    let assumed = assumed.assumed().join("; ");
    assert!(
        assumed.contains("a quaternion is 0 (2 of 160 Gaussians)"),
        "{assumed}"
    );
    let row = |rotation: [u8; 4]| {
        let mut row = [0f32, 0.0, 1.0, 0.1, 0.1, 0.1]
            .map(f32::to_le_bytes)
            .concat();
        row.extend([200, 100, 50, 255]);
        row.extend(rotation);
        notes(&write(folder.path(), "a.splat", &row))
            .assumed()
            .join("; ")
    };
    assert!(row([128; 4]).contains("(1 of 1 Gaussians)"));
    assert_eq!(row([255, 128, 128, 128]), "axes right-down-front");
}

#[test]
fn smallest_values_are_not_above_the_largest() {
    let folder = tempfile::tempdir().unwrap();
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/splats");
    let packed = std::fs::read(format!("{fixtures}/cloud.compressed.ply")).unwrap();
    // Two chunks of 18 floats, before 300 rows of 61 bytes.
    let body = packed.len() - 300 * 61 - 2 * 72;
    for (column, name) in [(3, "max_x"), (10, "max_scale_y"), (17, "max_b")] {
        let mut bad = packed.clone();
        let at = body + 72 + 4 * column;
        bad[at..at + 4].copy_from_slice(&(-100f32).to_le_bytes());
        let said = refusal(&write(folder.path(), "a.ply", &bad));
        let expected = format!("chunk 1, property `{name}` is -100: expected at least its `min_");
        assert!(said.contains(&expected), "{said}");
    }
    let mut all = members(&std::fs::read(format!("{fixtures}/cloud.sog")).unwrap());
    let meta = &mut all.iter_mut().find(|(n, _)| n == "meta.json").unwrap().1;
    let mut value: serde_json::Value = serde_json::from_slice(meta).unwrap();
    value["means"]["mins"][1] = 3.into();
    *meta = value.to_string().into_bytes();
    let said = refusal(&write(folder.path(), "a.sog", &archive(&all)));
    assert!(
        said.contains("means.mins is 3: expected at most its `means.maxs`"),
        "{said}"
    );
}

#[test]
fn what_no_float_holds_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let ply = Ply::of(&Shape::new(-3.2));
    for (name, value) in [
        ("x", f64::NAN),
        ("rot_2", f64::INFINITY),
        ("f_rest_3", f64::NEG_INFINITY),
        ("opacity", f64::NAN),
        ("scale_1", f64::NAN),
    ] {
        let mut own = ply.clone();
        own.column(name).2[4] = value;
        let said = refusal(&own.write(folder.path(), "a.ply"));
        assert!(
            said.contains(&format!("vertex 4, property `{name}` is")),
            "{said}"
        );
    }
}
