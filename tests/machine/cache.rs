use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use super::{expect, files};
use crate::common::json;

const MODEL: &str = "$P model --scene lantern --width 12 --frames 2 --window 2 --json";

#[test]
fn all_that_is_kept_lies_in_the_folder_and_is_listed_and_cleared() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(at, 0, &format!("{MODEL} a.json"));
    let mut inside = fs::read_dir(at).unwrap().map(|e| e.unwrap().file_name());
    let known = ["a.json", "cache"];
    assert!(inside.all(|name| known.contains(&name.to_str().unwrap())));
    for made in ["cache", "cache/work"] {
        let mode = fs::metadata(at.join(made)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o700, "{made}");
    }
    let said = expect(at, 0, "$P cache --list --json l.json");
    assert!(said.contains("work counted on rendered frames"), "{said}");
    let list = json(&at.join("l.json"));
    let entries = list["entries"].as_array().unwrap();
    assert_eq!(entries.len(), files(&at.join("cache")).len());
    assert!(
        entries
            .iter()
            .all(|e| e["bytes"].as_u64().unwrap() > 0 && e["kind"] == "work")
    );
    // What somebody else keeps there stays.
    fs::create_dir(at.join("cache/work/thesis")).unwrap();
    fs::write(at.join("cache/work/thesis/one.tex"), "mine").unwrap();
    let said = expect(at, 0, "$P cache --clear");
    assert!(said.contains("left alone: cache/work/thesis") || said.contains("/cache/work/thesis"));
    assert_eq!(files(&at.join("cache")), ["work/thesis/one.tex"]);
    expect(at, 0, "$P cache");
}

/// Edited counts are counted again, and it is said.
#[test]
fn edited_counts_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(at, 0, &format!("{MODEL} a.json"));
    let kept = files(&at.join("cache"));
    for name in &kept {
        let path = at.join("cache").join(name);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen("\"pixels\":", "\"pixels\":1", 1)).unwrap();
    }
    let said = expect(at, 0, &format!("{MODEL} b.json"));
    assert!(said.contains("its checksum does not fit"), "{said}");
    let without = |name| {
        let mut report = json(&at.join(name));
        forget(&mut report, &["was_kept", "seconds"]);
        report
    };
    assert_eq!(without("a.json"), without("b.json"));
}

fn forget(value: &mut serde_json::Value, names: &[&str]) {
    match value {
        serde_json::Value::Object(fields) => {
            names.iter().for_each(|name| {
                fields.remove(*name);
            });
            fields.values_mut().for_each(|v| forget(v, names));
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(|v| forget(v, names)),
        _ => {}
    }
}

#[test]
fn a_folder_that_others_can_write_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(at, 0, "mkdir -m 0777 cache");
    let said = expect(at, 2, &format!("{MODEL} a.json"));
    assert!(
        said.contains("others than its owner can write it (mode 0777)"),
        "{said}"
    );
    expect(at, 2, "$P cache --list");
    expect(at, 0, "chmod 0700 cache; mkdir -m 0770 cache/work");
    let said = expect(at, 2, &format!("{MODEL} a.json"));
    assert!(said.contains("chmod go-w"), "{said}");
}

#[test]
fn without_a_folder_it_is_said_what_to_set() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let bare = format!("env -u HOME -u XDG_CACHE_HOME -u POTAMOI_CACHE {MODEL} a.json");
    let said = expect(at, 2, &bare);
    assert!(said.contains("set POTAMOI_CACHE"), "{said}");
}
