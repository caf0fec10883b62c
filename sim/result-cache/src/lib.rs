//! Cache of results between runs. A key of named parts finds an entry, and a checksum verifies it.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use potamoi_result_cache::{Key, read, write};
//!
//! let folder = tempfile::tempdir()?;
//! let key = Key::new("areas", "1").text("library", "osu018");
//! let file = key.file(folder.path(), "json");
//! assert_eq!(read::<Vec<f64>>(&file), None);
//! write(&file, &[3.5, 4.0])?;
//! assert_eq!(read(&file), Some(vec![3.5, 4.0]));
//! # Ok(())
//! # }
//! ```

pub mod listing;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use potamoi_base::files;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Header of every cached file, with the version of its format.
const FORMAT: &str = "potamoi-kept 2";
/// Hexadecimal digits of a key.
const KEY_DIGITS: usize = 32;
/// Largest size of a cached file, in bytes.
const LARGEST: u64 = 1 << 32;

/// Key of a result: all parts that it depends on.
///
/// Parts are hashed in serialised form: numbers bit by bit, fields by name.
#[derive(Debug, Clone)]
pub struct Key {
    kind: String,
    parts: Vec<(&'static str, blake3::Hash)>,
}

impl Key {
    /// A key for a kind of result, such as `path`. `version` is that of its producer, raised where
    /// results change. The program's version is a part as well.
    #[must_use]
    pub fn new(kind: impl Into<String>, version: &str) -> Self {
        let own = Self {
            kind: kind.into(),
            parts: vec![],
        };
        own.text("version", version)
            .text("program", env!("CARGO_PKG_VERSION"))
    }

    /// Adds a text.
    #[must_use]
    pub fn text(self, part: &'static str, text: &str) -> Self {
        self.hash(part, blake3::hash(text.as_bytes()))
    }

    /// Adds a serialised value.
    #[must_use]
    pub fn value(self, part: &'static str, value: &impl Serialize) -> Self {
        self.hash(part, potamoi_base::content_hash::hash_of(value))
    }

    /// Adds a part that is already hashed.
    #[must_use]
    pub fn hash(mut self, part: &'static str, hash: blake3::Hash) -> Self {
        self.parts.push((part, hash));
        self
    }

    /// Names of the parts, in order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.parts.iter().map(|(name, _)| *name)
    }

    /// The key as 32 hexadecimal digits; they differ where any part does.
    #[must_use]
    pub fn hex(&self) -> String {
        let mut all = blake3::Hasher::new();
        let mut with = |bytes: &[u8]| {
            all.update(&(bytes.len() as u64).to_le_bytes());
            all.update(bytes);
        };
        with(self.kind.as_bytes());
        for (name, hash) in &self.parts {
            with(name.as_bytes());
            with(hash.as_bytes());
        }
        all.finalize().to_hex()[..KEY_DIGITS].to_owned()
    }

    /// File of the result in a folder.
    #[must_use]
    pub fn file(&self, folder: &Path, ending: &str) -> PathBuf {
        folder.join(format!("{}-{}.{ending}", self.kind, self.hex()))
    }
}

/// Reads the result in a file; `None` if it is missing, truncated, modified or of another key.
/// Reports an invalid file, which will be replaced.
#[must_use]
pub fn read<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let bytes = read_bytes(path)?;
    let found = serde_json::from_slice(&bytes).ok();
    if found.is_none() {
        not_believed(path, "it is of another form");
    }
    found
}

/// As [`read`], for text.
#[must_use]
pub fn read_text(path: &Path) -> Option<String> {
    String::from_utf8(read_bytes(path)?).ok()
}

/// Writes a result.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, result: &impl Serialize) -> std::io::Result<()> {
    write_bytes(path, &serde_json::to_vec(result)?)
}

/// As [`write()`], for text.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(path: &Path, text: &str) -> std::io::Result<()> {
    write_bytes(path, text.as_bytes())
}

fn write_bytes(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let hash = blake3::hash(bytes).to_hex();
    let mut all = format!("{FORMAT} {hash} {}\n", name(path)).into_bytes();
    all.extend_from_slice(bytes);
    // Whatever lies there that is no kept file goes: a link, not what it leads to.
    if let Ok(found) = std::fs::symlink_metadata(path)
        && found.is_dir()
    {
        std::fs::remove_dir_all(path)?;
    }
    let mut file = files::Unfinished::private_beside(path)?;
    file.write_all(&all)?;
    file.finish()
}

/// Whether a name is that of a cached file: apart from its extension it ends with the digits of a
/// key. Other files in a cache folder belong to the user.
#[must_use]
pub fn ends_with_key(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default();
    let digits = stem.rsplit_once('-').map_or("", |(_, digits)| digits);
    let is_hex = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
    digits.len() == KEY_DIGITS && digits.bytes().all(is_hex)
}

/// Name of a cached file, which contains its key.
fn name(path: &Path) -> std::borrow::Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}

