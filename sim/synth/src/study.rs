//! Variants for comparison: organisations of the gathering unit, and exponential methods.

use potamoi_formats::config::{Config, ConfigError, PRESETS};

use super::cacti::Shape;
use super::{UnitKind, UnitReport};

/// A variant of a unit.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Name in tables.
    pub name: &'static str,
    /// Unit to synthesise.
    pub unit: UnitKind,
    /// Preset that it starts from.
    preset: &'static str,
    /// Its differences, as TOML.
    text: &'static str,
}

/// Gathering units: the paper's first, then others.
pub const GATHERING: [Variant; 6] = [
    gathering("paper", "paper", ""),
    gathering("pipelined", "", "[gu]\npipelined = true\n"),
    gathering("compact entries", "compact", ""),
    gathering("parity, 4 channels, compact entries", "parity", ""),
    gathering("feature-major, 16 banks, 16 lanes", "feature-major", ""),
    gathering(
        "feature-major, 32 banks, 64 lanes",
        "",
        "[gu]\norganisation = \"feature-major\"\nbanks = 32\nlanes = 64\n",
    ),
];

/// Vector units with exponentials only, 24 lanes: the paper's first, then others.
pub const EXPONENTIALS: [Variant; 13] = [
    exponential("restoring, n = 16", ""),
    exponential(
        "as printed, n = 16 (wrong below 0)",
        "form = \"literal\"\ninput = \"S0.14\"\n",
    ),
    exponential("restoring, n = 9, tail", "iterations = 9\ntail = true\n"),
    exponential("restoring, n = 16, early out", "early_out = true\n"),
    exponential("restoring, n = 16, pipelined", "pipelined = true\n"),
    exponential(
        "restoring, n = 9, tail, pipelined",
        "iterations = 9\ntail = true\npipelined = true\n",
    ),
    exponential("radix 4, J = 8", "form = \"radix-4\"\niterations = 8\n"),
    exponential(
        "radix 4, J = 4, tail",
        "form = \"radix-4\"\niterations = 4\ntail = true\n",
    ),
    exponential(
        "radix 4, J = 4, tail, pipelined",
        "form = \"radix-4\"\niterations = 4\ntail = true\npipelined = true\n",
    ),
    exponential(
        "64 pieces",
        "form = \"piecewise\"\npieces = 64\npipelined = true\n",
    ),
    exponential(
        "128 pieces",
        "form = \"piecewise\"\npieces = 128\npipelined = true\n",
    ),
    exponential(
        "64 pieces of 2^-u",
        "form = \"piecewise\"\npieces = 64\npipelined = true\nbase = \"two\"\nconstant_bits = 13\n",
    ),
    exponential(
        "128 pieces of 2^-u",
        "form = \"piecewise\"\npieces = 128\npipelined = true\nbase = \"two\"\nconstant_bits = 13\n",
    ),
];

const fn gathering(name: &'static str, preset: &'static str, text: &'static str) -> Variant {
    Variant {
        name,
        unit: UnitKind::Gathering,
        preset,
        text,
    }
}

const fn exponential(name: &'static str, text: &'static str) -> Variant {
    Variant {
        name,
        unit: UnitKind::Vector,
        preset: "",
        text,
    }
}

impl Variant {
    /// Its configuration.
    ///
    /// # Errors
    /// It breaks a rule of configurations.
    pub fn config(&self) -> Result<Config, ConfigError> {
        if let Some((_, text)) = PRESETS.into_iter().find(|(name, _)| *name == self.preset) {
            return Config::from_toml(text, self.name);
        }
        let text = match self.unit {
            UnitKind::Gathering | UnitKind::ArrayMac | UnitKind::Splat => self.text.to_owned(),
            UnitKind::Vector => format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{}", self.text),
        };
        Config::from_toml(&text, self.name)
    }
}

/// A way to build the feature table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Table {
    /// Its name.
    pub name: &'static str,
    /// Number of memories.
    pub count: u64,
    /// Shape of one.
    pub shape: Shape,
}

/// The channel-major table of a configuration, M ports and double buffered, from banks with ever
/// fewer ports. The second is the generated one, of whose ports one writes; all but the last read M rows a cycle while a row is
/// written.
#[must_use]
pub fn tables(config: &Config) -> [Table; 4] {
    let (banks, ports) = (u64::from(config.gu.banks), u64::from(config.gu.ports));
    let rows = u64::from(config.mft_rows());
    let table = |name, count, words, read_writes, writes, reads| Table {
        name,
        count,
        shape: Shape {
            words,
            bits: config.gu.feature_bits.into(),
            read_writes,
            writes,
            reads,
        },
    };
    let both = rows + rows.next_power_of_two();
    [
        table(
            "both halves in a bank, 1 write and M read ports",
            banks,
            both,
            0,
            1,
            ports,
        ),
        table("halves apart, M ports", 2 * banks, rows, 1, 0, ports - 1),
        table(
            "halves apart, M copies with a port",
            2 * banks * ports,
            rows,
            1,
            0,
            0,
        ),
        table(
            "halves apart, a port: half the samples",
            2 * banks,
            rows,
            1,
            0,
            0,
        ),
    ]
}

