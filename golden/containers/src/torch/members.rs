//! The members of a checkpoint's archive.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, Read as _};

use zip::{CompressionMethod, ZipArchive};

use super::value::{Arena, StorageLocation};
use crate::archive::Beside;
use potamoi_base::file_keys::told;

type Archive = ZipArchive<BufReader<File>>;

/// Name of the pickle.
const DESCRIPTION: &str = "data.pkl";
/// Members that PyTorch writes beside the pickle and the numbers, and that change no number.
const OWN: [&str; 5] = [
    "byteorder",
    "version",
    ".format_version",
    ".storage_alignment",
    ".data/serialization_id",
];

/// The folder of all members, which is that of the only pickle.
pub(super) fn prefix(archive: &Archive, beside: &Beside) -> Result<String, String> {
    if let Some(twice) = &beside.twice {
        return Err(format!("member {} is given twice", told(twice)));
    }
    let names = archive.file_names();
    let mut all = names.filter_map(|name| name.strip_suffix(DESCRIPTION));
    let first = all.next().ok_or("it has no data.pkl")?;
    match all.next() {
        Some(_) => Err("it has two members data.pkl, and which is meant is not said".to_owned()),
        None => Ok(first.to_owned()),
    }
}

/// Keys of members that are not read, and of surplus numbers.
pub(super) fn unknown(archive: &Archive, prefix: &str, arena: &Arena) -> Vec<String> {
    let places = arena.storages.iter().map(|own| &own.place);
    let numbers: HashSet<String> = (places)
        .filter_map(|place| match place {
            StorageLocation::Member(key) => Some(format!("data/{}", arena.texts[*key])),
            StorageLocation::Within(..) => None,
        })
        .collect();
    let is_known = |name: &str| {
        let own = name.strip_prefix(prefix);
        own.is_some_and(|n| n == DESCRIPTION || OWN.contains(&n) || numbers.contains(n))
    };
    let names = archive.file_names().filter(|name| !is_known(name));
    names.map(|name| format!("member {}", told(name))).collect()
}

/// A member of at most `most` bytes; longer ones are cut off.
pub(super) fn member(
    archive: &mut ZipArchive<BufReader<File>>,
    name: &str,
    most: u64,
) -> Result<Vec<u8>, String> {
    let file = archive.by_name(name);
    let file = file.map_err(|e| format!("member {name}: {e}"))?;
    // Few packed bytes could be any number of plain ones.
    if file.compression() != CompressionMethod::Stored {
        return Err(format!(
            "member {name} is packed: PyTorch stores plain bytes"
        ));
    }
    let mut bytes = vec![];
    file.take(most)
        .read_to_end(&mut bytes)
        .map_err(|e| format!("member {name}: {e}"))?;
    Ok(bytes)
}

/// Size of a member in bytes; 0 if it cannot be read.
pub(super) fn length(archive: &mut Archive, name: &str) -> u64 {
    archive.by_name(name).map_or(0, |own| own.size())
}
