//! PyTorch checkpoints: a ZIP archive with a pickle that describes tensors, and one member with
//! the numbers of each.
//!
//! They are read as data: no code of the file is run, and classes other than tensors, arrays and
//! dictionaries are refused by name. The reader is our own
//! (docs/decisions/0004-own-pickle-reader.md).

mod legacy;
mod members;
mod objects;
mod pickle;
mod plain;
mod tensors;
mod value;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zip::ZipArchive;

use crate::archive;
use members::member;
use potamoi_base::file_keys::{Fate, FileKeys, Format, KeyError, Notes, told};
use value::{Arena, Value};

/// The largest pickle, in bytes.
const PICKLE_LIMIT: u64 = 1 << 24;
/// Maximum length of a key in messages, in characters.
const TOLD_NAME: usize = 60;

/// A checkpoint that is invalid or not supported.
#[derive(Debug, Error)]
pub enum TorchError {
    /// The file system returned an error.
    #[error("cannot read checkpoint {path}: {source}; name a readable file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file is not a checkpoint, or has unsupported content.
    #[error(
        "checkpoint {path}: {problem}; expected what torch.save of PyTorch 1.6 or later writes, \
         or numpy.savez of a state_dict"
    )]
    Container {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: String,
    },
    /// The checkpoint has a feature that no renderer supports.
    #[error("checkpoint {path}: {source}")]
    Key {
        /// The file.
        path: PathBuf,
        /// The key, and why it is refused.
        source: Box<KeyError>,
    },
    /// A field is missing or of the wrong kind.
    #[error("checkpoint {path}: `{field}` is {found}; expected {expected}")]
    Field {
        /// The file.
        path: PathBuf,
        /// Path of the field, keys joined by `/`.
        field: String,
        /// Its content.
        found: String,
        /// Allowed content.
        expected: String,
    },
}

/// Numbers with a shape, the last axis fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// All numbers, the last axis fastest.
    pub values: Vec<f32>,
}

/// An open checkpoint.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    /// The archive; `None` if the numbers are within the pickle.
    archive: Option<ZipArchive<BufReader<File>>>,
    /// Parts of the archive that are not read.
    beside: Vec<String>,
    /// Folder of all members.
    prefix: String,
    arena: Arena,
    root: Value,
    /// Dictionaries and items that have been requested.
    asked: RefCell<BTreeSet<(usize, usize)>>,
}

impl Checkpoint {
    /// Opens a file and reads its pickle, but no tensors.
    ///
    /// # Errors
    /// The file cannot be read or is not a checkpoint.
    pub fn open(path: &Path) -> Result<Self, TorchError> {
        let fail = |source| TorchError::Read {
            path: path.to_owned(),
            source,
        };
        let wrong = |problem: String| TorchError::Container {
            path: path.to_owned(),
            problem,
        };
        let mut file = BufReader::new(potamoi_base::files::open(path).map_err(fail)?);
        if legacy::is_head(file.fill_buf().map_err(fail)?) {
            let says = "what torch.save wrote before PyTorch 1.6: load it there and save it again \
                        with PyTorch 1.6 or newer";
            return Err(wrong(says.to_owned()));
        }
        let archive = ZipArchive::new(file);
        let mut archive = archive.map_err(|_| {
            wrong(
                "no ZIP archive, or one that is cut off: expected a file of torch.save".to_owned(),
            )
        })?;
        let again = potamoi_base::files::open(path).map_err(fail)?;
        let beside = archive::beside(&archive, BufReader::new(again)).map_err(fail)?;
        let prefix = members::prefix(&archive, &beside).map_err(wrong)?;
        let text = member(&mut archive, &format!("{prefix}data.pkl"), PICKLE_LIMIT);
        let (arena, root) = pickle::read(&text.map_err(wrong)?).map_err(wrong)?;
        let order = format!("{prefix}byteorder");
        if archive.index_for_name(&order).is_some() {
            let order = member(&mut archive, &order, 16).map_err(wrong)?;
            if order != b"little" {
                let order = String::from_utf8_lossy(&order).into_owned();
                return Err(wrong(format!("numbers in byte order `{order}`")));
            }
        }
        let mut beside = beside.keys;
        beside.extend(members::unknown(&archive, &prefix, &arena));
        Ok(Self {
            path: path.to_owned(),
            archive: Some(archive),
            beside,
            prefix,
            arena,
            root,
            asked: RefCell::default(),
        })
    }

