//! Tests of the tables of keys: every key of a file has a row, and an added key is refused or
//! listed.

use potamoi_base::file_keys::{Fate, Format};
use potamoi_scene::file_formats::formats;

use super::write::{Ply, Shape, Spz, archive, members};
use super::*;

fn format(name: &str) -> &'static Format {
    formats().into_iter().find(|own| own.name == name).unwrap()
}

fn fixture(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures");
    std::fs::read(Path::new(folder).join(name)).unwrap()
}

#[track_caller]
fn has_rows(format: &Format, keys: &[String]) {
    assert!(!keys.is_empty());
    for key in keys {
        assert!(
            format.row(key).is_some(),
            "{}: no row for {key}",
            format.name
        );
    }
}

/// The lines of a header as they stand, `element.property` of all but `plain`.
fn header_keys(bytes: &[u8], plain: &str) -> Vec<String> {
    let end = bytes
        .windows(10)
        .position(|own| own == b"end_header")
        .unwrap();
    let text = String::from_utf8_lossy(&bytes[..end]);
    let mut element = String::new();
    let mut keys = vec![];
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["element", name, _] => element = name.to_owned(),
            ["property", _, name] if element == plain => keys.push(name.to_owned()),
            ["property", _, name] => keys.push(format!("{element}.{name}")),
            ["comment", ..] => keys.push(line.to_owned()),
            _ => {}
        }
    }
    keys
}

fn json_keys(path: &str, value: &serde_json::Value, keys: &mut Vec<String>) {
    match value.as_object() {
        Some(own) => own.iter().for_each(|(key, value)| {
            let dot = if path.is_empty() { "" } else { "." };
            json_keys(&format!("{path}{dot}{key}"), value, keys);
        }),
        None => keys.push(path.to_owned()),
    }
}

#[test]
fn every_key_of_a_fixture_has_a_row() {
    let packed = fixture("splats/cloud.compressed.ply");
    has_rows(
        format("packed PLY of PlayCanvas"),
        &header_keys(&packed, ""),
    );
    let mut ply = Ply::of(&Shape::new(-3.2)).line(b"comment SplatRenderMode: mip");
    ply.columns
        .push(("float", "filter_3D".to_owned(), vec![0.0; 160]));
    ply.columns.push(("float", "nx".to_owned(), vec![0.0; 160]));
    has_rows(
        format("PLY of 3D Gaussian splatting"),
        &header_keys(&ply.bytes(), "vertex"),
    );
    let mut keys = vec![];
    for (name, content) in members(&fixture("splats/cloud.sog")) {
        if name == "meta.json" {
            json_keys("", &serde_json::from_slice(&content).unwrap(), &mut keys);
        }
    }
    has_rows(format("SOG of PlayCanvas"), &keys);
    let npz = members(&fixture("compact/tiny.npz"));
    let names = npz
        .iter()
        .map(|(name, _)| name.strip_suffix(".npy").unwrap());
    let names: Vec<String> = names.map(str::to_owned).collect();
    has_rows(format("Compact-3DGS"), &names);
    // All that is honoured of these is used: nothing is left over.
    let folder = tempfile::tempdir().unwrap();
    for (name, own) in [
        ("cloud.compressed.ply", "packed PLY of PlayCanvas"),
        ("cloud.v2.spz", "SPZ of Niantic"),
        ("cloud.v3.spz", "SPZ of Niantic"),
        ("cloud.v4.spz", "SPZ of Niantic"),
        ("cloud.sog", "SOG of PlayCanvas"),
        ("few.glb", "glTF with KHR_gaussian_splatting"),
    ] {
        let path = write(folder.path(), name, &fixture(&format!("splats/{name}")));
        let left = notes(&path);
        let rows = format(own).keys.iter();
        let honoured = rows.filter(|row| row.fate == Fate::Honoured);
        let names: Vec<&str> = honoured.map(|row| row.name).collect();
        assert!(
            left.not_used()
                .iter()
                .all(|key| !names.contains(&key.as_str())),
            "{left:?}"
        );
        assert!(left.assumed().join(" ").contains("axes "), "{name}");
    }
}

/// A reader of a file in which something unknown stands lists it, or refuses the file by its name.
#[track_caller]
fn named(folder: &Path, name: &str, bytes: &[u8], key: &str) {
    let path = write(folder, name, bytes);
    let said = match Scene::open(path.to_str().unwrap()) {
        Ok(scene) => scene.left_open().join("; "),
        Err(error) => error.to_string(),
    };
    assert!(said.contains(key), "{name}: {key} is dropped: {said}");
}

