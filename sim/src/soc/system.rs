//! What the system is made of: every number with what it is and where it is from.

use potamoi_formats::config::overlay;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::gpu::Gpu;
use super::kernels::Instructions;
use super::npu::Array;

/// The system around the units. Defaults are the paper's (Sec. "Experimental Setup") where it
/// has them, and named assumptions otherwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct System {
    /// Rows of the MAC array.
    pub array_rows: u32,
    /// Columns of it.
    pub array_columns: u32,
    /// Whether its units hold a second weight, loaded while the first is used.
    pub array_double_buffered: bool,
    /// Bytes of the global feature buffer.
    pub feature_buffer_bytes: u64,
    /// Bytes of a block of it: blocks are filled while others are read.
    pub feature_block_bytes: u32,
    /// Banks of it, of one port of 16 bytes each: a block of 32 KB of the paper's is one of them.
    pub feature_banks: u32,
    /// Banks over which the words of a block lie in turn: groups of so many serve a block. An
    /// assumption: all of them.
    pub feature_block_banks: u32,
    /// Bytes of the weight buffer, of one port of 48 bytes: weights that fit are loaded once a path.
    pub weight_buffer_bytes: u64,
    /// Channels of LPDDR3-1600, 6.4 GB/s each.
    pub memory_channels: u32,
    /// Bytes of a descriptor, of which the DMA reads one a transfer: as far apart as those of a
    /// published controller (AMD, PG021, "Scatter Gather Descriptor").
    pub dma_descriptor_bytes: f64,
    /// Bytes that the interconnect between memory, GPU and accelerator moves in a clock of the
    /// accelerator. An assumption: a burst.
    pub interconnect_bytes_a_clock: f64,
    /// Picojoules of a byte on it. An assumption: 5 mm of wire at 0.2 pF a mm (Ho et al., "The
    /// Future of Wires", Proc. IEEE 2001), as much again of repeaters, at 0.7 V, half of the bits
    /// changing.
    pub interconnect_pj_per_byte: f64,
    /// Steps of a frame of a field that may be under way before the first of them has said
    /// which rays go on: ray groups that take turns. An assumption.
    pub groups_in_flight: u32,
    /// The GPU of the system.
    pub gpu: Gpu,
    /// The GPU at the other end of the link. Nothing is warped or scaled there, and what misses the
    /// device's cache is taken to miss its own as well: both fields of these are refused.
    pub remote: Gpu,
    /// What GPUs' programs do.
    pub instructions: Instructions,
    /// Bytes a second of the link.
    pub link_bytes_per_second: f64,
    /// Nanojoules of a byte that is sent or received.
    pub link_nj_per_byte: f64,
    /// Bytes of a pixel that is sent: three colours, uncompressed.
    pub link_colour_bytes: f64,
    /// Bytes of a reference's depth that is sent with a pixel.
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
            memory_channels: 4,
            dma_descriptor_bytes: 64.0,
            interconnect_bytes_a_clock: 32.0,
            interconnect_pj_per_byte: 2.0,
            groups_in_flight: 2,
            gpu: Gpu::XAVIER,
            remote: Gpu::RTX_2080_TI,
            instructions: Instructions::default(),
            link_bytes_per_second: 10e6,
            link_nj_per_byte: 100.0,
            link_colour_bytes: 3.0,
            link_depth_bytes: 2.0,
        }
    }
}

