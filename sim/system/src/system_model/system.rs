//! Parameters of the system, each with its meaning and source.

use std::path::{Path, PathBuf};

use potamoi_base::content_hash::hash_of;
use potamoi_formats::device_file::is_file;
use potamoi_formats::document::{self, Value};
use potamoi_formats::file_kinds;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::given;
use super::gpu::Gpu;
use super::memory_device::MemoryDevice;
use super::ranges::RANGES;
use crate::link;
use potamoi_cycles::mac_array::MacArray;

/// Size limit of a description, in bytes.
const LARGEST: u64 = 1 << 20;

/// The system around the units. Defaults are the paper's (Sec. "Experimental Setup") where it
/// states them, and named assumptions elsewhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct System {
    /// Rows of the MAC array.
    pub array_rows: u32,
    /// Columns of the MAC array.
    pub array_columns: u32,
    /// Whether each unit holds a second weight, loaded while the first is used.
    pub array_double_buffered: bool,
    /// Bytes of the global feature buffer.
    pub feature_buffer_bytes: u64,
    /// Bytes of a block of it; blocks are filled while others are read.
    pub feature_block_bytes: u32,
    /// Banks of it, with one port of 16 bytes each; the paper's block of 32 KB is one of them.
    pub feature_banks: u32,
    /// Banks in a group. The words of a block are interleaved over a group. An assumption: all
    /// banks.
    pub feature_block_banks: u32,
    /// Bytes of the weight buffer, with one port of 48 bytes. Weights that fit are loaded once per
    /// path.
    pub weight_buffer_bytes: u64,
    /// The memory: the name of a device, or the path of a device file.
    ///
    /// [`MemoryDevice::names`] are the names.
    pub memory: MemoryDevice,
    /// Channels of the memory, in one or more packages.
    pub memory_channels: u32,
    /// Bytes of a DMA descriptor, read once per transfer: the spacing of a published controller
    /// (AMD, PG021, "Scatter Gather Descriptor").
    pub dma_descriptor_bytes: f64,
    /// Rate of the interconnect between memory, GPU and accelerator, over the peak of the memory. It
    /// has a clock of its own. An assumption: paths for reads and for writes, each as fast as the
    /// memory.
    pub interconnect_over_memory: f64,
    /// Picojoules of a byte on it. An assumption: 5 mm of wire at 0.2 pF a mm (Ho et al., "The
    /// Future of Wires", Proc. IEEE 2001), as much again of repeaters, at 0.7 V, half of the bits
    /// changing.
    pub interconnect_pj_per_byte: f64,
    /// Ray groups in flight: steps of a field's frame that may be under way before the first of
    /// them has determined which rays continue. An assumption.
    pub groups_in_flight: u32,
    /// Share that is added to the periods of synthesised logic for wires, which synthesis leaves
    /// out. 0: clocks are before wires.
    pub wire_margin: f64,
    /// The GPU of the system.
    pub gpu: Gpu,
    /// The GPU at the other end of the link, with a memory of its own. It neither warps nor
    /// upscales, and misses of the device's cache count as misses of its own.
    pub remote: Gpu,
    /// Bandwidth of the link in bytes a second.
    pub link_bytes_per_second: f64,
    /// Nanojoules of a byte sent or received.
    pub link_nj_per_byte: f64,
    /// Bytes of a pixel's colour on the link: three channels, uncompressed.
    pub link_colour_bytes: f64,
    /// Bytes of a pixel's depth, sent with references.
    pub link_depth_bytes: f64,
}

impl Default for System {
    fn default() -> Self {
        Self {
            array_rows: 24,
            array_columns: 24,
            array_double_buffered: false,
            feature_buffer_bytes: 1_536 * 1024,
            feature_block_bytes: 32 * 1024,
            feature_banks: 48,
            feature_block_banks: 48,
            weight_buffer_bytes: 96 * 1024,
            memory: MemoryDevice::default(),
            memory_channels: 4,
            dma_descriptor_bytes: 64.0,
            interconnect_over_memory: 2.0,
            interconnect_pj_per_byte: 2.0,
            groups_in_flight: 2,
            wire_margin: 0.0,
            gpu: Gpu::xavier(),
            remote: Gpu::rtx_2080_ti(),
            link_bytes_per_second: link::BYTES_PER_SECOND as f64,
            link_nj_per_byte: link::NANOJOULES_PER_BYTE as f64,
            link_colour_bytes: link::COLOUR_BYTES.into(),
            link_depth_bytes: link::DEPTH_BYTES.into(),
        }
    }
}

