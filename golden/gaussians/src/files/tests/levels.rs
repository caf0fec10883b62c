//! Streamed SOG, by splat-transform's writer, by hand, and damaged.

use serde_json::{Value, json};

use super::near::{Near, check, first, of_degree};
use super::*;

/// The steps of SOG: 16 bits of a range of `2 ln 3`, and codebooks, of which the writer's are coarser than
/// 256 even steps where there are few Gaussians.
const NEAR: Near = Near {
    mean: 3.0 * 2.2 / 65535.0 + 1e-4,
    size: 0.02,
    rotation: 0.02,
    opacity: 1.0 / 255.0,
    constant: 0.02,
    rest: 0.0,
};

/// A copy of the fixture, whose `lod-meta.json` is changed.
fn folder(change: impl Fn(&mut Value)) -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/splats/levels");
    for chunk in ["0_0", "1_0"] {
        std::fs::create_dir(to.path().join(chunk)).unwrap();
        for file in std::fs::read_dir(from.join(chunk)).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), to.path().join(chunk).join(file.file_name())).unwrap();
        }
    }
    let text = std::fs::read(from.join(LEVELS)).unwrap();
    let mut meta: Value = serde_json::from_slice(&text).unwrap();
    change(&mut meta);
    std::fs::write(to.path().join(LEVELS), meta.to_string()).unwrap();
    to
}

#[track_caller]
fn refused(change: impl Fn(&mut Value), level: Option<usize>, expected: &str) {
    let folder = folder(change);
    let found = read_level(folder.path(), None, level).map(|own| own.cloud.len());
    let text = found.map_or_else(
        |e| e.to_string(),
        |_| panic!("read, not refused for: {expected}"),
    );
    assert!(
        text.contains(expected) && !text.contains('\n'),
        "{text} / {expected}"
    );
}

#[test]
fn each_level_is_what_its_writer_packed() {
    let whole = folder(|_| {});
    let file = whole.path().join(LEVELS);
    let finest = read(whole.path(), None).unwrap();
    assert_eq!(read(&file, None).unwrap().cloud, finest.cloud);
    check(&finest.cloud, &of_degree(&first(60), 0), &NEAR);
    let every_third: Vec<usize> = (0..20).map(|i| 3 * i).collect();
    let coarse = read_level(&file, None, Some(1)).unwrap();
    let expected = of_degree(&original().select(&every_third).unwrap(), 0);
    check(&coarse.cloud, &expected, &NEAR);
    assert_eq!(
        finest.facts.generator.as_deref(),
        Some("splat-transform v3.7.0")
    );
    let listed = finest.notes.not_used();
    assert!(
        listed.contains(&"levels but 0 of 2".to_owned()),
        "{listed:?}"
    );
    assert!(
        !coarse
            .notes
            .not_used()
            .iter()
            .any(|own| own.starts_with("levels but"))
    );
    assert!(is_splats(whole.path()) && is_splats(&file));
}

/// Leaves name runs of a chunk, in a tree, and an environment belongs to every level.
#[test]
fn runs_of_leaves_are_picked() {
    let leaf = |offset: usize, count: usize| json!({"lods": {"0": {"file": 0, "offset": offset, "count": count}}});
    let split = folder(|meta| {
        meta["tree"] =
            json!({"bound": {}, "children": [leaf(0, 25), {"children": [leaf(25, 35)]}]});
        meta["counts"] = json!([60, 0]);
        meta["count"] = 60.into();
    });
    let whole = folder(|_| {});
    let [split, whole] = [&split, &whole].map(|own| read(own.path(), None).unwrap());
    assert_eq!(split.cloud, whole.cloud);
    let part = folder(|meta| {
        meta["tree"] = json!({"children": [leaf(0, 25), leaf(40, 20)]});
        meta["counts"] = json!([45, 0]);
        meta["count"] = 45.into();
        meta["environment"] = "1_0/meta.json".into();
    });
    let part = read(part.path(), None).unwrap();
    assert_eq!(part.cloud.len(), 45 + 20);
    assert_eq!(part.cloud.means()[25], whole.cloud.means()[40]);
    assert!(
        part.notes
            .not_used()
            .contains(&"Gaussians of 0_0/meta.json (15)".to_owned())
    );
}

#[test]
fn each_defect_is_told() {
    let run = |file: usize, offset: usize, count: usize| json!({"file": file, "offset": offset, "count": count});
    refused(|_| {}, Some(2), "level is 2: expected 0 to 1");
    refused(
        |m| m["version"] = 2.into(),
        None,
        "version is 2: expected 1",
    );
    refused(|m| m["lodLevels"] = 0.into(), None, "lodLevels is 0");
    refused(
        |m| m["count"] = 79.into(),
        None,
        "count is 79: expected 80, as the tree says",
    );
    refused(
        |m| m["counts"] = json!([60, 19]),
        None,
        "counts is 19 at level 1: expected 20",
    );
    refused(
        |m| m["counts"] = json!([60]),
        None,
        "counts is 1 of them: expected 2",
    );
    refused(
        |m| m["tree"] = json!(null),
        None,
        "tree is null: expected an object",
    );
    refused(
        |m| m["tree"]["lods"]["0"]["file"] = 2.into(),
        None,
        "tree.lods.0.file is 2",
    );
    refused(
        |m| m["tree"]["lods"]["x"] = run(0, 0, 1),
        None,
        "is `x`: expected levels 0 to 1",
    );
    let uncounted = |m: &mut Value| {
        m.as_object_mut()
            .unwrap()
            .retain(|key, _| !key.starts_with("count"));
    };
    let far = |m: &mut Value| {
        uncounted(m);
        m["tree"]["lods"]["0"] = run(0, usize::MAX, 9);
    };
    refused(far, None, "expected within the 60 of the chunk");
    let both = |m: &mut Value| {
        uncounted(m);
        m["tree"] =
            json!({"children": [{"lods": {"0": run(0, 0, 9)}}, {"lods": {"0": run(0, 8, 9)}}]});
    };
    refused(both, None, "shared: expected each of them in one leaf");
    for outside in ["../0_0/meta.json", "/etc/meta.json", "0_0/other.json", ""] {
        refused(
            |m| m["filenames"][0] = outside.into(),
            None,
            "filenames is `",
        );
    }
    refused(
        |m| m["filenames"][1] = "0_0/meta.json".into(),
        None,
        "given twice",
    );
    refused(
        |m| m["filenames"][0] = "2_0/meta.json".into(),
        None,
        "cannot read",
    );
    let none = |m: &mut Value| {
        uncounted(m);
        m["tree"] = json!({});
    };
    refused(none, None, "Gaussians of level 0 is 0");
}

#[test]
fn only_levels_have_a_level() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.ksplat");
    std::fs::write(&file, fixture("cloud.0.ksplat")).unwrap();
    let text = read_level(&file, None, Some(0)).unwrap_err().to_string();
    assert!(text.contains("level is 0: expected it left out"), "{text}");
}

#[test]
fn lcc_is_refused_by_name() {
    let text = read(Path::new("a/scene.lcc"), None)
        .unwrap_err()
        .to_string();
    assert!(
        text.starts_with("a/scene.lcc: XGRIDS's LCC is not read: convert it"),
        "{text}"
    );
    assert!(is_splats(Path::new("a.LCC2")));
}
