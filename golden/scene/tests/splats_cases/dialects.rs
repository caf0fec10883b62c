//! One file in the dialects of several programs.

use super::write::{Ply, Shape, members};
use super::*;

#[test]
fn headers_of_other_programs_are_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let ply = Ply::of(&Shape::new(-3.2));
    let plain = load(&ply.write(folder.path(), "plain.ply"));
    assert!(plain.notes.not_used().is_empty());
    assert_eq!(plain.notes.assumed(), ["axes right-down-front"]);
    let mut all = vec![];
    for text in [false, true] {
        for line_end in ["\n", "\r\n", "\r"] {
            for start in [&b""[..], b"\xef\xbb\xbf"] {
                let own = Ply {
                    text,
                    line_end,
                    start,
                    ..ply.clone()
                };
                all.push(own.line(b"comment Aufnahme K\xf6ln"));
            }
        }
    }
    // Longer than 64 KiB.
    let mut long = ply.clone();
    for _ in 0..2000 {
        long = long.line(&[b"comment ".as_slice(), &[b'x'; 50]].concat());
    }
    all.push(long);
    for own in all {
        let loaded = load(&own.write(folder.path(), "a.ply"));
        assert_eq!(
            loaded.cloud, plain.cloud,
            "{:?} {:?}",
            own.line_end, own.start
        );
        assert_eq!(loaded.notes.not_used().len(), 1);
    }
    let latin = ply
        .clone()
        .line(b"comment K\xf6ln")
        .write(folder.path(), "a.ply");
    assert_eq!(notes(&latin).not_used(), ["comment K\u{f6}ln"]);
}

/// A binary body that begins with the byte of a line feed, behind every line end.
#[test]
fn a_line_end_takes_no_byte_of_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let mut shape = Shape::new(-3.2);
    shape.centres[0][0] = f64::from(f32::from_bits(0x3f00_000a));
    for line_end in ["\n", "\r\n", "\r"] {
        let ply = Ply {
            line_end,
            ..Ply::of(&shape)
        };
        let loaded = load(&ply.write(folder.path(), "a.ply"));
        assert_eq!(
            loaded.cloud.means()[0][0].to_bits(),
            0x3f00_000a,
            "{line_end:?}"
        );
        assert!(loaded.notes.not_used().is_empty());
    }
}

/// A log size of minus infinity is a size of 0; discs of 2DGS have one.
#[test]
fn sizes_of_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut flat = Shape::new(-2.6);
    let thick = picture(&Ply::of(&flat).write(folder.path(), "thick.ply"));
    for scales in &mut flat.scales {
        scales[2] = -60.0;
    }
    let truth = picture(&Ply::of(&flat).write(folder.path(), "truth.ply"));
    let mut ply = Ply::of(&flat);
    ply.column("scale_2").2.fill(f64::NEG_INFINITY);
    for text in [false, true] {
        let path = Ply {
            text,
            ..ply.clone()
        }
        .write(folder.path(), "a.ply");
        tells_apart(&picture(&path), &truth, &thick, LOSSLESS);
    }
    ply.columns.retain(|own| own.1 != "scale_2");
    let path = ply.write(folder.path(), "a.ply");
    tells_apart(&picture(&path), &truth, &thick, LOSSLESS);
    assert!(notes(&path).assumed().join(" ").contains("2DGS"));
    ply.columns.retain(|own| own.1 != "scale_1");
    let said = refusal(&ply.write(folder.path(), "a.ply"));
    assert!(said.contains("no property `scale_1`"), "{said}");
    ply.columns
        .push(("float", "scale_1".to_owned(), vec![f64::INFINITY; 160]));
    let said = refusal(&ply.write(folder.path(), "a.ply"));
    assert!(
        said.contains("vertex 0, property `scale_1` is inf"),
        "{said}"
    );
}

