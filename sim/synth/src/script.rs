//! Scripts of Yosys, ABC and OpenSTA.

use std::fmt::Write as _;

use super::Library;
use super::fanout::FAN_OUT;

/// File names in the folder in which the programs run.
pub(super) const LIBRARY: &str = "cells.lib";
/// Memories as cells, for timing.
pub(super) const MEMORIES: &str = "memories.lib";
pub(super) const NETLIST: &str = "netlist.v";
pub(super) const STATISTICS: &str = "cells.json";
/// Netlist as mapped, and with buffers between modules.
pub(super) const MAPPED: &str = "mapped.json";
pub(super) const BUFFERED: &str = "buffered.json";
const ABC: &str = "map.abc";
const CONSTRAINTS: &str = "map.constr";

/// ABC's target in picoseconds: below what any unit reaches, so that it maps and sizes for speed.
const AIM_PS: u32 = 400;
/// Period from which slack is taken, in the library's unit of time; of the order of paths, since
/// OpenSTA has 24 bits.
pub(super) const PERIOD: f64 = 1000.0;
/// More than the path ends of any unit.
const ENDS: u32 = 10_000_000;
/// First release of Yosys whose `synth` makes Booth multipliers.
const BOOTH: (u32, u32) = (0, 36);

/// Scripts of a unit by file name, beside its Verilog.
pub(super) struct Scripts {
    pub(super) yosys: String,
    pub(super) finish: String,
    pub(super) sta: String,
    pub(super) others: [(&'static str, String); 2],
}

/// Of a unit whose top module is `top`, in files that are read as Verilog or, those
/// that are `macros`, by their ports alone. `version` is that of Yosys.
///
/// Modules are mapped one by one: flattened, a gathering unit takes twenty times as
/// long for a twentieth of the area (measured with Yosys 0.70).
pub(super) fn scripts(
    top: &str,
    modules: &[&str],
    macros: &[&str],
    library: &Library,
    version: (u32, u32),
) -> Scripts {
    let mut yosys = String::new();
    let mut line = |text: String| {
        let _ = writeln!(yosys, "{text}");
    };
    if !macros.is_empty() {
        line(format!("read_verilog -lib {}", macros.join(" ")));
    }
    line(format!("read_verilog {}", modules.join(" ")));
    line(format!("hierarchy -check -top {top}"));
    let booth = if version >= BOOTH { " -booth" } else { "" };
    line(format!("synth -top {top}{booth} -run begin:fine"));
    // ABC maps once, below: mapped twice, a reducer is half as fast again as it could be.
    line(format!("synth -top {top}{booth} -run fine:check -noabc"));
    line("check -assert".to_owned());
    // Flip-flops are named by what they hold.
    line("splitnets".to_owned());
    line("rename -wire -suffix _reg t:$_*DFF*".to_owned());
    line(format!("dfflibmap -liberty {LIBRARY}"));
    line("opt".to_owned());
    line(format!(
        "abc -script {ABC} -constr {CONSTRAINTS} -liberty {LIBRARY}"
    ));
    line("setundef -zero".to_owned());
    line("opt_clean -purge".to_owned());
    line(format!("write_json {MAPPED}"));
    let finish = format!(
        "read_json {BUFFERED}\ntee -q -o {STATISTICS} stat -json\n\
         write_verilog -noattr -simple-lhs {NETLIST}\n"
    );

    let buffer = &library.buffer;
    let load = library.load();
    let abc = format!(
        "strash\n&get -n\n&st\n&dch\n&nf -D {AIM_PS}\n&put\nbuffer -c -p -N {FAN_OUT}\ntopo\n\
         upsize -D {AIM_PS}\ndnsize -D {AIM_PS}\n"
    );
    // ABC takes femtofarads whatever the library's unit.
    let constraints = format!(
        "set_driving_cell {buffer}\nset_load {} [all_outputs]\n",
        load * library.capacitance_ff
    );
    Scripts {
        yosys,
        finish,
        sta: sta(top, buffer, load),
        others: [(ABC, abc), (CONSTRAINTS, constraints)],
    }
}

/// Script that prints the longest path of the netlist.
fn sta(top: &str, buffer: &str, load: f64) -> String {
    let report = "report_checks -path_delay max -format full -digits 6";
    format!("{}{report}\nexit\n", constraints(top, buffer, load))
}

/// Script that prints the longest path with memories as cells.
pub(super) fn sta_with_memories(top: &str, library: &Library) -> String {
    let cells = format!("read_liberty {LIBRARY}\n");
    let both = format!("{cells}read_liberty {MEMORIES}\n");
    sta(top, &library.buffer, library.load()).replacen(&cells, &both, 1)
}

/// Script that prints the slack at each path end of the netlist, one line each.
pub(super) fn sta_of_ends(top: &str, library: &Library) -> String {
    let report = format!("report_checks -path_delay max -format end -digits 6 -group_count {ENDS}");
    let constraints = constraints(top, &library.buffer, library.load());
    format!("{constraints}{report}\nexit\n")
}

/// Reads the netlist, with clock, input drive and output load.
fn constraints(top: &str, buffer: &str, load: f64) -> String {
    format!(
        "read_liberty {LIBRARY}\n\
         read_verilog {NETLIST}\n\
         link_design {top}\n\
         create_clock -name clk -period {PERIOD} [get_ports clk]\n\
         set inputs [list]\n\
         foreach port [all_inputs] {{\n  \
         if {{[get_property $port full_name] != \"clk\"}} {{ lappend inputs $port }}\n}}\n\
         set_input_delay 0 -clock clk $inputs\n\
         set_output_delay 0 -clock clk [all_outputs]\n\
         set_driving_cell -lib_cell {buffer} $inputs\n\
         set_load {load} [all_outputs]\n"
    )
}