/// Why a description is no system.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SystemError {
    /// The text is not a valid description.
    #[error("{name}: {problem}")]
    Text {
        /// Name of its source.
        name: String,
        /// The problem.
        problem: String,
    },
    /// The file cannot be read, or is too large.
    #[error("cannot read system {}: {problem}; name a description in TOML, or a GPU", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: String,
    },
    /// No device has that name.
    #[error("system: {0}")]
    Device(String),
    /// A field of an earlier model.
    #[error("{name}: `{field}` is gone; {instead}")]
    Gone {
        /// Name of its source.
        name: String,
        /// Path of the field.
        field: String,
        /// The remedy.
        instead: String,
    },
    /// A field does not go with another one.
    #[error("{name}: `{field}` is {value}: expected {expected}")]
    Together {
        /// Name of its source.
        name: String,
        /// Path of the field.
        field: &'static str,
        /// Its value.
        value: String,
        /// The allowed values, by the other field.
        expected: &'static str,
    },
    /// A field is out of range.
    #[error("{name}: `{field}` is {value}: expected {expected}")]
    Value {
        /// Name of its source.
        name: String,
        /// Path of the field.
        field: &'static str,
        /// Its value.
        value: String,
        /// The allowed values.
        expected: &'static str,
    },
}

impl System {
    /// Rate of the interconnect, in bytes a nanosecond.
    pub(super) fn interconnect_gb_s(&self) -> f64 {
        let peak = self.memory.peak_gb_s() * f64::from(self.memory_channels);
        self.interconnect_over_memory * peak
    }

    /// Reads a description in TOML; fields that it leaves out have their defaults.
    ///
    /// # Errors
    /// Text that is not TOML, an unknown field, a value out of range.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, SystemError> {
        Self::from_bytes(text.as_bytes(), name)
    }

    /// Reads a description from a file. Paths of device files are relative to its folder.
    ///
    /// # Errors
    /// As [`System::from_toml`], or the file cannot be read or is larger than a mebibyte.
    pub fn read(path: &Path) -> Result<Self, SystemError> {
        let fail = |problem: String| SystemError::Read {
            path: path.to_owned(),
            problem,
        };
        let bytes = potamoi_base::files::read(path, LARGEST).map_err(|e| fail(e.to_string()))?;
        let long = || fail(file_kinds::too_long(path, LARGEST).to_string());
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.display().to_string();
        Self::described(&bytes.ok_or_else(long)?, &name, folder)
    }

    /// The system that the command line names: a description's file, or the paper's system with
    /// another device, by name or by the device's file.
    ///
    /// # Errors
    /// As [`System::read`]; no device has that name.
    pub fn named(given: &Path) -> Result<Self, SystemError> {
        let is_name = |name: &&str| !is_file(name) && !given.exists();
        match given.to_str().filter(is_name) {
            None if is_device(given) => Self::with_device(&given.display().to_string()),
            None => Self::read(given),
            Some(name) => Self::with_device(name),
        }
    }

    /// The paper's system with another device: its name, or the path of its file.
    fn with_device(given: &str) -> Result<Self, SystemError> {
        let system = Self::default();
        let gpu = system.gpu.clone().of_device(given);
        let gpu = gpu.map_err(|error| SystemError::Device(error.to_string()))?;
        Ok(Self { gpu, ..system })
    }

    /// Reads a description from a file's bytes. Paths of device files are relative to the current
    /// folder.
    ///
    /// # Errors
    /// As [`System::from_toml`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, SystemError> {
        Self::described(bytes, name, Path::new(""))
    }

    fn described(bytes: &[u8], name: &str, folder: &Path) -> Result<Self, SystemError> {
        let fail = |problem: String| SystemError::Text {
            name: name.to_owned(),
            problem,
        };
        let given = document::toml(bytes).map_err(|wrong| fail(wrong.to_string()))?;
        Self::of_document(given, name, folder)
    }

    /// The system of a document; fields that it leaves out have their defaults. `name` is that of its
    /// source in errors; paths of device files are relative to `folder`.
    ///
    /// # Errors
    /// As [`System::from_toml`].
    pub fn of_document(given: Value, name: &str, folder: &Path) -> Result<Self, SystemError> {
        let fail = |problem: String| SystemError::Text {
            name: name.to_owned(),
            problem,
        };
        let wrong = |wrong: document::Wrong| fail(wrong.to_string());
        if let Some((field, instead)) = given::gone(&given) {
            let name = name.to_owned();
            return Err(SystemError::Gone {
                name,
                field,
                instead,
            });
        }
        let given = given::beside(given, folder);
        // Parts of the GPUs, too, are as in the default where they are not named.
        let default = Self::default().document().map_err(fail)?;
        let system: Self = given.over(default).read().map_err(wrong)?;
        system.check(name)?;
        Ok(system)
    }

    /// Hash of all that a system is: of its devices the figures, wherever their files lie.
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let Ok(mut rest) = toml::Table::try_from(self) else {
            return hash_of(self);
        };
        // Names or paths, as given.
        rest.remove("memory");
        for gpu in ["gpu", "remote"] {
            rest.get_mut(gpu)
                .and_then(toml::Value::as_table_mut)
                .map(|own| own.remove("device"));
        }
        let devices = [&self.gpu, &self.remote].map(|own| format!("{:?}", own.device));
        hash_of(&(rest, devices, self.memory.figures()))
    }

    fn document(&self) -> Result<Value, String> {
        let table = toml::Table::try_from(self).map_err(|e| e.to_string())?;
        document::of_toml(table).map_err(|e| e.to_string())
    }

    fn check(&self, name: &str) -> Result<(), SystemError> {
        let refuse = |field, value: String, expected| {
            Err(SystemError::Value {
                name: name.to_owned(),
                field,
                value,
                expected,
            })
        };
        let apart = |field, value: String, expected| {
            Err(SystemError::Together {
                name: name.to_owned(),
                field,
                value,
                expected,
            })
        };
        let values = self.document().map_err(|problem| SystemError::Text {
            name: name.to_owned(),
            problem,
        })?;
        for range in &RANGES {
            let value = range
                .field
                .split('.')
                .try_fold(&values, |at, part| at.get(part));
            let value = value.and_then(Value::number);
            if let Some(value) = value.filter(|value| !range.holds(*value)) {
                return refuse(range.field, value.to_string(), range.expected);
            }
        }
        if ![1, 2, 4, 8, 16].contains(&self.memory_channels) {
            let value = self.memory_channels.to_string();
            return refuse("memory_channels", value, "1, 2, 4, 8 or 16");
        }
        if self.feature_buffer_bytes < 2 * u64::from(self.feature_block_bytes) {
            let value = self.feature_buffer_bytes.to_string();
            return apart("feature_buffer_bytes", value, "two blocks or more");
        }
        if !self.feature_banks.is_multiple_of(self.feature_block_banks) {
            let value = self.feature_block_banks.to_string();
            return apart("feature_block_banks", value, "a divisor of feature_banks");
        }
        for (field, gpu) in [
            ("gpu.idle_watts", &self.gpu),
            ("remote.idle_watts", &self.remote),
        ] {
            if gpu.idle_watts > gpu.watts() {
                let expected = "the watts of the device at most";
                return apart(field, gpu.idle_watts.to_string(), expected);
            }
        }
        if self.remote.shares_memory {
            let expected = "false: the remote machine has a memory of its own";
            return refuse("remote.shares_memory", "true".to_owned(), expected);
        }
        Ok(())
    }

    /// The MAC array.
    #[must_use]
    pub fn array(&self) -> MacArray {
        MacArray {
            rows: self.array_rows.into(),
            columns: self.array_columns.into(),
            is_double_buffered: self.array_double_buffered,
            ..MacArray::PAPER
        }
    }
}

