//! GPUs as data: one file a device and power mode.
//!
//! Every figure is a property of the hardware, and is either published or assumed with a reason.
//! None belongs to a program or to a class of programs.

mod field;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

pub use potamoi_formats::device_file::{DeviceError, Origin};
use potamoi_formats::device_file::{Figure, Kind};
pub(crate) use potamoi_formats::nearest::nearest;

pub use field::{Better, FIELDS, Field};

/// Its files, in messages.
const KIND: Kind = Kind {
    name: "device",
    example: "sim/gpu/devices/a6000.toml",
    texts: &["title", "mode"],
};

/// A GPU in one named power mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Short name, that of the file.
    pub name: String,
    /// Full name, for tables.
    pub title: String,
    /// Power mode in which clocks, memory and watts hold, such as `MAXN`.
    pub mode: String,
    /// Streaming multiprocessors (SMs) that are on.
    pub multiprocessors: f64,
    /// Clock of the SMs and of the second-level cache, in GHz.
    pub clock_ghz: f64,
    /// Single-precision lanes of an SM: operations a clock.
    pub fp32_lanes: f64,
    /// Integer lanes of an SM.
    pub int_lanes: f64,
    /// Lanes of an SM for exponentials, square roots and reciprocals.
    pub sfu_lanes: f64,
    /// Warps that an SM holds at most.
    pub warps: f64,
    /// Size of the second-level cache (L2), in bytes.
    pub l2_bytes: f64,
    /// Bytes that L2 delivers to an SM a clock.
    pub l2_bytes_clock: f64,
    /// Peak bandwidth of the memory, in GB/s.
    pub dram_gb_s: f64,
    /// Share of that peak which a stream reaches.
    pub dram_share: f64,
    /// Dense half-precision peak of the tensor cores, in TFLOPS.
    pub tensor_tflops: f64,
    /// Host time of an operation launched by a framework, in microseconds.
    pub operation_us: f64,
    /// Time of a wait in microseconds: the host waits, reads a scalar and starts again.
    pub wait_us: f64,
    /// Host time of a kernel launched from C++, in microseconds.
    pub launch_us: f64,
    /// Time of an empty kernel on the device, in microseconds.
    pub ramp_us: f64,
    /// Latency of the memory, in nanoseconds.
    pub dram_latency_ns: f64,
    /// Latency of L2, in clocks.
    pub l2_latency_clocks: f64,
    /// Copies to pageable memory of the host, in GB/s.
    pub copy_gb_s: f64,
    /// Power limit in the same mode, in watts.
    pub watts: f64,
    /// Origin of each field, by its key in the file.
    pub origins: BTreeMap<String, Origin>,
}

/// Device files of this crate, by name.
const BUILTIN: [(&str, &str); 16] = [
    ("1660ti", include_str!("../../devices/1660ti.toml")),
    ("2080ti", include_str!("../../devices/2080ti.toml")),
    ("3070", include_str!("../../devices/3070.toml")),
    ("3090", include_str!("../../devices/3090.toml")),
    ("a100-sxm", include_str!("../../devices/a100-sxm.toml")),
    ("a5000", include_str!("../../devices/a5000.toml")),
    ("a6000", include_str!("../../devices/a6000.toml")),
    ("agx-orin", include_str!("../../devices/agx-orin.toml")),
    (
        "laptop-3050",
        include_str!("../../devices/laptop-3050.toml"),
    ),
    ("orin-nano", include_str!("../../devices/orin-nano.toml")),
    ("orin-nx", include_str!("../../devices/orin-nx.toml")),
    ("v100", include_str!("../../devices/v100.toml")),
    ("xavier-15w", include_str!("../../devices/xavier-15w.toml")),
    ("xavier-30w", include_str!("../../devices/xavier-30w.toml")),
    (
        "xavier-maxn",
        include_str!("../../devices/xavier-maxn.toml"),
    ),
    ("xavier-nx", include_str!("../../devices/xavier-nx.toml")),
];

/// Names of devices that stand for one power mode of theirs.
const ALIASES: [(&str, &str); 1] = [("xavier", "xavier-maxn")];

