//! Sets are replaced as a whole, and files of others stay.
#![allow(clippy::unwrap_used)]

use super::*;

fn set(names: &[&str], text: &str) -> Set {
    names
        .iter()
        .map(|n| ((*n).to_owned(), format!("{text} {n}\n")))
        .collect()
}

fn replaced(
    out: &Path,
    set: &Set,
    hash: &str,
    overwrite: bool,
) -> Result<Vec<String>, FileSetError> {
    replace(out, set, hash, overwrite, &finish)
}

/// All files of a folder, except the manifest.
fn content(out: &Path) -> Set {
    let mut names = vec![];
    below(out, out, &mut names).unwrap();
    let names = names.iter().map(|n| n.display().to_string());
    names
        .filter(|n| n != MANIFEST)
        .map(|n| (n.clone(), fs::read_to_string(out.join(&n)).unwrap()))
        .collect()
}

/// A folder that is a link points elsewhere: nothing is written or removed there.
#[test]
fn folders_that_are_links_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let [out, other] = ["o", "elsewhere"].map(|name| folder.path().join(name));
    for path in [&out, &other] {
        fs::create_dir(path).unwrap();
    }
    std::os::unix::fs::symlink(&other, out.join("unit")).unwrap();
    fs::write(out.join("tb"), "a file").unwrap();
    for (name, said) in [("unit/a.v", "is a link"), ("tb/a.v", "is no folder")] {
        for overwrite in [false, true] {
            let error = replaced(&out, &set(&[name], "new"), "c", overwrite).unwrap_err();
            assert!(error.to_string().contains(said), "{error}");
        }
    }
    assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
}

/// Another emission's unit goes only where that is asked for.
#[test]
fn a_folder_that_the_set_has_no_file_in_stays() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let (old, new) = (set(&["u/a.v", "v/b.v"], "old"), set(&["v/b.v"], "new"));
    replaced(&out, &old, "1", false).unwrap();
    let error = replaced(&out, &new, "1", false).unwrap_err().to_string();
    assert!(error.contains("has u of an earlier emission"), "{error}");
    assert_eq!(content(&out), old);
    assert_eq!(replaced(&out, &new, "1", true).unwrap(), ["u/a.v"]);
    assert_eq!(content(&out), new);
}

#[test]
fn a_set_replaces_another_and_leaves_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let (old, new) = (set(&["u/a.v", "u/b.v"], "old"), set(&["u/a.v", "c"], "new"));
    replaced(&out, &old, "1", false).unwrap();
    fs::write(out.join("u/mine.v"), "mine").unwrap();
    assert_eq!(replaced(&out, &new, "2", false).unwrap(), ["u/b.v"]);
    let mut expected = new.clone();
    expected.insert("u/mine.v".to_owned(), "mine".to_owned());
    assert_eq!(content(&out), expected);
    assert!(replaced(&out, &new, "2", false).unwrap().is_empty());
}

/// A manifest that no emission wrote is a user's file.
#[test]
fn a_foreign_manifest_stays() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let new = set(&["a.v"], "new");
    let manifest = out.join(MANIFEST);
    let write = |overwrite| replaced(out, &new, "1", overwrite).map_err(|e| e.to_string());
    fs::write(&manifest, "{\"mine\": 1}").unwrap();
    assert!(write(false).unwrap_err().contains(MANIFEST));
    assert_eq!(fs::read_to_string(&manifest).unwrap(), "{\"mine\": 1}");
    write(true).unwrap();
    write(false).unwrap();

    fs::remove_file(&manifest).unwrap();
    fs::write(out.join("victim"), "victim").unwrap();
    std::os::unix::fs::symlink("victim", &manifest).unwrap();
    for overwrite in [false, true] {
        assert!(write(overwrite).unwrap_err().contains("a link"));
    }
    assert_eq!(fs::read_to_string(&manifest).unwrap(), "victim");
    fs::remove_file(&manifest).unwrap();
    let fifo = std::process::Command::new("mkfifo").arg(&manifest).status();
    assert!(fifo.unwrap().success());
    for overwrite in [false, true] {
        assert!(write(overwrite).unwrap_err().contains("never replaced"));
    }
}

