//! ZIP files by their members.

use std::io::{Cursor, Read as _, Write as _};

use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, ZipArchive};

use super::{Files, Rng};

/// The members of a whole file, in order.
pub(crate) fn members(bytes: &[u8]) -> Files {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).expect("a ZIP file");
    (0..zip.len())
        .map(|i| {
            let mut file = zip.by_index(i).expect("a member");
            let mut bytes = vec![];
            file.read_to_end(&mut bytes).expect("its bytes");
            (file.name().to_owned(), bytes)
        })
        .collect()
}

/// A file of members, of which no two have one name.
pub(crate) fn packed(members: &Files, compression: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    let options = SimpleFileOptions::default().compression_method(compression);
    for (name, bytes) in members {
        if zip.start_file(name, options).is_ok() {
            zip.write_all(bytes).expect("memory takes it");
        }
    }
    zip.finish().expect("memory takes it").into_inner()
}

/// Changes what members there are, in which order, under which names.
pub(crate) fn mutate(members: &mut Files, rng: &mut Rng) {
    if members.is_empty() {
        return;
    }
    let (at, other) = (rng.below(members.len()), rng.below(members.len()));
    match rng.below(7) {
        0 => drop(members.remove(at)),
        1 => {
            let copy = members[at].1.clone();
            members.insert(at, (format!("{}2", members[at].0), copy));
        }
        2 => members.swap(at, other),
        3 => {
            let bytes = std::mem::take(&mut members[at].1);
            members[at].1 = std::mem::replace(&mut members[other].1, bytes);
        }
        4 => members[at].0 = rng.text(&members[at].0),
        5 => members.push(("unheard_of.npy".to_owned(), vec![1, 2, 3])),
        _ => rng.damage(&mut members[at].1),
    }
}