impl Device {
    /// The device of that name; see [`Device::names`]. `xavier` is `xavier-maxn`.
    ///
    /// # Errors
    ///
    /// [`DeviceError::Unknown`], with the nearest name where one is near.
    pub fn builtin(name: &str) -> Result<Self, DeviceError> {
        let full = ALIASES.iter().find(|(alias, _)| *alias == name);
        let name = full.map_or(name, |(_, full)| full);
        let text = BUILTIN.iter().find(|(known, _)| *known == name);
        let (_, text) = text.ok_or_else(|| {
            let aliases = ALIASES.iter().map(|(alias, _)| *alias);
            let known: Vec<_> = Self::names().into_iter().chain(aliases).collect();
            KIND.unknown(name, &known)
        })?;
        Self::from_text(name, &format!("{name}.toml"), text)
    }

    /// Names of all devices of this crate, in alphabetical order.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        BUILTIN.iter().map(|(name, _)| *name).collect()
    }

    /// A device from a file of the form of those in `sim/gpu/devices/`. Its name is the file's
    /// without the ending.
    ///
    /// # Errors
    ///
    /// [`DeviceError`], where the file is not readable, has a key that no device has, lacks a
    /// field or its origin, or has a value out of range.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, DeviceError> {
        let path = path.as_ref();
        let (name, text) = KIND.open(path)?;
        Self::from_text(&name, &path.display().to_string(), &text)
    }

    /// A device from the text of its file; `file` stands in messages.
    fn from_text(name: &str, file: &str, text: &str) -> Result<Self, DeviceError> {
        let figures = FIELDS.map(|own| Figure {
            key: own.key,
            unit: own.unit,
            least: own.least,
            most: own.most,
        });
        let mut read = KIND.read(file, text, &figures)?;
        let mut own = Self::blank(name);
        let mut text = |key| read.texts.remove(key).unwrap_or_default();
        own.title = text("title");
        own.mode = text("mode");
        for (key, (value, origin)) in read.figures {
            if let Some(field) = FIELDS.iter().find(|field| field.key == key) {
                *(field.place)(&mut own) = value;
            }
            own.origins.insert(key, origin);
        }
        Ok(own)
    }

    /// All SM clocks of a second: SMs times Hz.
    #[must_use]
    pub fn sm_hz(&self) -> f64 {
        self.multiprocessors * self.clock_ghz * 1e9
    }

    /// The same device with all rates times `factor`, and all times divided by it: what it runs takes
    /// as much less time.
    #[must_use]
    pub fn faster(&self, factor: f64) -> Self {
        Self {
            clock_ghz: self.clock_ghz * factor,
            dram_gb_s: self.dram_gb_s * factor,
            tensor_tflops: self.tensor_tflops * factor,
            copy_gb_s: self.copy_gb_s * factor,
            operation_us: self.operation_us / factor,
            wait_us: self.wait_us / factor,
            launch_us: self.launch_us / factor,
            ramp_us: self.ramp_us / factor,
            dram_latency_ns: self.dram_latency_ns / factor,
            ..self.clone()
        }
    }

    /// A device without any limit: all rates infinite, all times zero. It bounds from below what a
    /// program takes, which is nothing.
    #[must_use]
    pub fn infinite() -> Self {
        let mut own = Self::blank("infinite");
        for field in &FIELDS {
            *(field.place)(&mut own) = match field.better {
                Better::More => f64::INFINITY,
                Better::Less => 0.0,
            };
        }
        own
    }

    /// All fields zero.
    fn blank(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            title: String::new(),
            mode: String::new(),
            multiprocessors: 0.0,
            clock_ghz: 0.0,
            fp32_lanes: 0.0,
            int_lanes: 0.0,
            sfu_lanes: 0.0,
            warps: 0.0,
            l2_bytes: 0.0,
            l2_bytes_clock: 0.0,
            dram_gb_s: 0.0,
            dram_share: 0.0,
            tensor_tflops: 0.0,
            operation_us: 0.0,
            wait_us: 0.0,
            launch_us: 0.0,
            ramp_us: 0.0,
            dram_latency_ns: 0.0,
            l2_latency_clocks: 0.0,
            copy_gb_s: 0.0,
            watts: 0.0,
            origins: BTreeMap::new(),
        }
    }
}
