//! A library's energies and timing for the cells of a netlist, and its units.

use std::collections::BTreeMap;

use potamoi_gates::{Flat, Gate};

use super::cell::{CellPower, Timing};
use super::table::Tables;
use super::unavailable::Unavailable;
use crate::cell_gates::gates;
use crate::liberty::{self, Group};
use crate::{Library, SynthError};

/// A library read for power. Missing data is reported when a cell is used.
pub(crate) struct PowerLibrary {
    file: Group,
    origin: String,
    pub(crate) gates: BTreeMap<String, Result<Gate, String>>,
    pub(super) units: Units,
    buffer: String,
    /// Load of a unit's outputs, in the library's unit.
    pub(super) output_load: f64,
}

/// Units of the library's numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    pub(super) time_ps: f64,
    pub(super) load_ff: f64,
    /// Supply voltage in volts.
    pub(super) volts: f64,
    /// Unit of energy in femtojoules: a unit of capacitance at the square of a unit of voltage.
    pub(super) energy_fj: f64,
    pub(super) leakage_nw: f64,
}

impl PowerLibrary {
    /// Reads the parts of the library that area and period do not need.
    pub(crate) fn read(library: &Library) -> Result<Self, SynthError> {
        let file = liberty::parse(&library.text, &library.path)?;
        let volts_unit = library.voltage_v;
        Ok(Self {
            units: Units {
                time_ps: library.time_ps,
                load_ff: library.capacitance_ff,
                volts: library.volts.unwrap_or(0.0) * volts_unit,
                energy_fj: library.capacitance_ff * volts_unit * volts_unit,
                leakage_nw: 1e9 * library.leakage_w,
            },
            gates: gates(&file),
            origin: library.path.clone(),
            buffer: library.buffer.clone(),
            output_load: library.load(),
            file,
        })
    }

    /// Data of the cells of a netlist, in the order of its gates.
    pub(super) fn cells(&self, flat: &Flat) -> Result<Vec<CellPower>, Unavailable> {
        if self.units.volts <= 0.0 {
            let what = "the library has no nom_voltage above 0";
            return Err(Unavailable::Absent(what.to_owned()));
        }
        flat.gates.iter().map(|gate| self.cell(gate)).collect()
    }

    fn cell(&self, gate: &Gate) -> Result<CellPower, Unavailable> {
        let tables = Tables::of(&self.file, &self.origin);
        let cell = self.file.groups("cell").find(|c| c.name() == gate.name);
        let cell = cell.ok_or_else(|| Unavailable::of(gate, "no cell"))?;
        CellPower::read(&tables, cell, gate)
    }

    /// Assumed transition of inputs, memories and the clock: that of the smallest buffer loaded
    /// with four of its inputs, driven by another one.
    pub(super) fn transition(&self) -> Result<f64, Unavailable> {
        let gate = self.gates.get(&self.buffer).and_then(|g| g.as_ref().ok());
        let what = || Unavailable::Absent(format!("the buffer {} has no delays", self.buffer));
        let buffer = self.cell(gate.ok_or_else(what)?)?;
        let timing: &Timing = buffer.timings[0][0].first().ok_or_else(what)?;
        let mut transition = timing.first_transition();
        for _ in 0..8 {
            transition = timing.transition(transition, self.output_load);
        }
        Ok(transition)
    }
}

/// Assumed transition of inputs in picoseconds; `None` where the library does not state it.
pub(crate) fn usual_transition_ps(library: &Library) -> Result<Option<f64>, SynthError> {
    let own = PowerLibrary::read(library)?;
    match own.transition() {
        Ok(transition) => Ok(Some(transition * own.units.time_ps)),
        Err(Unavailable::Absent(_)) => Ok(None),
        Err(Unavailable::Wrong(error)) => Err(error),
    }
}