/// Centres of 64 bits half a million units off lose nothing; rounded to 32 bits they would.
#[test]
fn wide_centres_far_off_keep_their_digits() {
    let folder = tempfile::tempdir().unwrap();
    let shape = Shape::new(-3.2);
    let far = DVec3::new(500_000.0, 4_500_000.0, 0.0);
    let camera_file = |name: &str, at: DVec3| {
        let [x, y, z] = (at + DVec3::new(0.1, 0.05, -3.0)).to_array();
        let text = format!(
            "[{{\"id\":0,\"img_name\":\"a\",\"width\":96,\"height\":80,\"position\":[{x},{y},{z}],\
             \"rotation\":[[1,0,0],[0,1,0],[0,0,1]],\"fy\":110,\"fx\":110}}]"
        );
        write(folder.path(), name, text.as_bytes())
    };
    let [near_camera, far_camera] =
        [("near.json", DVec3::ZERO), ("far.json", far)].map(|(name, at)| camera_file(name, at));
    let through = |path: &Path, camera: &Path| {
        let mut scene = open(path);
        scene.set_camera_file(camera, 0).unwrap();
        scene.render_float().unwrap().picture
    };
    let mut ply = Ply::of(&shape);
    let truth = through(&ply.write(folder.path(), "near.ply"), &near_camera);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let column = ply.column(name);
        column.0 = "double";
        column.2.iter_mut().for_each(|v| *v += far[axis]);
    }
    let path = ply.write(folder.path(), "far.ply");
    let rounded = {
        let mut ply = ply.clone();
        for name in ["x", "y", "z"] {
            ply.column(name).0 = "float";
        }
        through(&ply.write(folder.path(), "rounded.ply"), &far_camera)
    };
    tells_apart(&through(&path, &far_camera), &truth, &rounded, LOSSLESS);
    let loaded = load(&path);
    assert_eq!(loaded.origin.z, 0.0);
    assert!((loaded.origin - far).abs().max_element() < 1.0);
    let assumed = loaded.notes.assumed().join(" ");
    assert!(assumed.contains("centres from (499999."), "{assumed}");
    // One that lies elsewhere takes nothing from the others, and is told where it is rounded.
    for (elsewhere, is_told) in [(0.0, false), (600_000.37, true)] {
        let mut ply = ply.clone();
        for (_, name, values) in &mut ply.columns {
            values.push(values[0]);
            if ["x", "y"].contains(&name.as_str()) {
                values[160] = elsewhere;
            }
        }
        let path = ply.write(folder.path(), "outlier.ply");
        tells_apart(&through(&path, &far_camera), &truth, &rounded, LOSSLESS);
        let notes = notes(&path);
        let told = notes.not_used().join("; ");
        let said = told.contains("the last digits of 1 centres, which floats move by up to");
        assert_eq!(said, is_told, "{told}");
    }
    // Text of the same digits.
    let text = Ply {
        text: true,
        ..ply.clone()
    }
    .write(folder.path(), "text.ply");
    assert_eq!(load(&text).cloud, loaded.cloud);
    // An orbit's target is of the file's world.
    let toml = "[model]\nkind = \"splats\"\npath = \"far.ply\"\n[camera]\nkind = \"orbit\"\n\
                azimuth = 0\nelevation = 0\ndistance = 3\ntarget = [500000.0, 4500000.0, 0.0]\n";
    let scene = open(&write(folder.path(), "scene.toml", toml.as_bytes()));
    let middle = DVec3::ZERO - loaded.origin + far;
    let seen = scene.camera().world_to_camera.transform_point3(middle);
    assert!((seen - DVec3::new(0.0, 0.0, 3.0)).length() < 1e-6, "{seen}");
    // Doubles near the origin are what floats are.
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        ply.column(name).2.iter_mut().for_each(|v| *v -= far[axis]);
    }
    assert_eq!(load(&ply.write(folder.path(), "a.ply")).origin, DVec3::ZERO);
}

/// A folder, its `meta.json`, the archive, and levels of detail of which it is one.
#[test]
fn sog_by_any_of_its_names() {
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/fixtures/splats/cloud.sog"
    );
    let folder = tempfile::tempdir().unwrap();
    let level = folder.path().join("0_0");
    std::fs::create_dir(&level).unwrap();
    for (name, content) in members(&std::fs::read(fixture).unwrap()) {
        write(&level, &name, &content);
    }
    let content = |path: &Path| {
        let own = load(path);
        (own.cloud, own.notes)
    };
    let archived = content(Path::new(fixture));
    let meta = level.join("meta.json");
    assert_eq!(content(&level), archived);
    assert_eq!(content(&meta), archived);
    let mut marked = b"\xef\xbb\xbf".to_vec();
    marked.extend(std::fs::read(&meta).unwrap());
    write(&level, "meta.json", &marked);
    assert_eq!(content(&meta), archived);
    assert!(open(&meta).model().is_splats());
    let runs = r#"{"0": {"file": 0, "offset": 0, "count": 300}}"#;
    let text = format!(
        r#"{{"lodLevels": 1, "filenames": ["0_0/meta.json"], "tree": {{"lods": {runs}}}}}"#
    );
    let levels = write(folder.path(), "lod-meta.json", text.as_bytes());
    for path in [&levels, folder.path()] {
        assert_eq!(load(path).cloud, archived.0);
        assert!(open(path).model().is_splats());
    }
}
