//! Content-addressed folder of build products.
//!
//! A product is made in a temporary folder beside its place and then renamed, so that it is present
//! as a whole or not at all. Its manifest has the hash of every file: a damaged product is moved
//! away and made again.

use crate::{
    Error,
    cache::{self, Scratch},
    toolchain::SEE_DOCTOR,
};
use std::{
    collections::BTreeMap,
    fs,
    io::Write as _,
    os::unix::fs::PermissionsExt as _,
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

const FORMAT: &str = "potamoi-verilated 2";
const MANIFEST: &str = "manifest";
const ATTEMPTS: usize = 8;

/// Folder in the temporary one whose content is discarded.
pub(crate) const SCRATCH: &str = "scratch";

/// Output of a maker: files by relative name, and note lines.
pub(crate) struct Product {
    pub(crate) files: Vec<String>,
    pub(crate) notes: Vec<String>,
}

/// A complete product in its place.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) folder: PathBuf,
    pub(crate) notes: Vec<String>,
    pub(crate) cached: bool,
}

impl Entry {
    /// Ports with their C++ names, from the header stored with a product's objects.
    pub(crate) fn members(&self) -> Result<Vec<crate::ports::Member>, Error> {
        let header = self.folder.join("obj/Vm.h");
        let text = fs::read_to_string(&header).map_err(|e| Error::io("read", &header, &e))?;
        crate::ports::parse_header(&text).map_err(|line| Error::Peer(format!("{header:?}: {line}")))
    }
}

/// Key of a product: a hash over length-prefixed fields.
pub(crate) struct Key(blake3::Hasher);

impl Key {
    pub(crate) fn new(kind: &str) -> Self {
        Key(blake3::Hasher::new()).with(FORMAT).with(kind)
    }

    pub(crate) fn with(mut self, field: &str) -> Self {
        self.0.update(&(field.len() as u64).to_le_bytes());
        self.0.update(field.as_bytes());
        self
    }

    pub(crate) fn hex(&self) -> String {
        self.0.finalize().to_hex().as_str()[..32].to_string()
    }
}

/// Fetches the product of `key`, or makes it.
pub(crate) fn fetch(
    cache: &Path,
    name: &str,
    key: &Key,
    make: &dyn Fn(&Path) -> Result<Product, Error>,
) -> Result<Entry, Error> {
    let cache = &cache::claim(cache)?;
    let place = cache.join(format!("{name}-{}", key.hex()));
    let lock = lock_of(&place);
    let _held = lock.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(notes) = verified(&place) {
        return Ok(entry(place, notes, true));
    }
    if fs::symlink_metadata(&place).is_ok() {
        // Standard error may be closed.
        let _ = writeln!(
            std::io::stderr().lock(),
            "note: the built model {} is not used, since it is damaged, was made for something \
             else, or others can write it: it is made again",
            place.display()
        );
    }
    let temporary = Scratch::within(cache, cache::BUILDING)
        .map_err(|e| Error::io("create a temporary folder in", cache, &e))?;
    let folder = temporary.path();
    let scratch = folder.join(SCRATCH);
    fs::create_dir(&scratch).map_err(|e| Error::io("create the folder", &scratch, &e))?;
    let product = make(folder)?;
    fs::remove_dir_all(&scratch).map_err(|e| Error::io("remove", &scratch, &e))?;
    let manifest = folder.join(MANIFEST);
    fs::write(&manifest, describe(folder, &place, &product)?)
        .map_err(|e| Error::io("write", &manifest, &e))?;
    let files = product.files.iter().map(String::as_str);
    for name in files.chain([MANIFEST]) {
        close_to_others(folder, name)?;
    }
    settle(cache, folder, place)
}

fn entry(folder: PathBuf, notes: Vec<String>, cached: bool) -> Entry {
    Entry {
        folder,
        notes,
        cached,
    }
}

/// Renames the new product into place, unless another process stored a complete one first.
fn settle(cache: &Path, made: &Path, place: PathBuf) -> Result<Entry, Error> {
    let mut last = None;
    for _ in 0..ATTEMPTS {
        match fs::rename(made, &place) {
            Ok(()) => {
                if let Some(notes) = verified(&place) {
                    return Ok(entry(place, notes, false));
                }
                break;
            }
            Err(e) => last = Some(e),
        }
        if let Some(notes) = verified(&place) {
            return Ok(entry(place, notes, false));
        }
        // What is in the way is damaged. Another process may move it first, which is as good.
        if let Ok(trash) = Scratch::within(cache, cache::TRASH) {
            let _ = fs::rename(&place, trash.path().join("damaged"));
        }
    }
    let reason = last.unwrap_or_else(|| std::io::Error::other("it does not stay whole"));
    Err(Error::io("put a built model at", &place, &reason))
}

fn lock_of(place: &Path) -> Arc<Mutex<()>> {
    static LOCKS: Mutex<BTreeMap<PathBuf, Arc<Mutex<()>>>> = Mutex::new(BTreeMap::new());
    let mut locks = LOCKS.lock().unwrap_or_else(PoisonError::into_inner);
    locks.entry(place.to_path_buf()).or_default().clone()
}

