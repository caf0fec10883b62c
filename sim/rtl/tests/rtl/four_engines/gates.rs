//! A unit's Verilog as gates, by Yosys.

use std::collections::BTreeMap;
use std::process::Command;

/// Memories of more words stay memories.
const WORDS: u32 = 8;

/// The files of a unit as one module of gates and flip-flops without enable or reset. The gates
/// alone see to it that unknown state ends.
pub(super) fn of(unit: &str, files: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let names: Vec<_> = files.keys().map(String::as_str).collect();
    let script = format!(
        "read_verilog {}; hierarchy -check -top {unit}; proc; flatten; opt; memory -nomap; \
         memory_map r:SIZE<={WORDS}; opt; techmap; opt_expr; opt_merge; opt_clean; simplemap; \
         dfflegalize -cell $_DFF_P_ x; opt_expr; opt_merge; opt_clean; \
         write_verilog -noattr gates.v",
        names.join(" ")
    );
    let done = Command::new("yosys")
        .current_dir(folder.path())
        .args(["-q", "-p", &script])
        .output();
    let done = done.unwrap_or_else(|e| panic!("yosys: {e}; tools/setup installs it"));
    assert!(
        done.status.success(),
        "yosys, {unit}: {}",
        String::from_utf8_lossy(&done.stderr)
    );
    let text = std::fs::read_to_string(folder.path().join("gates.v")).unwrap();
    // All state is in plain flip-flops, apart from large memories.
    assert_eq!(text.matches("\nmodule ").count(), 1, "{unit}");
    assert!(!text.contains("if (!rst_n)"), "{unit}");
    BTreeMap::from([(format!("{unit}.v"), text)])
}