    /// Reads a NumPy array of one object, a dictionary of tensors whose numbers are within the
    /// pickle. `path` names it in errors.
    ///
    /// # Errors
    /// The pickle holds something else.
    pub fn of_object_array(path: &Path, pickle: &[u8]) -> Result<Self, TorchError> {
        let wrong = |problem: String| TorchError::Container {
            path: path.to_owned(),
            problem,
        };
        let (arena, root) = pickle::read(pickle).map_err(wrong)?;
        let object = match root {
            Value::Array(at) => arena.arrays[at].object,
            _ => None,
        };
        let object = object.filter(|o| matches!(o, Value::Dict(_)));
        let root = object.ok_or_else(|| {
            let found = object.unwrap_or(root).kind();
            wrong(format!("{found} instead of an array of one dictionary"))
        })?;
        Ok(Self {
            path: path.to_owned(),
            archive: None,
            beside: vec![],
            prefix: String::new(),
            arena,
            root,
            asked: RefCell::default(),
        })
    }

    /// Whether these keys, one a level, lead to a value.
    #[must_use]
    pub fn has(&self, keys: &[&str]) -> bool {
        self.find(keys).is_some()
    }

    /// The tensor or array under these keys.
    ///
    /// # Errors
    /// There is none, or it has a wrong number of elements.
    pub fn tensor(&mut self, keys: &[&str]) -> Result<Tensor, TorchError> {
        match self.find(keys) {
            Some(Value::Tensor(at)) => self.view(keys, at),
            Some(Value::Array(at)) => self.array(keys, at),
            other => Err(self.field(keys, kind(other), "a tensor")),
        }
        .and_then(|tensor| self.finite(keys, tensor))
    }

    /// Refuses NaN and infinity.
    fn finite(&self, keys: &[&str], tensor: Tensor) -> Result<Tensor, TorchError> {
        match tensor.values.iter().position(|v| !v.is_finite()) {
            None => Ok(tensor),
            Some(at) => {
                let found = format!("{} at number {at}", tensor.values[at]);
                let expected = "finite numbers alone: training has failed, or the file is damaged";
                Err(self.field(keys, found, expected))
            }
        }
    }

    /// The tensor under these keys, which must have this shape.
    ///
    /// # Errors
    /// Those of [`Checkpoint::tensor`], or the shape differs.
    pub fn tensor_of(&mut self, keys: &[&str], shape: &[usize]) -> Result<Tensor, TorchError> {
        let tensor = self.tensor(keys)?;
        if tensor.shape == shape {
            return Ok(tensor);
        }
        let found = format!("of shape {:?}", tensor.shape);
        Err(self.field(keys, found, &format!("a tensor of shape {shape:?}")))
    }

    /// The number under these keys: an integer, a float, or a tensor of one element.
    ///
    /// # Errors
    /// There is none.
    pub fn number(&mut self, keys: &[&str]) -> Result<f64, TorchError> {
        match self.find(keys) {
            Some(Value::Int(value)) => Ok(value as f64),
            Some(Value::Float(value)) => Ok(value),
            Some(Value::Tensor(_) | Value::Array(_)) => {
                let tensor = self.tensor(keys)?;
                match tensor.values[..] {
                    [value] => Ok(value.into()),
                    _ => {
                        let found = format!("of shape {:?}", tensor.shape);
                        Err(self.field(keys, found, "one number"))
                    }
                }
            }
            other => Err(self.field(keys, kind(other), "a number")),
        }
    }

    /// The text under these keys, if there is one.
    #[must_use]
    pub fn text(&self, keys: &[&str]) -> Option<&str> {
        match self.find(keys) {
            Some(Value::Text(at)) => Some(&self.arena.texts[at]),
            _ => None,
        }
    }

    /// The numbers of the list under these keys.
    ///
    /// # Errors
    /// There is none, or it holds something else.
    pub fn numbers(&self, keys: &[&str]) -> Result<Vec<f64>, TorchError> {
        let Some(Value::List(at) | Value::Tuple(at)) = self.find(keys) else {
            return Err(self.field(keys, kind(self.find(keys)), "a list of numbers"));
        };
        let number = |value: &Value| match value {
            Value::Int(v) => Ok(*v as f64),
            Value::Float(v) => Ok(*v),
            other => Err(self.field(keys, other.kind().to_owned(), "numbers alone")),
        };
        self.arena.lists[at].iter().map(number).collect()
    }

