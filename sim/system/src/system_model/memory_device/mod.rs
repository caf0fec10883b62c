//! Memory devices as data: one file a device, in which each figure has its source or the reason why
//! it is assumed.

mod figures;
#[cfg(test)]
mod page;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

use potamoi_formats::device_file::{DeviceError, Kind, Origin, is_file};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dram::{Currents, Geometry, Interface, Timing};

pub use figures::FIGURES;

/// Files of memory devices, in messages.
const KIND: Kind = Kind {
    name: "memory device",
    example: "sim/system/memories/lpddr3-1600.toml",
    texts: &["title"],
};

/// Memory devices of this crate, by name.
const BUILTIN: [(&str, &str); 4] = [
    (
        "lpddr3-1600",
        include_str!("../../../memories/lpddr3-1600.toml"),
    ),
    (
        "lpddr3-1600-8gb",
        include_str!("../../../memories/lpddr3-1600-8gb.toml"),
    ),
    (
        "lpddr4x-4266",
        include_str!("../../../memories/lpddr4x-4266.toml"),
    ),
    (
        "lpddr5-6400",
        include_str!("../../../memories/lpddr5-6400.toml"),
    ),
];

/// A memory device: a package of DRAM dies. In a description it is a name, or the path of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
pub struct MemoryDevice {
    /// Short name, that of the file.
    pub name: String,
    /// Full name, for tables.
    pub title: String,
    /// All figures of [`FIGURES`] by key, in their units.
    values: BTreeMap<String, f64>,
    /// Origin of each figure.
    pub origins: BTreeMap<String, Origin>,
    /// Name or file, as given.
    given: String,
}

impl TryFrom<String> for MemoryDevice {
    type Error = String;

    fn try_from(given: String) -> Result<Self, String> {
        Self::named(&given).map_err(|error| error.to_string())
    }
}

impl From<MemoryDevice> for String {
    fn from(own: MemoryDevice) -> Self {
        own.given
    }
}

impl MemoryDevice {
    /// Its name and all its figures.
    pub(super) fn figures(&self) -> (&str, &BTreeMap<String, f64>) {
        (&self.name, &self.values)
    }

    /// The device of that name; see [`MemoryDevice::names`].
    ///
    /// # Errors
    /// [`DeviceError::Unknown`], with the nearest name where one is near.
    pub fn builtin(name: &str) -> Result<Self, DeviceError> {
        let text = BUILTIN.iter().find(|(known, _)| *known == name);
        let (_, text) = text.ok_or_else(|| KIND.unknown(name, &Self::names()))?;
        Self::from_text([name, name], &format!("{name}.toml"), text)
    }

