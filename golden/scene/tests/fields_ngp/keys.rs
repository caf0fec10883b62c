//! Keys of a snapshot: each has a row in the book, and one more is listed or refused.

use super::{at, expanded, load, patched};

/// Sections of a snapshot that are read; of others the name alone is known.
const SECTIONS: [&str; 7] = [
    "encoding",
    "network",
    "dir_encoding",
    "rgb_network",
    "snapshot",
    "snapshot.nerf",
    "snapshot.nerf.dataset",
];

/// The format by its name in the book.
fn format() -> &'static potamoi_base::file_keys::Format {
    let all = potamoi_scene::file_formats::formats();
    all.iter()
        .find(|format| format.name == "Instant-NGP")
        .unwrap()
}

#[test]
fn every_key_of_fixtures_has_a_row() {
    fn walk(value: &rmpv::Value, path: &str, found: &mut Vec<String>) {
        for (key, value) in value.as_map().unwrap() {
            let key = key.as_str().unwrap();
            let path = match path {
                "" => key.to_owned(),
                path => format!("{path}.{key}"),
            };
            match SECTIONS.contains(&&*path) {
                true => walk(value, &path, found),
                false => found.push(path),
            }
        }
    }
    let mut found = vec![];
    let document = rmpv::decode::read_value(&mut &expanded()[..]).unwrap();
    walk(&document, "", &mut found);
    assert!(found.len() > 25, "{found:?}");
    for key in found {
        assert!(format().row(&key).is_some(), "no row for {key}");
    }
}

/// A key more in every section: listed, or refused where its row says so.
#[test]
fn keys_that_are_not_used_are_listed_or_refused() {
    use potamoi_base::file_keys::Fate;
    use rmpv::Value;
    let with = |key: &str| {
        let bytes = patched(|d| *at(d, key) = Value::Map(vec![("x".into(), 1.into())]));
        load(&bytes).map(|field| field.notes().not_used().join(", "))
    };
    for section in SECTIONS {
        let key = format!("{section}.news");
        let listed = with(&key).unwrap();
        assert!(listed.contains(&key), "{key}: {listed}");
    }
    assert!(with("news").unwrap().contains("news"));
    for row in format().keys {
        let key = row.name.replace('*', "x");
        match row.fate {
            Fate::Honoured | Fate::Whole => {}
            Fate::Listed if key.starts_with("dir_encoding.nested.") => {}
            Fate::Listed => assert!(with(&key).unwrap().contains(&key), "{key}"),
            Fate::Refused => {
                let error = with(&key).unwrap_err();
                assert!(
                    error.contains(&format!("`{key}` cannot be honoured")),
                    "{error}"
                );
            }
        }
    }
}
