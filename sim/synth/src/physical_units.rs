//! Units and bounds of a library's numbers.
//!
//! The bounds are far beyond any cell of any process. A number past one is damaged or has another
//! unit, and would make later programs fail or answer wrongly.

use super::SynthError;
use super::liberty::{Group, scaled};

/// Largest capacitance of a pin in femtofarads: 1 nF.
const MOST_FF: f64 = 1e6;
/// Largest delay, transition or constraint in picoseconds: 100 us.
const MOST_PS: f64 = 1e8;
/// Picoseconds by which an output may precede its input, where no input transition is known.
const EARLY_PS: f64 = 1e3;
/// Largest internal energy of a transition in femtojoules: 1 uJ.
const MOST_FJ: f64 = 1e9;
/// Largest leakage of a cell in watts.
const MOST_W: f64 = 1.0;
/// Largest area of a cell in square micrometres, the unit of most libraries: 1 cm^2.
const MOST_AREA: f64 = 1e8;

/// Units of a library.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Units {
    pub(super) time_ps: f64,
    pub(super) load_ff: f64,
    pub(super) volts: f64,
    pub(super) leakage_w: f64,
    /// Missing units with the assumed values.
    pub(super) assumed: Vec<String>,
}

/// Bounds of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) least: f64,
    pub(super) most: f64,
    /// The bounds in words, with units.
    pub(super) words: &'static str,
}

impl Units {
    /// Reads a library's units; `path` names its file in errors.
    pub(super) fn read(library: &Group, path: &str) -> Result<Self, SynthError> {
        let mut assumed = vec![];
        let mut unit = |name: &str, usual: &str, base, of, expected: &str| {
            let text = library.value(name).unwrap_or_else(|| {
                assumed.push(format!("{name} is not there: {usual} is taken, as usual"));
                usual
            });
            let expected = || library.wrong(path, &format!("{name}, {expected}"), text);
            scaled(text, base, of).ok_or_else(expected)
        };
        let time_ps = unit("time_unit", "1ns", 's', -12, "as 1ps or 1ns")?;
        let volts = unit("voltage_unit", "1V", 'v', 0, "as 1V or 1mV")?;
        let leakage_w = unit("leakage_power_unit", "1nW", 'w', 0, "as 1nW or 1pW")?;
        let load = library
            .values
            .iter()
            .find(|own| own.name == "capacitive_load_unit");
        let load = load.map_or_else(|| "none".to_owned(), |own| own.values.concat());
        let load_ff = scaled(&load, 'f', -15).ok_or_else(|| {
            let expected = "capacitive_load_unit, as (1, pf) or (1, ff)";
            library.wrong(path, expected, &load)
        })?;
        Ok(Self {
            time_ps,
            load_ff,
            volts,
            leakage_w,
            assumed,
        })
    }

    /// Bounds of a number by the name of its attribute or table; `None` if unbounded. `slowest` is
    /// the longest input transition of a table.
    pub(super) fn bounds(&self, name: &str, slowest: Option<f64>) -> Option<Bounds> {
        let bounds = |least, most, words| Bounds { least, most, words };
        let most_time = MOST_PS / self.time_ps;
        let most_load = MOST_FF / self.load_ff;
        Some(match name {
            "area" => bounds(0.0, MOST_AREA, "of 0 to 1e8 um^2, which is 1 cm^2"),
            "capacitance" | "rise_capacitance" | "fall_capacitance" => {
                bounds(0.0, most_load, "of 0 to 1 nF")
            }
            // Some say so that there is no limit.
            "max_capacitance" | "max_transition" => bounds(0.0, f64::MAX, "of 0 or more"),
            "cell_leakage_power" | "value" => {
                let most = MOST_W / self.leakage_w;
                bounds(-most, most, "of at most 1 W")
            }
            "cell_rise" | "cell_fall" => match slowest {
                // Half of a slow input's way lies before the point that it is measured at.
                Some(slowest) => bounds(
                    -slowest,
                    most_time,
                    "of at most 100 us, and not below minus the slowest input transition of the table",
                ),
                None => bounds(-EARLY_PS / self.time_ps, most_time, "of -1 ns to 100 us"),
            },
            "rise_transition" | "fall_transition" => bounds(0.0, most_time, "of 0 to 100 us"),
            "rise_constraint" | "fall_constraint" => {
                bounds(-most_time, most_time, "of at most 100 us")
            }
            "rise_power" | "fall_power" | "power" => {
                let most = MOST_FJ / (self.load_ff * self.volts * self.volts);
                bounds(-most, most, "of at most 1 uJ")
            }
            _ => return None,
        })
    }
}

impl Bounds {
    pub(super) fn has(&self, number: f64) -> bool {
        (self.least..=self.most).contains(&number)
    }
}