fn hash_file(path: &Path) -> std::io::Result<String> {
    Ok(blake3::hash(&fs::read(path)?).to_hex().to_string())
}

/// Manifest of a product in a folder, for a place whose name holds its key.
fn describe(folder: &Path, place: &Path, product: &Product) -> Result<String, Error> {
    let mut text = format!("{FORMAT}\nof {}\n", name_of(place));
    for name in &product.files {
        let path = folder.join(name);
        if !fs::metadata(&path).is_ok_and(|found| found.is_file() && found.len() > 0) {
            return Err(Error::Broken {
                tool: "the C++ compiler".into(),
                doing: format!("making {name}"),
                problem: format!("it ended well, but left no {name}, or an empty one"),
                remedy: SEE_DOCTOR,
            });
        }
        let hash = hash_file(&path).map_err(|e| Error::io("read", &path, &e))?;
        text += &format!("file {hash} {name}\n");
    }
    for note in &product.notes {
        text += &format!("note {note}\n");
    }
    let hash = blake3::hash(text.as_bytes()).to_hex();
    text += &format!("end {hash}\n");
    Ok(text)
}

fn name_of(place: &Path) -> String {
    let name = place.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Removes other users' write permission from a product's file and its folders, whatever the umask.
fn close_to_others(product: &Path, name: &str) -> Result<(), Error> {
    let mut path = product.join(name);
    let mut mode = if path.extension().is_none() && name != MANIFEST {
        0o700
    } else {
        0o600
    };
    while path != product {
        fs::set_permissions(&path, fs::Permissions::from_mode(mode))
            .map_err(|e| Error::io("set the permissions of", &path, &e))?;
        (path, mode) = (path.parent().unwrap_or(product).to_path_buf(), 0o700);
    }
    Ok(())
}

/// Whether a regular file of a product and all its folders belong to this user only. Other kinds of
/// file are refused: opening a pipe would block.
fn is_own(place: &Path, name: &str) -> bool {
    let inside = Path::new(name);
    let is_plain = (inside.components()).all(|c| matches!(c, Component::Normal(_)));
    is_plain
        && fs::symlink_metadata(place.join(inside)).is_ok_and(|found| found.is_file())
        && inside
            .ancestors()
            .all(|part| cache::is_own(&place.join(part)))
}

/// Notes of the product at `place`, if it is complete, unmodified, and owned by this user.
fn verified(place: &Path) -> Option<Vec<String>> {
    if !is_own(place, MANIFEST) {
        return None;
    }
    let text = fs::read_to_string(place.join(MANIFEST)).ok()?;
    let (body, end) = text.split_at(text.rfind("end ")?);
    let hash = blake3::hash(body.as_bytes()).to_hex();
    if end != format!("end {hash}\n") {
        return None;
    }
    let mut lines = body.lines();
    // One that was made for another key is damaged, however whole.
    if lines.next()? != FORMAT || lines.next()? != format!("of {}", name_of(place)) {
        return None;
    }
    let mut notes = Vec::new();
    for line in lines {
        match line.split_once(' ')? {
            ("file", rest) => {
                let (hash, name) = rest.split_once(' ')?;
                if !is_own(place, name) || hash_file(&place.join(name)).ok()? != hash {
                    return None;
                }
            }
            ("note", note) => notes.push(note.to_string()),
            _ => return None,
        }
    }
    Some(notes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn make(count: &AtomicUsize) -> impl Fn(&Path) -> Result<Product, Error> {
        move |folder| {
            count.fetch_add(1, Ordering::Relaxed);
            fs::write(folder.join("a"), "alpha").unwrap();
            Ok(Product {
                files: vec!["a".into()],
                notes: vec!["one two".into()],
            })
        }
    }

    #[test]
    fn any_damage_is_found_and_repaired() {
        let cache = tempfile::tempdir().unwrap();
        let key = Key::new("test").with("x");
        let count = AtomicUsize::new(0);
        let first = fetch(cache.path(), "n", &key, &make(&count)).unwrap();
        let file = first.folder.join("a");
        let open = |path: &Path| {
            fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
        };
        let damage: [&dyn Fn(); 9] = [
            &|| open(&file),
            &|| open(&first.folder),
            &|| {
                let other = cache.path().join("m-other");
                fs::rename(&file, &other).unwrap();
                std::os::unix::fs::symlink(&other, &file).unwrap();
            },
            &|| fs::write(first.folder.join("a"), "alphb").unwrap(),
            &|| fs::write(first.folder.join("a"), "").unwrap(),
            &|| fs::remove_file(first.folder.join("a")).unwrap(),
            &|| fs::remove_file(first.folder.join(MANIFEST)).unwrap(),
            &|| fs::write(first.folder.join(MANIFEST), "potamoi-verilated 1\n").unwrap(),
            &|| fs::write(first.folder.join(MANIFEST), [0xff, 0]).unwrap(),
        ];
        for (i, harm) in damage.iter().enumerate() {
            harm();
            let again = fetch(cache.path(), "n", &key, &make(&count)).unwrap();
            assert!(!again.cached);
            assert_eq!(count.load(Ordering::Relaxed), i + 2);
            assert_eq!(again.notes, ["one two"]);
            assert_eq!(fs::read(again.folder.join("a")).unwrap(), b"alpha");
            assert!(
                fetch(cache.path(), "n", &key, &make(&count))
                    .unwrap()
                    .cached
            );
        }
        fs::remove_file(cache.path().join("m-other")).unwrap();
        let left = fs::read_dir(cache.path()).unwrap().count();
        assert_eq!(left, 1, "temporary folders are removed");
    }

    /// An unexpected entry in the place of a product or its files is replaced, and the target of a
    /// link stays.
    #[test]
    fn strange_entries_are_replaced_and_never_waited_for() {
        let cache = tempfile::tempdir().unwrap();
        let outside = tempfile::tempdir().unwrap();
        let victim = outside.path().join("victim");
        fs::write(&victim, "mine").unwrap();
        let key = Key::new("test");
        let count = AtomicUsize::new(0);
        let place = fetch(cache.path(), "n", &key, &make(&count))
            .unwrap()
            .folder;
        let fifo = |path: &Path| {
            let made = std::process::Command::new("mkfifo").arg(path).status();
            assert!(made.unwrap().success());
        };
        let link = |to: &Path, path: &Path| std::os::unix::fs::symlink(to, path).unwrap();
        let file = place.join("a");
        type Change<'a> = (&'a Path, &'a dyn Fn(&Path));
        let strange: [Change<'_>; 7] = [
            (&file, &fifo),
            (&file, &|path| fs::create_dir(path).unwrap()),
            (&place.join(MANIFEST), &fifo),
            (&place, &fifo),
            (&place, &|path| link(&victim, path)),
            (&place, &|path| link(outside.path(), path)),
            (&place, &|path| fs::write(path, "").unwrap()),
        ];
        for (i, (path, put)) in strange.iter().enumerate() {
            if path.is_dir() {
                fs::remove_dir_all(path).unwrap();
            } else {
                fs::remove_file(path).unwrap();
            }
            put(path);
            let again = fetch(cache.path(), "n", &key, &make(&count)).unwrap();
            assert!(!again.cached, "{i}");
            assert!(verified(&place).is_some(), "{i}");
        }
        assert_eq!(fs::read_to_string(&victim).unwrap(), "mine");
        assert_eq!(fs::read_dir(outside.path()).unwrap().count(), 1);
    }

    /// A compiler that succeeds without output is a fault of the machine, and is not cached.
    #[test]
    fn a_file_that_is_missing_or_empty_is_the_tools_fault() {
        let cache = tempfile::tempdir().unwrap();
        for leave in [None, Some("")] {
            let lacking = |folder: &Path| {
                if let Some(text) = leave {
                    fs::write(folder.join("model.so"), text).unwrap();
                }
                Ok(Product {
                    files: vec!["model.so".into()],
                    notes: vec![],
                })
            };
            let error = fetch(cache.path(), "n", &Key::new("test"), &lacking).unwrap_err();
            assert!(matches!(error, Error::Broken { .. }), "{error}");
            assert!(error.to_string().contains("doctor"), "{error}");
        }
    }

    #[test]
    fn a_failed_maker_leaves_nothing() {
        let cache = tempfile::tempdir().unwrap();
        let fail = |_: &Path| Err(Error::Trace("no".into()));
        assert!(fetch(cache.path(), "n", &Key::new("test"), &fail).is_err());
        assert_eq!(fs::read_dir(cache.path()).unwrap().count(), 0);
    }

    #[test]
    fn one_of_two_makers_that_race_loses_quietly() {
        let cache = tempfile::tempdir().unwrap();
        let place = cache.path().join("n-0");
        let whole = |name: &str| {
            let folder = cache.path().join(name);
            fs::create_dir(&folder).unwrap();
            let count = AtomicUsize::new(0);
            let product = make(&count)(&folder).unwrap();
            let text = describe(&folder, &place, &product).unwrap();
            fs::write(folder.join(MANIFEST), text).unwrap();
            folder
        };
        for name in ["first", "second"] {
            settle(cache.path(), &whole(name), place.clone()).unwrap();
        }
        assert!(verified(&place).is_some());
    }

    /// A complete product under another key's name is refused: it is another model.
    #[test]
    fn a_product_under_another_name_is_not_believed() {
        let cache = tempfile::tempdir().unwrap();
        let count = AtomicUsize::new(0);
        let own = fetch(cache.path(), "n", &Key::new("a"), &make(&count)).unwrap();
        let other = cache.path().join(format!("n-{}", Key::new("b").hex()));
        fs::rename(&own.folder, &other).unwrap();
        assert!(verified(&other).is_none());
        let again = fetch(cache.path(), "n", &Key::new("b"), &make(&count)).unwrap();
        assert!(!again.cached);
        assert_eq!(count.load(Ordering::Relaxed), 2);
    }

    #[test]
    fn fields_do_not_run_together() {
        let a = Key::new("k").with("ab").with("c").hex();
        let b = Key::new("k").with("a").with("bc").hex();
        assert_ne!(a, b);
    }
}