#[test]
fn what_is_added_to_a_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let plain = Ply::of(&Shape::new(-3.2));
    for (kind, name) in [
        ("float", "weird"),
        ("uchar", "scale_3"),
        ("float", "f_dc_3"),
        ("double", "rot_4"),
    ] {
        let mut ply = plain.clone();
        ply.columns.push((kind, name.to_owned(), vec![0.0; 160]));
        named(at, "a.ply", &ply.bytes(), name);
    }
    for line in ["comment Exported by hand", "obj_info of something"] {
        named(
            at,
            "a.ply",
            &plain.clone().line(line.as_bytes()).bytes(),
            line,
        );
    }
    let element = plain
        .clone()
        .line(b"element camera 2")
        .line(b"property float focus");
    let mut bytes = element.bytes();
    let body = bytes
        .windows(11)
        .position(|own| own == b"end_header\n")
        .unwrap()
        + 11;
    bytes.splice(body..body, [0; 8]);
    named(at, "a.ply", &bytes, "element camera");
    assert_eq!(
        load(&at.join("a.ply")).cloud,
        load(&plain.write(at, "b.ply")).cloud
    );
    let mut ply = plain.clone();
    ply.tail = vec![1; 5];
    named(
        at,
        "a.ply",
        &ply.bytes(),
        "bytes after the last element (5)",
    );
    let mut ply = Ply {
        text: true,
        ..plain
    };
    ply.tail = b"\n 1 2\n".to_vec();
    named(
        at,
        "a.ply",
        &ply.bytes(),
        "bytes after the last element (2)",
    );

    let packed = fixture("splats/cloud.compressed.ply");
    let body = packed
        .windows(11)
        .position(|own| own == b"end_header\n")
        .unwrap();
    let (head, rest) = packed.split_at(body);
    let with = |line: &str, tail: &[u8]| [head, line.as_bytes(), rest, tail].concat();
    named(
        at,
        "a.ply",
        &with("comment of mine\n", b""),
        "comment of mine",
    );
    named(
        at,
        "a.ply",
        &with("", b"123"),
        "bytes after the last element (3)",
    );
    named(
        at,
        "a.ply",
        &with("element more 1\nproperty uchar weird\n", b"1"),
        "more.weird",
    );

    let shape = Shape::new(-3.2);
    for version in 1..=4 {
        let spz = Spz {
            flags: 0x44,
            ..Spz::new(version)
        };
        let bytes = spz.bytes(&shape, true);
        named(at, "a.spz", &bytes, "flag 0x04");
        named(at, "a.spz", &bytes, "flag 0x40");
        named(at, "a.spz", &[&bytes[..], b"tail!"].concat(), "(5)");
        for flags in [0, 2] {
            let mut spz = Spz {
                flags,
                ..Spz::new(version)
            };
            spz.tail = [0x1234_5678u32, 4, 1].map(u32::to_le_bytes).concat();
            let key = match (flags, version) {
                (2, _) => "extension 0x12345678",
                (_, 4) => "bytes after the header (12)",
                _ => "bytes after the arrays (12)",
            };
            named(at, "a.spz", &spz.bytes(&shape, true), key);
            spz.tail = b"no extension".to_vec();
            let key = if flags == 0 {
                "(12)"
            } else {
                "length of an extension"
            };
            named(at, "a.spz", &spz.bytes(&shape, true), key);
        }
        if version < 4 {
            let spz = Spz {
                reserved: 9,
                ..Spz::new(version)
            };
            named(
                at,
                "a.spz",
                &spz.bytes(&shape, true),
                "reserved byte of the header (9)",
            );
        } else {
            let mut bytes = bytes.clone();
            bytes[25] = 1;
            named(at, "a.spz", &bytes, "reserved bytes of the header");
        }
    }

    let all = members(&fixture("splats/cloud.sog"));
    let archived = archive(&all);
    let npz = fixture("compact/tiny.npz");
    for (name, plain) in [("a.sog", &archived), ("a.npz", &npz)] {
        let tail = [&plain[..], b"tail"].concat();
        named(at, name, &tail, "bytes after the archive (4)");
        let start = [b"start", &plain[..]].concat();
        named(at, name, &start, "bytes before the archive (5)");
        let mut said = plain.clone();
        let length = said.len();
        said[length - 2] = 2;
        said.extend(b"hi");
        named(at, name, &said, "comment of the archive");
    }
    for (from, to, key) in [
        ("{", "{\"weird\":1,", "weird"),
        ("{", "{\"count\":300,", "field `count` is given twice"),
        (
            "\"mins\":",
            "\"maxs\":[1,2,3],\"mins\":",
            "field `means.maxs` is given twice",
        ),
        ("\"shN\":", "\"shN\":7,\"shn\":", "field `shN` is 7"),
        (
            "\"mins\":",
            "\"weird\":{\"deep\":[1]},\"mins\":",
            "means.weird.deep",
        ),
        ("\"shN\":{", "\"shN\":{\"weird\":null,", "shN.weird"),
    ] {
        let mut all = all.clone();
        let meta = &mut all.iter_mut().find(|(n, _)| n == "meta.json").unwrap().1;
        let text = String::from_utf8(meta.clone()).unwrap();
        assert!(text.contains(from));
        *meta = text.replacen(from, to, 1).into_bytes();
        named(at, "a.sog", &archive(&all), key);
    }
    for (name, file) in [("a.sog", "splats/cloud.sog"), ("a.npz", "compact/tiny.npz")] {
        let mut all = members(&fixture(file));
        all.push(("weird.npy".to_owned(), vec![1, 2]));
        named(at, name, &archive(&all), "weird");
    }
    // Nor do bytes of another format pass for them because of their number.
    let mut ply = Ply::of(&Shape::new(-3.2));
    ply.tail = vec![0; 32 - ply.bytes().len() % 32];
    let said = refusal(&write(at, "b.splat", &ply.bytes()));
    assert!(said.contains("content is a PLY file"), "{said}");
    // Rows of 32 bytes have no place for anything else.
    named(at, "a.splat", &[0; 33], "length in bytes");
}

