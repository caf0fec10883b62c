//! Longest path with the access times of memories.
//!
//! Cell libraries lack the memories, so a period of cells leaves out paths from and to them. Here
//! each memory is a cell of its own: its outputs are valid an access time after the clock, and its
//! inputs have no setup time.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use potamoi_formats::config::Config;
use potamoi_netlist::{Module, PortInfo};

use super::power::usual_transition_ps;
use super::retime::{Retiming, Wanted};
use super::script::{MEMORIES, PERIOD, sta_with_memories};
use super::unit::longest_path;
use super::{
    Library, Memories, SynthError, SynthesisedUnit, Tools, UnitKind, WithMemories, scaling,
};

/// Version of the cached format.
const KEPT: &str = "potamoi-access 1";

/// Access times of a unit's memories in picoseconds at the library's node: those at `to_nm`,
/// divided by the factor of logic between the nodes. `None` where the unit has no memories or a
/// factor is not known.
#[must_use]
pub fn access_times(
    memories: &Memories,
    unit: &str,
    from_nm: u32,
    to_nm: u32,
) -> Option<BTreeMap<String, f64>> {
    let logic = scaling::logic(from_nm, to_nm)?;
    let memory = scaling::memory(memories.origin.node_nm, to_nm)?;
    let own = memories.macros.iter().filter(|m| m.of == unit);
    let times = own.map(|m| {
        let access = m.figures.access_ps * memory.delay / logic.delay;
        (m.memory.clone(), access)
    });
    let times: BTreeMap<_, _> = times.collect();
    (!times.is_empty()).then_some(times)
}

