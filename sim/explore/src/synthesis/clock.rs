//! Requested clock of units against the clock they reach.

use potamoi_synth::UnitReport;

/// Highest clock of a unit before wires, in gigahertz: with the access times of its memories where
/// known, and without.
struct Reached {
    slower: f64,
    cells: f64,
}

impl Reached {
    fn of(unit: &UnitReport) -> Self {
        let memories = unit.with_memories.as_ref().map(|own| own.clock_ghz);
        let cells = unit.clock_ghz;
        Self {
            slower: memories.map_or(cells, |ghz| ghz.min(cells)),
            cells,
        }
    }
}

/// Sentence about the first unit that misses a clock in gigahertz; `None` where all reach it.
#[must_use]
pub fn missed_clock(units: &[UnitReport], clock: f64) -> Option<String> {
    let unit = units.iter().find(|u| Reached::of(u).slower < clock)?;
    let Reached { slower, cells } = Reached::of(unit);
    let reached = match &unit.with_memories {
        Some(_) => format!(
            "{slower:.3} GHz before wires with its memories' access times and {cells:.3} GHz without"
        ),
        None => format!("{cells:.3} GHz before wires"),
    };
    Some(format!(
        "{} reaches {reached}, but --clock is {clock} GHz: see its longest path",
        unit.unit
    ))
}

/// Sentence about units with memories of unknown access time, whose clock is that of cells alone;
/// `None` without such units.
#[must_use]
pub fn without_memories(units: &[UnitReport]) -> Option<String> {
    let has = |u: &&UnitReport| !u.memories.is_empty() && u.with_memories.is_none();
    let names: Vec<&str> = units.iter().filter(has).map(|u| &*u.unit).collect();
    (!names.is_empty()).then(|| {
        format!(
            "--clock is compared with paths that neither begin nor end in a memory of {}: give \
             --node and install CACTI to include access times",
            names.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_synth::SynthReport;

    /// The paper's gathering unit: 1123 ps, 1176 ps with its memories. The vector unit has none:
    /// 1314 ps.
    #[test]
    fn the_slower_of_both_clocks_counts() {
        let [report, _] = SynthReport::checked_in().unwrap();
        let mut units = report.raw.units;
        assert_eq!(missed_clock(&units, 0.75), None);
        let said = missed_clock(&units[..1], 0.86).unwrap();
        assert_eq!(
            said,
            "gathering_unit reaches 0.851 GHz before wires with its memories' access times and \
             0.890 GHz without, but --clock is 0.86 GHz: see its longest path"
        );
        let said = missed_clock(&units, 0.8).unwrap();
        assert!(
            said.starts_with("vector_unit reaches 0.761 GHz before wires, but --clock is 0.8 GHz:"),
            "{said}"
        );
        assert_eq!(without_memories(&units), None);

        // Without access times it is the clock of cells, and that is said.
        units[0].with_memories = None;
        assert_eq!(missed_clock(&units[..1], 0.86), None);
        let said = missed_clock(&units[..1], 0.95).unwrap();
        assert!(
            said.starts_with(
                "gathering_unit reaches 0.890 GHz before wires, but --clock is 0.95 GHz"
            ),
            "{said}"
        );
        let said = without_memories(&units).unwrap();
        assert!(said.contains("a memory of gathering_unit: "), "{said}");
    }
}