/// Whether a file describes a device and not a system: it has a figure that every device has.
fn is_device(path: &Path) -> bool {
    let read = potamoi_base::files::read(path, LARGEST).ok().flatten();
    let document = read.and_then(|bytes| document::toml(&bytes).ok());
    document.is_some_and(|own| own.get("multiprocessors").is_some())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
        match value {
            Value::Map(entries) => {
                for (key, value) in entries {
                    let path = match path {
                        "" => key.to_string(),
                        path => format!("{path}.{key}"),
                    };
                    numbers(value, &path, found);
                }
            }
            other if other.number().is_some() => found.push(path.to_owned()),
            _ => {}
        }
    }

    /// A number without a range could be any.
    #[test]
    fn every_number_has_a_range_and_every_range_a_number() {
        let mut found = vec![];
        numbers(&System::default().document().unwrap(), "", &mut found);
        let mut rows: Vec<_> = RANGES.iter().map(|range| range.field.to_owned()).collect();
        found.sort();
        rows.sort();
        assert_eq!(found, rows);
    }

    /// Just outside of each range, and numbers that are none.
    #[test]
    fn numbers_out_of_their_ranges_are_refused_by_field() {
        for range in &RANGES {
            for odd in ["-1", "-1e-9", "1e16", "nan", "inf", "-inf"] {
                let text = format!("{} = {odd}", range.field);
                let error = System::from_toml(&text, "s.toml").unwrap_err().to_string();
                let last = range.field.rsplit('.').next().unwrap();
                assert!(
                    error.contains(last) && error.contains("s.toml"),
                    "{text}: {error}"
                );
            }
        }
        for text in [
            "gpu.idle_watts = 51",
            "gpu.device = \"voodoo\"",
            "gpu.device = 3",
            "remote.idle_watts = 2001",
            "remote.shares_memory = true",
            "link_bytes_per_second = 0",
            "interconnect_over_memory = 0",
            "array_rows = 24.5",
            "array_rows = true",
            "gpu = 3",
        ] {
            assert!(System::from_toml(text, "s.toml").is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_and_marks_are_read_as_others_do() {
        let read = |text: &[u8]| System::from_bytes(text, "s.toml").unwrap();
        let expected = System {
            array_rows: 32,
            ..System::default()
        };
        assert_eq!(read(b"array_rows = 32.0"), expected);
        assert_eq!(
            read(b"\xef\xbb\xbf# Gr\xfc\xdfe\r\narray_rows = 3.2e1\r\n"),
            expected
        );
    }
}