/// The memories that the paper's "44 K" names, 32 KB of features once and 12 KB of ray
/// indices: with M ports and the RIT in the banks that are generated, and all with one
/// port and the RIT in two memories of 96 bits.
#[must_use]
pub fn once(config: &Config) -> [(&'static str, Vec<Table>); 2] {
    let [_, apart, _, one] = tables(config);
    let half = |table: Table| Table {
        count: table.count / 2,
        ..table
    };
    let bytes = 48 * u64::from(config.rit.entries);
    let rit = |name, count, words, bits, read_writes, writes, reads| Table {
        name,
        count,
        shape: Shape {
            words,
            bits,
            read_writes,
            writes,
            reads,
        },
    };
    // A memory for each beat of a row.
    let bits = u64::from(config.rit_stream_bits());
    let beats = u64::from(config.rit_row_bits()) / bits;
    let banks = rit("RIT", beats, 16 * bytes / (beats * bits), bits, 0, 1, 1);
    let wide = rit("RIT", 2, bytes / 12, 96, 1, 0, 0);
    [
        (
            "MFT once, M ports; RIT as generated",
            vec![half(apart), banks],
        ),
        (
            "MFT once, a port; RIT in 2 memories of 96 bits, a port",
            vec![half(one), wide],
        ),
    ]
}

/// Multiply-accumulate units of the paper's array.
const ARRAY: u64 = 24 * 24;

/// Square micrometres of the paper's array, of units as [`UnitKind::ArrayMac`].
#[must_use]
pub fn array_um2(mac: &UnitReport) -> f64 {
    ARRAY as f64 * mac.area_um2
}

/// Square micrometres of what joins lanes and banks in a feature-major unit: the
/// arbiters of the banks, and of each lane what is no register, its decoder and its
/// place in the crossbar; 0 for other organisations.
#[must_use]
pub fn crossbar_um2(unit: &UnitReport) -> f64 {
    let of = |name: &str| unit.modules.iter().find(|m| m.module == name);
    let arbiters = of("bank_arbiter").map_or(0.0, |m| m.count as f64 * m.area_um2);
    let lanes = of("gather_lane").map_or(0.0, |m| m.count as f64 * (m.area_um2 - m.flop_area_um2));
    arbiters + lanes
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{ModuleArea, SynthReport};

    #[test]
    fn every_variant_is_a_configuration_and_no_two_are_the_same() {
        let variants = GATHERING.iter().chain(&EXPONENTIALS);
        let mut hashes: Vec<_> = variants.map(|v| v.config().unwrap().hash()).collect();
        let count = hashes.len();
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), count);
        assert_eq!(GATHERING[0].config().unwrap(), Config::paper());
    }

    fn module(name: &str, count: u64, flops: u64, area_um2: f64, flop_area_um2: f64) -> ModuleArea {
        ModuleArea {
            module: name.to_owned(),
            count,
            cells: 10 * flops,
            flops,
            area_um2,
            flop_area_um2,
        }
    }

    /// The paper's gathering unit with these modules in place of its own.
    fn unit(modules: Vec<ModuleArea>) -> UnitReport {
        let mut unit = SynthReport::checked_in().unwrap()[0]
            .clone()
            .raw
            .units
            .remove(0);
        unit.flops = modules.iter().map(|m| m.count * m.flops).sum();
        unit.modules = modules;
        unit
    }

    /// As docs/explanation/synthesis.md states it at 12 nm.
    #[test]
    fn an_array_is_its_units() {
        let [paper, _] = SynthReport::checked_in().unwrap();
        let mac = paper.unit(UnitKind::ArrayMac).unwrap();
        assert_eq!(format!("{:.3}", array_um2(mac) * 2.29e-6), "0.229");
    }

    #[test]
    fn a_crossbar_is_arbiters_and_what_is_no_register_of_lanes() {
        let own = unit(vec![
            module("gathering_unit", 1, 100, 90.0, 50.0),
            module("bank_arbiter", 16, 4, 3.0, 1.0),
            module("gather_lane", 8, 20, 12.0, 10.5),
        ]);
        assert_eq!(crossbar_um2(&own), 16.0 * 3.0 + 8.0 * 1.5);
        let paper = SynthReport::checked_in().unwrap()[0]
            .clone()
            .raw
            .units
            .remove(0);
        assert_eq!(crossbar_um2(&paper), 0.0);
    }

    #[test]
    fn tables_hold_the_same_rows() {
        let config = Config::paper();
        let bits = u64::from(2 * config.gu.banks * config.mvoxel.rows * config.gu.feature_bits);
        for (at, table) in tables(&config).iter().enumerate() {
            let copies = if at == 2 { 2 } else { 1 };
            assert_eq!(
                table.count * table.shape.words * table.shape.bits,
                copies * bits,
                "{table:?}"
            );
        }
        for (name, once) in once(&config) {
            let bytes: u64 = once
                .iter()
                .map(|t| t.count * t.shape.words * t.shape.bits / 8)
                .sum();
            assert_eq!(bytes, 44 << 10, "{name}");
        }
        let emitted = &GATHERING[0].unit.module(&config).unwrap().memory_macros()[0];
        let generated = tables(&config)[1];
        assert_eq!(u64::from(emitted.count), generated.count);
        assert_eq!(u64::from(emitted.words), generated.shape.words);
        assert_eq!(u64::from(emitted.read_writes), generated.shape.read_writes);
        assert_eq!(u64::from(emitted.reads), generated.shape.reads);
    }
}
