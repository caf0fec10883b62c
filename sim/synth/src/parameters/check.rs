//! Checks of a report's figures: they are above 0, and sums, clocks and scaled figures follow from
//! the others.

use potamoi_base::file_keys::told;

use crate::SynthReport;
use crate::report::{COMMAND, ScaledEnergy, with_memories_ps};

/// Tolerance of sums of rounded decimals.
const NEAR: f64 = 1e-9;

impl SynthReport {
    /// Checks the command and all figures.
    ///
    /// # Errors
    /// The first figure that is wrong, with what was expected.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.command != COMMAND {
            let told = told(&self.command);
            return Err(format!("command `{told}`, expected `{COMMAND}`"));
        }
        for unit in &self.raw.units {
            let name = &unit.unit;
            let netlists = unit.netlists.check(name);
            netlists.map_err(|why| format!("{name}: {why}"))?;
            positive(name, "area_um2", unit.area_um2)?;
            positive(name, "period_ps", unit.period_ps)?;
            equal(name, "clock_ghz", unit.clock_ghz, 1e3 / unit.period_ps)?;
            if let Some(own) = &unit.with_memories {
                positive(name, "with_memories.period_ps", own.period_ps)?;
                let ghz = 1e3 / own.period_ps;
                equal(name, "with_memories.clock_ghz", own.clock_ghz, ghz)?;
            }
            let area = unit.modules.iter().map(|m| m.count as f64 * m.area_um2);
            equal(name, "area_um2", unit.area_um2, area.sum())?;
            let cells: u64 = unit.modules.iter().map(|m| m.count * m.cells).sum();
            equal(name, "cells", unit.cells as f64, cells as f64)?;
        }
        let memories = self.raw.memories.iter().flat_map(|m| &m.macros);
        for own in memories {
            let f = &own.figures;
            let fields = [
                ("area_um2", f.area_um2),
                ("read_pj", f.read_pj),
                ("write_pj", f.write_pj),
                ("leakage_mw", f.leakage_mw),
                ("access_ps", f.access_ps),
                ("cycle_ps", f.cycle_ps),
            ];
            for (field, value) in fields {
                positive(&own.memory, field, value)?;
            }
        }
        self.check_scaled()
    }

    /// Checks that scaled figures follow from raw ones and the factors.
    fn check_scaled(&self) -> Result<(), String> {
        let Some(scaled) = &self.scaled else {
            return Ok(());
        };
        if let Some(logic) = &scaled.logic {
            if logic.units.len() != self.raw.units.len() {
                return Err("scaled.logic.units: as many as in raw.units expected".to_owned());
            }
            for (unit, raw) in logic.units.iter().zip(&self.raw.units) {
                let name = format!("scaled {}", told(&unit.unit));
                if unit.unit != raw.unit {
                    return Err(format!("{name}, expected {}", raw.unit));
                }
                let factors = &logic.factors;
                equal(
                    &name,
                    "area_um2",
                    unit.area_um2,
                    raw.area_um2 * factors.area,
                )?;
                equal(
                    &name,
                    "period_ps",
                    unit.period_ps,
                    raw.period_ps * factors.delay,
                )?;
                equal(&name, "clock_ghz", unit.clock_ghz, 1e3 / unit.period_ps)?;
                let expected = with_memories_ps(raw, factors);
                match (unit.with_memories_ps, expected) {
                    (None, None) => {}
                    (Some(own), Some(expected)) => {
                        equal(&name, "with_memories_ps", own, expected)?;
                    }
                    _ => {
                        return Err(format!(
                            "{name}: with_memories_ps, expected where the raw unit has it"
                        ));
                    }
                }
                check_energy(&name, unit.energy, ScaledEnergy::of(raw, factors))?;
            }
        }
        let Some(memories) = &scaled.memories else {
            return Ok(());
        };
        let raw = self.raw.memories.as_ref().map_or(&[][..], |m| &m.macros);
        if memories.macros.len() != raw.len() {
            return Err("scaled.memories.macros: as many as in raw.memories expected".to_owned());
        }
        for (own, raw) in memories.macros.iter().zip(raw) {
            let name = format!("scaled {}", told(&own.memory));
            if (&own.memory, &own.of) != (&raw.memory, &raw.of) {
                return Err(format!("{name}, expected {}", raw.memory));
            }
            let expected = raw.figures.scaled(&memories.factors);
            equal(&name, "area_um2", own.figures.area_um2, expected.area_um2)?;
            equal(&name, "read_pj", own.figures.read_pj, expected.read_pj)?;
            equal(&name, "write_pj", own.figures.write_pj, expected.write_pj)?;
            equal(
                &name,
                "leakage_mw",
                own.figures.leakage_mw,
                expected.leakage_mw,
            )?;
            equal(
                &name,
                "access_ps",
                own.figures.access_ps,
                expected.access_ps,
            )?;
            equal(&name, "cycle_ps", own.figures.cycle_ps, expected.cycle_ps)?;
        }
        Ok(())
    }
}

fn check_energy(
    of: &str,
    found: Option<ScaledEnergy>,
    expected: Option<ScaledEnergy>,
) -> Result<(), String> {
    let fields = |e: ScaledEnergy| {
        [
            ("zero_delay_pj_a_cycle", e.zero_delay_pj_a_cycle),
            ("with_glitches_pj_a_cycle", e.with_glitches_pj_a_cycle),
            ("zero_delay_pj_an_item", e.zero_delay_pj_an_item),
            ("with_glitches_pj_an_item", e.with_glitches_pj_an_item),
        ]
    };
    match (found, expected) {
        (None, None) => Ok(()),
        (Some(found), Some(expected)) => fields(found)
            .into_iter()
            .zip(fields(expected))
            .try_for_each(|((field, a), (_, b))| equal(of, field, a, b)),
        _ => Err(format!(
            "{of}: energy, expected where the raw unit has power"
        )),
    }
}

fn positive(of: &str, field: &str, value: f64) -> Result<(), String> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(format!("{of}: {field} {value}, expected a number above 0")),
    }
}

fn equal(of: &str, field: &str, found: f64, expected: f64) -> Result<(), String> {
    match (found / expected - 1.0).abs() < NEAR || found == expected {
        true => Ok(()),
        false => Err(format!(
            "{of}: {field} {found}, expected {expected} by its other figures"
        )),
    }
}
