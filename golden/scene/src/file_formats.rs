//! All file formats with their keys.

use crate::compact_3dgs;
use potamoi_base::file_keys::Format;
use potamoi_fields::algorithms;
use potamoi_gaussians::files;

/// Every format, in the order of the book's table.
#[must_use]
pub fn formats() -> Vec<&'static Format> {
    let mut all = vec![
        &super::description::DESCRIPTION,
        &super::camera_file::CAMERAS,
        &super::transforms::PATH,
        &super::transforms::FRAME,
        &super::colmap::FOLDER,
        &super::colmap::INTRINSICS,
        &super::colmap::POSES,
        &super::picture_files::PNG,
        &super::picture_files::EXR,
    ];
    all.extend(super::trajectory::FORMATS);
    all.extend(algorithms::files().map(|file| file.format));
    all.extend(files::READERS.iter().flat_map(|reader| reader.formats));
    all.push(&compact_3dgs::FORMAT);
    all.extend([&potamoi_warp::mesh::OBJ, &potamoi_warp::mesh::PLY]);
    all
}

/// The names of algorithms whose models come in files, each with its file extensions.
pub fn field_files() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    let files = |field: &&'static potamoi_fields::Algorithm| {
        Some((field.name, field.file.as_ref()?.endings))
    };
    algorithms::FIELDS.iter().filter_map(files)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fmt::Write as _;
    use std::path::Path;

    use super::*;

    fn table() -> String {
        let mut text = String::new();
        for format in formats() {
            writeln!(text, "\n### {}\n\n{}\n", format.name, format.files).unwrap();
            text += "| key | | |\n|---|---|---|\n";
            for key in format.keys {
                let (name, fate) = (key.name, key.fate.name());
                writeln!(text, "| `{name}` | {fate} | {} |", key.about).unwrap();
            }
            writeln!(text, "| any other | {} | |", format.others.name()).unwrap();
        }
        text + "\n"
    }

    #[test]
    fn the_table_of_the_book_is_current() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/files.md");
        let text = std::fs::read_to_string(&page).unwrap();
        let marks = ["<!-- formats -->\n", "<!-- end of formats -->\n"];
        let (before, rest) = text.split_once(marks[0]).unwrap();
        let (found, after) = rest.split_once(marks[1]).unwrap();
        let expected = table();
        if std::env::var_os("POTAMOI_REFRESH").is_some() {
            let whole = [before, marks[0], &expected, marks[1], after].concat();
            return potamoi_base::files::write(&page, whole.as_bytes()).unwrap();
        }
        assert!(
            found == expected,
            "docs/reference/files.md is not what the readers say; make refresh writes it, then git diff"
        );
    }

    #[test]
    fn every_key_says_what_it_means() {
        for format in formats() {
            for (at, key) in format.keys.iter().enumerate() {
                assert!(!key.about.is_empty(), "{}: {}", format.name, key.name);
                let same = format.keys[..at].iter().any(|k| k.name == key.name);
                assert!(!same, "{}: two rows for {}", format.name, key.name);
            }
        }
    }

    /// The first matching row applies, so a row must not follow one that matches all of its keys
    /// with another treatment.
    #[test]
    fn no_row_stands_behind_one_that_takes_its_keys() {
        for format in formats() {
            for key in format.keys {
                for inside in ["", "0"] {
                    let name = key.name.replace('*', inside);
                    let fate = format.row(&name).map(|row| row.fate);
                    assert_eq!(fate, Some(key.fate), "{}: {name}", format.name);
                }
            }
        }
    }
}