    /// Names of all devices of this crate, in alphabetical order.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        BUILTIN.iter().map(|(name, _)| *name).collect()
    }

    /// A device by its name, or by the path of a file of the form of those in
    /// `sim/system/memories/`.
    ///
    /// # Errors
    /// [`DeviceError`], where no device has that name, or where the file is not readable, has a key
    /// that no device has, lacks a figure or its origin, or describes no memory that could be.
    pub fn named(given: &str) -> Result<Self, DeviceError> {
        if !is_file(given) {
            return Self::builtin(given);
        }
        let (name, text) = KIND.open(Path::new(given))?;
        Self::from_text([&name, given], given, &text)
    }

    fn from_text([name, given]: [&str; 2], file: &str, text: &str) -> Result<Self, DeviceError> {
        let mut read = KIND.read(file, text, &FIGURES)?;
        let title = read.texts.remove("title").unwrap_or_default();
        let figures = read.figures.into_iter();
        let (values, origins) = figures
            .map(|(key, (value, origin))| ((key.clone(), value), (key, origin)))
            .unzip();
        let own = Self {
            name: name.to_owned(),
            title,
            values,
            origins,
            given: given.to_owned(),
        };
        figures::check(&own, file)?;
        Ok(own)
    }

    /// A figure, in the unit of its key.
    #[must_use]
    pub fn value(&self, key: &str) -> f64 {
        // Every device has all figures.
        self.values.get(key).copied().unwrap_or_default()
    }

    fn whole(&self, key: &str) -> u32 {
        self.value(key) as u32
    }

    /// Channels of a package.
    #[must_use]
    pub fn package_channels(&self) -> u32 {
        self.whole("channels")
    }

    /// Peak rate of a channel, in GB/s.
    #[must_use]
    pub fn peak_gb_s(&self) -> f64 {
        let bytes = self.value("channel_bits") / 8.0;
        bytes * self.value("transfers_a_clock") / self.value("clock_ns")
    }

    /// Address mapping of so many channels.
    #[must_use]
    pub fn geometry(&self, channels: u32) -> Geometry {
        let burst_bytes = self.whole("channel_bits") / 8 * self.whole("burst_length");
        Geometry {
            channels,
            ranks: self.whole("ranks"),
            bank_groups: self.whole("bank_groups"),
            banks: self.whole("banks"),
            row_bursts: self.whole("row_bytes") / burst_bytes.max(1),
            burst_bytes,
        }
    }

    /// Delays in clocks, each rounded up.
    #[must_use]
    pub fn timing(&self) -> Timing {
        let clock_ns = self.value("clock_ns");
        // A delay of exactly so many clocks is no more, whatever its last bit.
        let of_ns = |key| (self.value(key) / clock_ns - 1e-6).ceil().max(0.0) as u64;
        let of = |key| self.value(key) as u64;
        Timing {
            clock_ns,
            read_latency: of("read_latency_clocks"),
            write_latency: of("write_latency_clocks"),
            burst: of("burst_length") / of("transfers_a_clock").max(1),
            activate_to_column: of_ns("activate_to_column_ns"),
            precharge: of_ns("precharge_ns"),
            activate_to_precharge: of_ns("activate_to_precharge_ns"),
            activate_to_activate: of_ns("activate_to_activate_ns"),
            four_activates: of_ns("four_activates_ns"),
            column_to_column: of("column_to_column_clocks"),
            column_to_column_group: of("column_to_column_group_clocks"),
            write_to_read: of_ns("write_to_read_ns"),
            write_to_read_group: of_ns("write_to_read_group_ns"),
            write_recovery: of_ns("write_recovery_ns"),
            read_to_precharge: of_ns("read_to_precharge_ns"),
            precharge_to_precharge: of("precharge_to_precharge_clocks"),
            turnaround: of("turnaround_clocks"),
            rank_switch: of("rank_switch_clocks"),
            refresh: of_ns("refresh_ns"),
            refresh_interval: (self.value("refresh_interval_ns") / clock_ns + 1e-6) as u64,
        }
    }

    /// Supply currents of a rank.
    #[must_use]
    pub fn currents(&self) -> Currents {
        let of = |keys: [&str; 2]| keys.map(|key| self.value(key));
        let ma = |keys: [&str; 2]| of(keys).map(|ma| ma / self.value("die_channels"));
        Currents {
            volts: of(["vdd1_volts", "vdd2_volts"]),
            activate: ma(["idd0_vdd1_ma", "idd0_vdd2_ma"]),
            activate_ns: of(["activate_to_precharge_ns", "precharge_ns"]),
            closed: ma(["idd2n_vdd1_ma", "idd2n_vdd2_ma"]),
            open: ma(["idd3n_vdd1_ma", "idd3n_vdd2_ma"]),
            read: ma(["idd4r_vdd1_ma", "idd4r_vdd2_ma"]),
            write: ma(["idd4w_vdd1_ma", "idd4w_vdd2_ma"]),
            refresh: ma(["idd5_vdd1_ma", "idd5_vdd2_ma"]),
        }
    }

    /// Its data lines.
    #[must_use]
    pub fn interface(&self) -> Interface {
        let of = |key| self.value(key);
        Interface {
            volts: of("io_volts"),
            swing_volts: of("io_swing_volts"),
            picofarads: of("io_pf"),
            changes: of("io_changes"),
            ohms: of("io_ohms"),
            bit_ns: of("clock_ns") / of("transfers_a_clock"),
        }
    }
}

impl Default for MemoryDevice {
    /// The paper's memory.
    fn default() -> Self {
        // Never blank: tests read all built-in devices.
        Self::builtin("lpddr3-1600").unwrap_or_else(|_| Self {
            name: String::new(),
            title: String::new(),
            values: BTreeMap::new(),
            origins: BTreeMap::new(),
            given: String::new(),
        })
    }
}