#[test]
fn models_that_are_no_gaussians_in_space_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let plain = Ply::of(&Shape::new(-3.2));
    let packed = fixture("splats/cloud.compressed.ply");
    let last = b"property uint packed_color\n";
    let at = packed.windows(last.len()).position(|own| own == last);
    let (head, rest) = packed.split_at(at.unwrap() + last.len());
    for name in [
        "motion_0",
        "trbf_scale",
        "t",
        "time",
        "lifetime",
        "velocity_x",
        "scale_t",
        "rot_r_0",
        "scale_3",
        "rot_4",
        "f_dc_3",
        "beta",
        "nu_degree",
        "filter_3d",
    ] {
        let mut ply = plain.clone();
        ply.columns.push(("float", name.to_owned(), vec![0.0; 160]));
        let line = format!("property float {name}\n");
        let files = [
            ply.bytes(),
            [head, line.as_bytes(), rest, &[0; 4 * 300]].concat(),
        ];
        for bytes in files {
            let said = refusal(&write(folder.path(), "a.ply", &bytes));
            let expected = format!("`{name}` cannot be honoured");
            assert!(said.contains(&expected), "{said}");
        }
    }
    // Discs have no such filter.
    let mut discs = plain.clone();
    discs.columns.retain(|own| own.1 != "scale_2");
    discs
        .columns
        .push(("float", "filter_3D".to_owned(), vec![0.1; 160]));
    let said = refusal(&discs.write(folder.path(), "a.ply"));
    assert!(said.contains("`filter_3D` cannot be honoured"), "{said}");
}

/// If two members have the same name, no reader knows which is meant.
#[test]
fn members_that_are_given_twice_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, file, first) in [
        ("a.sog", "splats/cloud.sog", "quats.webp"),
        ("a.npz", "compact/tiny.npz", "xyz.npy"),
    ] {
        let mut all = members(&fixture(file));
        let mut other = first.as_bytes().to_vec();
        other[0] = b'?';
        all.push((String::from_utf8(other.clone()).unwrap(), vec![1]));
        let mut bytes = archive(&all);
        for at in 0..=bytes.len() - other.len() {
            if bytes[at..].starts_with(&other) {
                bytes[at] = first.as_bytes()[0];
            }
        }
        let path = write(folder.path(), name, &bytes);
        let said = Scene::open(path.to_str().unwrap()).unwrap_err().to_string();
        let expected = format!("member `{first}` is given twice");
        assert!(said.contains(&expected), "{said}");
    }
}

#[test]
fn comments_of_packed_files_are_honoured() {
    let folder = tempfile::tempdir().unwrap();
    let packed = fixture("splats/cloud.compressed.ply");
    let end = packed
        .windows(11)
        .position(|own| own == b"end_header\n")
        .unwrap();
    let with = |line: &str| {
        let bytes = [&packed[..end], line.as_bytes(), &packed[end..]].concat();
        load(&write(folder.path(), "a.ply", &bytes))
    };
    let plain = with("comment of mine\n");
    assert_eq!(plain.up, None);
    let mip = with("comment SplatRenderMode: mip\n");
    assert_eq!(mip.cloud, plain.cloud.clone().antialiased(true));
    assert_ne!(mip.cloud, plain.cloud);
    assert_eq!(with("comment Vertical axis: -z\n").up, Some(DVec3::NEG_Z));
}
