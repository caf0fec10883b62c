//! A format added as in docs/adding/format.md is read, refused and listed like any other.

use super::*;
use potamoi_base::file_keys::{Fate, Format, Key, Notes};

/// Centres as text, a Gaussian a line, each as large and as bright as the others.
static FORMAT: Format = Format {
    name: "Dots",
    files: "`.dots`: a centre a line",
    keys: &[Key {
        name: "centre",
        fate: Fate::Honoured,
        about: "three numbers",
    }],
    others: Fate::Refused,
};

static READER: Reader = Reader {
    endings: &["dots"],
    formats: &[&FORMAT],
    read: |path, origin| raw(&whole(path)?, origin),
};

fn raw(bytes: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let text = String::from_utf8_lossy(bytes);
    let mut centres = vec![];
    for (n, line) in text.lines().enumerate() {
        let numbers: Vec<f32> = line.split(' ').filter_map(|v| v.parse().ok()).collect();
        let centre = <[f32; 3]>::try_from(numbers);
        let field = format!("line {}", n + 1);
        centres.push(centre.map_err(|_| name.field(field, line, "three numbers"))?);
    }
    let count = centres.len();
    let cloud = Cloud::new(
        0,
        centres,
        vec![[-3.0; 3]; count],
        vec![[1.0, 0.0, 0.0, 0.0]; count],
        vec![2.0; count],
        vec![[0.5; 3]; count],
    );
    let cloud = cloud.map_err(|e| name.cloud(e))?;
    Ok(Raw::new(cloud, Notes::default()))
}

#[test]
fn an_added_format_is_read_and_refused_like_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.DOTS");
    std::fs::write(&path, "0 0 1\n0 0.5 2\n").unwrap();
    let with: Vec<&Reader> = READERS.iter().copied().chain([&READER]).collect();

    let unknown = read_by(&READERS, &path, None, None)
        .unwrap_err()
        .to_string();
    assert!(unknown.contains(".ply, .splat, .spz, .sog"), "{unknown}");
    let loaded = read_by(&with, &path, None, None).unwrap();
    assert_eq!(loaded.cloud.means(), [[0.0, 0.0, 1.0], [0.0, 0.5, 2.0]]);
    // Whoever reads it says where its axes point, as of any other.
    let axes = "right-up-back".parse().unwrap();
    let turned = read_by(&with, &path, Some(axes), None).unwrap();
    assert_eq!(turned.cloud.means()[1], [0.0, -0.5, -2.0]);

    std::fs::write(&path, "0 0 1\n0 half 2\n").unwrap();
    let refused = read_by(&with, &path, None, None).unwrap_err().to_string();
    assert!(
        refused.contains("a.DOTS") && refused.contains("line 2"),
        "{refused}"
    );
}

/// Every reader has an extension of its own, and every form has keys; otherwise the choice of
/// reader would be ambiguous.
#[test]
fn every_reader_has_an_ending_of_its_own_and_keys() {
    let mut all = endings();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), endings().len());
    for reader in READERS {
        // Levels of detail are known by the name of their file.
        let is_named = std::ptr::eq(reader, &sog::levels::KEYS);
        assert!(reader.endings.is_empty() == is_named && !reader.formats.is_empty());
        for ending in reader.endings {
            assert_eq!(*ending, ending.to_lowercase());
            let keys = reader.formats.iter().map(|format| format.keys.len());
            assert!(keys.min() > Some(0), "{ending}");
        }
    }
}