#[test]
fn edited_and_foreign_files_stay_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let (old, new) = (set(&["a.v", "b.v"], "old"), set(&["a.v", "c.v"], "new"));
    fs::write(out.join("c.v"), "foreign").unwrap();
    replaced(out, &old, "1", false).unwrap();
    fs::write(out.join("b.v"), "edited").unwrap();
    let before = content(out);
    let said = replaced(out, &new, "2", false).unwrap_err().to_string();
    assert!(said.contains("b.v") && said.contains("c.v") && said.contains("--overwrite"));
    assert!(!said.contains("a.v"), "{said}");
    assert_eq!(content(out), before);
    replaced(out, &new, "2", true).unwrap();
    assert_eq!(content(out), new);
}

#[test]
fn a_run_that_was_cut_off_left_the_old_set_or_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let (old, new) = (set(&["a.v", "b.v"], "old"), set(&["a.v", "c.v"], "new"));
    replaced(out, &old, "1", false).unwrap();
    // Cut off while it was written.
    fs::create_dir(out.join(".potamoi-emit-left1234")).unwrap();
    fs::write(out.join(".potamoi-emit-left1234/a.v"), "half").unwrap();
    replaced(out, &old, "1", false).unwrap();
    assert_eq!(content(out), old);
    // Cut off after one of its files had its place.
    write(out, &new, "2", &["b.v".to_owned()]).unwrap();
    fs::rename(out.join(WHOLE).join(NEW).join("a.v"), out.join("a.v")).unwrap();
    finish(out).unwrap();
    assert_eq!(content(out), new);
    assert_eq!(manifest_of(out).len(), 2);
    // Cut off when nothing but the folder was left to remove.
    fs::create_dir(out.join(WHOLE)).unwrap();
    replaced(out, &new, "2", false).unwrap();
    assert_eq!(content(out), new);
}

/// Until all files are in place the old manifest remains: the new one is moved last.
#[test]
fn the_manifest_takes_its_place_last() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let (old, new) = (set(&["a.v", "z.v"], "old"), set(&["a.v", "z.v"], "new"));
    replaced(out, &old, "1", false).unwrap();
    let before = fs::read_to_string(out.join(MANIFEST)).unwrap();
    write(out, &new, "2", &[]).unwrap();
    // The last file cannot take its place.
    fs::remove_file(out.join("z.v")).unwrap();
    fs::create_dir(out.join("z.v")).unwrap();
    finish(out).unwrap_err();
    assert_eq!(fs::read_to_string(out.join("a.v")).unwrap(), new["a.v"]);
    assert_eq!(fs::read_to_string(out.join(MANIFEST)).unwrap(), before);
    fs::remove_dir(out.join("z.v")).unwrap();
    finish(out).unwrap();
    assert_eq!(content(out), new);
    assert_ne!(fs::read_to_string(out.join(MANIFEST)).unwrap(), before);
}

#[test]
fn devices_and_links_are_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    std::os::unix::fs::symlink("victim", out.join("a.v")).unwrap();
    for overwrite in [false, true] {
        let said = replaced(out, &set(&["a.v"], "new"), "1", overwrite).unwrap_err();
        assert!(said.to_string().contains("is a link"), "{said}");
    }
    fs::remove_file(out.join("a.v")).unwrap();
    let pipe = out.join("a.v");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    for overwrite in [false, true] {
        let said = replaced(out, &set(&["a.v"], "new"), "1", overwrite).unwrap_err();
        assert!(said.to_string().contains("a FIFO"), "{said}");
    }
}

#[test]
fn a_manifest_reaches_no_file_outside() {
    for bad in ["../a", "/a", "a/../../b"] {
        assert!(!is_inside(bad), "{bad}");
    }
    assert!(is_inside("gathering_unit/a.v"));
}