    /// Paths of all keys, of the checkpoint and its dictionaries, in the order of the file; with
    /// `unread` only those that were not requested. A dictionary that was not requested is then
    /// not descended into.
    fn entries(&self, unread: bool) -> Vec<(String, Value)> {
        let asked = self.asked.borrow();
        let mut found = vec![];
        let items = |value: Value| match value {
            Value::Dict(dict) => Some((dict, self.arena.dicts[dict].iter().enumerate())),
            _ => None,
        };
        let name = |key: Value| match key {
            Value::Text(at) => self.arena.texts[at].chars().take(TOLD_NAME).collect(),
            other => other.kind().to_owned(),
        };
        let Some((root, outer)) = items(self.root) else {
            return found;
        };
        for (at, (key, value)) in outer {
            let whole: String = name(*key);
            if !(unread && asked.contains(&(root, at))) {
                found.push((whole.clone(), *value));
                if unread {
                    continue;
                }
            }
            if let Some((dict, inner)) = items(*value) {
                let wanted = inner.filter(|(at, _)| !(unread && asked.contains(&(dict, *at))));
                let path = |key: Value| format!("{whole}/{}", name(key));
                found.extend(wanted.map(|(_, (key, value))| (path(*key), *value)));
            }
        }
        found
    }

    /// Paths of all keys, of the checkpoint and its dictionaries.
    #[must_use]
    pub fn keys(&self) -> Vec<String> {
        let entries = self.entries(false).into_iter();
        entries.map(|(key, _)| key).collect()
    }

    /// Checks all keys against the table of their format, before any is read.
    ///
    /// # Errors
    /// The first key that is refused, unless its value has no effect.
    pub fn refuse(&self, format: &'static Format) -> Result<(), TorchError> {
        let refused = |key: &str| format.row(key).is_some_and(|row| row.fate == Fate::Refused);
        let entries = self.entries(false).into_iter();
        let record = FileKeys::new(format, entries.filter(|(key, _)| refused(key)));
        self.judged(record, &mut Notes::default())
    }

    /// Lists all keys that were not requested.
    ///
    /// # Errors
    /// Those of [`Checkpoint::refuse`].
    pub fn finish(&self, format: &'static Format, notes: &mut Notes) -> Result<(), TorchError> {
        self.beside.iter().for_each(|own| notes.list(own));
        self.judged(FileKeys::new(format, self.entries(true)), notes)
    }

    fn judged(&self, mut record: FileKeys<Value>, notes: &mut Notes) -> Result<(), TorchError> {
        record.take_neutral(|value| match value {
            Value::None | Value::Bool(false) | Value::Int(0) => true,
            Value::Float(value) => *value == 0.0,
            _ => false,
        });
        let shown = |value: &Value| match value {
            Value::Bool(flag) => Some(flag.to_string()),
            Value::Int(number) => Some(number.to_string()),
            Value::Float(number) => Some(number.to_string()),
            _ => None,
        };
        let judged = record.finish_valued(notes, shown);
        judged.map_err(|source| TorchError::Key {
            path: self.path.clone(),
            source: Box::new(source),
        })
    }

    /// An error about the field under these keys.
    #[must_use]
    pub fn field(&self, keys: &[&str], found: String, expected: &str) -> TorchError {
        TorchError::Field {
            path: self.path.clone(),
            field: keys.join("/"),
            found: told(&found),
            expected: expected.to_owned(),
        }
    }

    fn find(&self, keys: &[&str]) -> Option<Value> {
        keys.iter().try_fold(self.root, |at, key| {
            let Value::Dict(dict) = at else { return None };
            // The last one given stands, as in Python.
            let mut pairs = self.arena.dicts[dict].iter().enumerate().rev();
            pairs.find_map(|(at, (k, v))| {
                let here = matches!(k, Value::Text(t) if self.arena.texts[*t] == *key);
                here.then(|| {
                    self.asked.borrow_mut().insert((dict, at));
                    *v
                })
            })
        })
    }
}

fn kind(value: Option<Value>) -> String {
    value.map_or("missing", Value::kind).to_owned()
}

#[cfg(test)]
mod tests;
