//! `sim/UNIT.gtkw`: the signals of a bench's dump, by stream, for GTKWave.

use std::fmt::Write as _;

use super::Unit;

/// Streams and groups by the begin of their ports' names.
const GROUPS: [(&str, &str); 10] = [
    ("s_axil_", "bus"),
    ("cfg_", "settings"),
    ("s_axis_rit_", "RIT stream"),
    ("s_axis_mft_", "MVoxel rows"),
    ("s_axis_vec_", "operands"),
    ("s_axis_spl_", "records"),
    ("m_axis_feat_", "features"),
    ("m_axis_vec_", "results"),
    ("m_axis_pix_", "pixels"),
    ("stat_", "counters and flags"),
];

pub(super) fn text(unit: &Unit) -> String {
    let name = unit.name;
    let mut text = format!(
        "[*] Open after: make DUMP=1 UNITS={name}, with: gtkwave {name}.gtkw\n\
         [dumpfile] \"build/{name}.vcd\"\n"
    );
    let state = unit
        .ports
        .iter()
        .filter(|port| ["idle", "irq"].contains(&&*port.name));
    let state = state.map(|port| port.name.as_str());
    for signal in ["clk", "rst_n"].into_iter().chain(state) {
        text += &line(name, signal, 1);
    }
    for (begin, title) in GROUPS {
        let own = unit.ports.iter();
        let own: Vec<_> = own.filter(|port| port.name.starts_with(begin)).collect();
        if !own.is_empty() {
            let _ = writeln!(text, "@200\n-{title}");
        }
        for port in own {
            text += &line(name, &port.name, port.ty.width);
        }
    }
    text
}

/// A signal: a bit as such, a word in hexadecimal, right-justified.
fn line(unit: &str, signal: &str, width: u32) -> String {
    match width {
        1 => format!("@28\n{unit}_tb.unit.{signal}\n"),
        _ => format!("@22\n{unit}_tb.unit.{signal}[{}:0]\n", width - 1),
    }
}