fn read_bytes(path: &Path) -> Option<Vec<u8>> {
    if std::fs::symlink_metadata(path).is_err() {
        return None;
    }
    if !potamoi_verilated::cache::is_own(path) {
        not_believed(path, "others can write it");
        return None;
    }
    let mut bytes = files::read(path, LARGEST).ok().flatten()?;
    let end = bytes.iter().position(|b| *b == b'\n').unwrap_or(0);
    let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let body = bytes.split_off((end + 1).min(bytes.len()));
    let said = head.strip_prefix(FORMAT).map(str::trim);
    let hash = blake3::hash(&body).to_hex();
    match said.and_then(|said| said.split_once(' ')) {
        Some((found, _)) if found != hash.as_str() => {
            not_believed(path, "its checksum does not fit");
            None
        }
        Some((_, own)) if own == name(path) => Some(body),
        Some(_) => {
            not_believed(path, "it was kept for something else");
            None
        }
        None => {
            not_believed(path, "it is of another form");
            None
        }
    }
}

fn not_believed(path: &Path, why: &str) {
    // Standard error may be closed.
    let _ = writeln!(
        std::io::stderr().lock(),
        "note: the kept result {} is not used, since {why}: it is made again",
        path.display()
    );
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_result_is_believed_only_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.json");
        write(&path, &[1000.0, 0.1]).unwrap();
        assert_eq!(read::<[f64; 2]>(&path), Some([1000.0, 0.1]));
        let text = std::fs::read_to_string(&path).unwrap();
        let harms = [
            text.replace("1000.0", "100.0"),
            text[..text.len() - 1].to_owned(),
            text.replace(FORMAT, "potamoi-kept 1"),
            text.lines().nth(1).unwrap().to_owned(),
            String::new(),
        ];
        for harm in harms {
            std::fs::write(&path, &harm).unwrap();
            assert_eq!(read::<[f64; 2]>(&path), None, "{harm}");
        }
        std::fs::write(&path, &text).unwrap();
        assert!(read::<[f64; 2]>(&path).is_some());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            let open = std::fs::Permissions::from_mode(0o666);
            std::fs::set_permissions(&path, open).unwrap();
            assert_eq!(read::<[f64; 2]>(&path), None);
        }
    }

    /// An entry in the place of a cached file is replaced itself; the target of a link stays.
    #[test]
    fn strange_entries_are_replaced_and_never_written_through() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("victim"), "mine").unwrap();
        std::os::unix::fs::symlink(at("victim"), at("link.json")).unwrap();
        std::os::unix::fs::symlink(at("nowhere"), at("dangling.json")).unwrap();
        std::fs::create_dir(at("folder.json")).unwrap();
        std::fs::write(at("folder.json/inside"), "").unwrap();
        let fifo = std::process::Command::new("mkfifo")
            .arg(at("fifo.json"))
            .status();
        assert!(fifo.unwrap().success());
        for name in ["link.json", "dangling.json", "folder.json", "fifo.json"] {
            assert_eq!(read::<u32>(&at(name)), None, "{name}");
            write(&at(name), &7).unwrap();
            assert!(
                std::fs::symlink_metadata(at(name)).unwrap().is_file(),
                "{name}"
            );
            assert_eq!(read(&at(name)), Some(7), "{name}");
            let mode = std::fs::metadata(at(name)).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "{name}");
        }
        assert_eq!(std::fs::read_to_string(at("victim")).unwrap(), "mine");
        assert!(!at("nowhere").exists());
    }

    #[test]
    fn names_of_kept_files_are_known() {
        let path = Key::new("some-kind", "1").file(Path::new(""), "json");
        let name = path.to_str().unwrap();
        let key = &name["some-kind-".len()..name.len() - ".json".len()];
        assert!(ends_with_key(name) && ends_with_key(&format!("unit-{key}")));
        let short = &name[..name.len() - 6];
        for other in ["thesis", "my-photos", key, short, &name.to_uppercase(), ""] {
            assert!(!ends_with_key(other), "{other}");
        }
    }

    #[test]
    fn a_result_under_another_name_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let file = |value: u32| {
            Key::new("k", "1")
                .value("v", &value)
                .file(folder.path(), "json")
        };
        write(&file(1), &1.0).unwrap();
        std::fs::copy(file(1), file(2)).unwrap();
        assert_eq!(read::<f64>(&file(1)), Some(1.0));
        assert_eq!(read::<f64>(&file(2)), None);
    }

    #[test]
    fn parts_do_not_run_together_and_numbers_are_bits() {
        let key = |part, value: f64| Key::new("k", "1").value(part, &value).hex();
        let all = [
            key("a", 0.0),
            key("a", -0.0),
            key("a", f64::NAN),
            key("a", f64::INFINITY),
            key("b", 0.0),
            Key::new("l", "1").value("a", &0.0).hex(),
            Key::new("k", "2").value("a", &0.0).hex(),
        ];
        let mut different = all.to_vec();
        different.sort();
        different.dedup();
        assert_eq!(different.len(), all.len());
        assert_eq!(key("a", 0.0), all[0]);
    }
}