/// The longest path of a netlist with its memories' access times from [`access_times`], cached in
/// `cache`.
///
/// # Errors
/// OpenSTA fails or prints output that is not understood; files cannot be written.
pub fn with_memories(
    config: &Config,
    (unit, made): (UnitKind, &SynthesisedUnit),
    access_ps: BTreeMap<String, f64>,
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<WithMemories, SynthError> {
    let modules = unit.module(config)?.memory_modules();
    let own = modules.values().map(|module| {
        let access = access_ps.get(module.name());
        access.map(|access| (&**module, *access))
    });
    let own: Vec<(&Module, f64)> = own.flatten().collect();
    let transition = usual_transition_ps(library)?.unwrap_or(0.0);
    let cells = liberty(&own, transition);
    let wanted = Wanted {
        version: KEPT,
        name: "access",
        what: "path",
        script: &sta_with_memories(unit.top(), library),
        others: &[(MEMORIES, &cells)],
    };
    let retiming = Retiming {
        unit,
        made,
        library,
        tools,
        cache,
    };
    retiming.run(&wanted, |said| {
        let path = longest_path(said)?;
        let period_ps = (PERIOD - path.slack) * library.time_ps;
        Some(WithMemories {
            access_ps,
            period_ps,
            clock_ghz: 1e3 / period_ps,
            path: path.ends,
            path_cells: path.cells,
        })
    })
}

/// Memories as Liberty cells, in picoseconds and femtofarads.
fn liberty(memories: &[(&Module, f64)], transition: f64) -> String {
    let mut text = "library (memories) {\n\
        delay_model : table_lookup;\n\
        time_unit : \"1ps\";\n\
        voltage_unit : \"1V\";\n\
        current_unit : \"1uA\";\n\
        pulling_resistance_unit : \"1kohm\";\n\
        capacitive_load_unit (1, ff);\n"
        .to_owned();
    for kind in ["input", "output"] {
        for edge in ["rise", "fall"] {
            let _ = writeln!(text, "{kind}_threshold_pct_{edge} : 50;");
        }
    }
    for edge in ["rise", "fall"] {
        for (end, percent) in [("lower", 10), ("upper", 90)] {
            let _ = writeln!(text, "slew_{end}_threshold_pct_{edge} : {percent};");
        }
    }
    let all = || memories.iter().flat_map(|(module, _)| module.ports());
    let widths: BTreeSet<u32> = all().map(|p| p.ty.width).collect();
    for width in widths.into_iter().filter(|width| *width > 1) {
        let last = width - 1;
        let _ = writeln!(
            text,
            "type (bits{width}) {{ base_type : array; data_type : bit; bit_width : {width}; \
             bit_from : {last}; bit_to : 0; downto : true; }}"
        );
    }
    for (module, access) in memories {
        let _ = writeln!(text, "cell ({}) {{ area : 0;", module.name());
        text += "pin (clk) { direction : input; capacitance : 0; clock : true; }\n";
        for port in module.ports().iter().filter(|p| p.name != "clk") {
            text += &pin(port, *access, transition);
        }
        text += "}\n";
    }
    text + "}\n"
}

fn pin(port: &PortInfo, access: f64, transition: f64) -> String {
    let of = |table: &str, value: f64| format!("{table} (scalar) {{ values (\"{value}\"); }} ");
    let (direction, kind, tables) = match port.output {
        true => (
            "output",
            "rising_edge",
            ["cell_rise", "cell_fall"].map(|t| of(t, access)).concat()
                + &["rise_transition", "fall_transition"]
                    .map(|t| of(t, transition))
                    .concat(),
        ),
        false => (
            "input",
            "setup_rising",
            ["rise_constraint", "fall_constraint"]
                .map(|t| of(t, 0.0))
                .concat(),
        ),
    };
    let head = match port.ty.width {
        1 => format!("pin ({}) {{", port.name),
        width => format!("bus ({}) {{ bus_type : bits{width};", port.name),
    };
    format!(
        "{head} direction : {direction}; capacitance : 0; timing () {{ related_pin : \"clk\"; \
         timing_type : {kind}; {tables}}} }}\n"
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::SynthReport;
    use crate::liberty::{Group, parse};

    /// CACTI's access time at 22 nm, times 12 / 22, over 1.26.
    #[test]
    fn access_times_are_at_the_library_s_node() {
        let memories = SynthReport::checked_in().unwrap()[0]
            .clone()
            .raw
            .memories
            .unwrap();
        let of = |unit: UnitKind, from, to| access_times(&memories, unit.top(), from, to);
        let found = of(UnitKind::Gathering, 7, 12).unwrap();
        assert_eq!(found.len(), 2);
        for memory in &memories.macros[..2] {
            let expected = memory.figures.access_ps * 12.0 / 22.0 / 1.26;
            let own = found[&memory.memory];
            assert!((own / expected - 1.0).abs() < 1e-9, "{found:?}");
        }
        assert_eq!(of(UnitKind::Vector, 7, 12), None);
        assert_eq!(of(UnitKind::Gathering, 180, 12), None);
    }

    #[test]
    fn memories_are_cells_with_the_ports_of_their_modules() {
        let module = UnitKind::Gathering.module(&Config::paper()).unwrap();
        let modules = module.memory_modules();
        let text = liberty(&[(&modules["mft_bank"], 300.5)], 20.0);
        let library = parse(&text, "memories.lib").unwrap();
        let cell = library.groups("cell").next().unwrap();
        assert_eq!(cell.name(), "mft_bank");
        let names = |kind| cell.groups(kind).map(Group::name).collect::<Vec<_>>();
        assert_eq!(names("pin"), ["clk", "we", "re0", "re1"]);
        let buses = ["wdata", "addr0", "rdata0", "addr1", "rdata1"];
        assert_eq!(names("bus"), buses);
        let value = |bus: &str, table: &str| {
            let bus = cell.groups("bus").find(|b| b.name() == bus).unwrap();
            let timing = bus.groups("timing").next().unwrap();
            let table = timing.groups(table).next().unwrap();
            table.numbers("values").unwrap()
        };
        assert_eq!(value("rdata1", "cell_fall"), [300.5]);
        assert_eq!(value("rdata0", "rise_transition"), [20.0]);
        assert_eq!(value("addr0", "rise_constraint"), [0.0]);
    }
}