/// A system that cannot be.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SystemError {
    /// The text is no description.
    #[error("{name}: {problem}")]
    Text {
        /// What it was read from.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// A field is out of range.
    #[error("{name}: `{field}` is {value}: expected {expected}")]
    Value {
        /// What it was read from.
        name: String,
        /// The field.
        field: &'static str,
        /// What it is.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
}

impl System {
    /// Reads a description; what it does not name is as in the default.
    ///
    /// # Errors
    /// Text that is no TOML, an unknown field, a value out of range.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, SystemError> {
        let fail = |problem: String| SystemError::Text {
            name: name.to_owned(),
            problem,
        };
        let given: toml::Table = text
            .parse()
            .map_err(|e: toml::de::Error| fail(e.to_string()))?;
        // Parts of the GPUs, too, are as in the default where they are not named.
        let mut all = toml::Table::try_from(Self::default()).map_err(|e| fail(e.to_string()))?;
        overlay(&mut all, given);
        let system: Self = all
            .try_into()
            .map_err(|e: toml::de::Error| fail(e.to_string()))?;
        system.check(name)?;
        Ok(system)
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
        for (field, value, most) in [
            ("array_rows", self.array_rows, 1024),
            ("array_columns", self.array_columns, 1024),
            ("groups_in_flight", self.groups_in_flight, 1 << 20),
        ] {
            if !(1..=most).contains(&value) {
                return refuse(field, value.to_string(), "1 or more, sides up to 1024");
            }
        }
        if ![1, 2, 4, 8, 16].contains(&self.memory_channels) {
            let value = self.memory_channels.to_string();
            return refuse("memory_channels", value, "1, 2, 4, 8 or 16");
        }
        if self.feature_block_bytes < 1024 {
            let value = self.feature_block_bytes.to_string();
            return refuse("feature_block_bytes", value, "1024 or more");
        }
        if self.feature_buffer_bytes < 2 * u64::from(self.feature_block_bytes) {
            let value = self.feature_buffer_bytes.to_string();
            return refuse("feature_buffer_bytes", value, "two blocks or more");
        }
        if !(1..=1024).contains(&self.feature_banks) {
            let value = self.feature_banks.to_string();
            return refuse("feature_banks", value, "1 to 1024");
        }
        if self.feature_block_banks == 0
            || !self.feature_banks.is_multiple_of(self.feature_block_banks)
        {
            let value = self.feature_block_banks.to_string();
            return refuse("feature_block_banks", value, "a divisor of feature_banks");
        }
        let positive = [
            (
                "interconnect_bytes_a_clock",
                self.interconnect_bytes_a_clock,
            ),
            ("link_bytes_per_second", self.link_bytes_per_second),
            ("gpu.memory_gb_s", self.gpu.memory_gb_s.unwrap_or(1.0)),
            ("remote.memory_gb_s", self.remote.memory_gb_s.unwrap_or(1.0)),
            ("gpu.cores", self.gpu.cores),
            ("gpu.clock_ghz", self.gpu.clock_ghz),
            ("gpu.cache_gb_s", self.gpu.cache_gb_s),
            ("gpu.gathering_factor", self.gpu.gathering_factor),
            ("remote.gathering_factor", self.remote.gathering_factor),
            ("remote.cores", self.remote.cores),
            ("remote.clock_ghz", self.remote.clock_ghz),
            ("remote.cache_gb_s", self.remote.cache_gb_s),
        ];
        for (field, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return refuse(field, value.to_string(), "a positive number");
            }
        }
        let shares = [
            ("gpu.fields_efficiency", self.gpu.fields_efficiency),
            ("gpu.splats_efficiency", self.gpu.splats_efficiency),
            ("gpu.pictures_efficiency", self.gpu.pictures_efficiency),
            ("remote.fields_efficiency", self.remote.fields_efficiency),
            ("remote.splats_efficiency", self.remote.splats_efficiency),
        ];
        for (field, value) in shares {
            if !(value > 0.0 && value <= 1.0) {
                return refuse(field, value.to_string(), "a share: above 0, 1 at most");
            }
        }
        if self.gpu.cache_bytes < 64 {
            let value = self.gpu.cache_bytes.to_string();
            return refuse("gpu.cache_bytes", value, "64 or more: a line");
        }
        if self.dma_descriptor_bytes > 4096.0 {
            let value = self.dma_descriptor_bytes.to_string();
            return refuse("dma_descriptor_bytes", value, "4096 or less");
        }
        let fixed = Gpu::RTX_2080_TI;
        for (field, value, fixed, expected) in [
            (
                "remote.cache_bytes",
                f64::from(self.remote.cache_bytes),
                f64::from(fixed.cache_bytes),
                "the default's: misses are counted in the device's cache (gpu.cache_bytes), for both",
            ),
            (
                "remote.pictures_efficiency",
                self.remote.pictures_efficiency,
                fixed.pictures_efficiency,
                "the default's: nothing is warped or scaled there",
            ),
        ] {
            if value != fixed {
                return refuse(field, value.to_string(), expected);
            }
        }
        for (field, value) in self.instructions.named() {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(field, value.to_string(), "a number from 0 on");
            }
        }
        let others = [
            ("dma_descriptor_bytes", self.dma_descriptor_bytes),
            ("interconnect_pj_per_byte", self.interconnect_pj_per_byte),
            ("link_nj_per_byte", self.link_nj_per_byte),
            ("link_colour_bytes", self.link_colour_bytes),
            ("link_depth_bytes", self.link_depth_bytes),
            ("gpu.launch_us", self.gpu.launch_us),
            ("gpu.watts", self.gpu.watts),
            ("gpu.idle_watts", self.gpu.idle_watts),
            ("remote.launch_us", self.remote.launch_us),
            ("remote.watts", self.remote.watts),
            ("remote.idle_watts", self.remote.idle_watts),
        ];
        for (field, value) in others {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(field, value.to_string(), "a number from 0 on");
            }
        }
        Ok(())
    }

    /// The MAC array.
    #[must_use]
    pub fn array(&self) -> Array {
        Array {
            rows: self.array_rows.into(),
            columns: self.array_columns.into(),
            is_double_buffered: self.array_double_buffered,
            ..Array::PAPER
        }
    }
}
