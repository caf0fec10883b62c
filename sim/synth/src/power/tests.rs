//! Energies of small netlists worked out by hand, and incomplete libraries.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_gates::Flat;

use super::count::Counter;
use super::library::PowerLibrary;
use super::static_data::{StaticData, named_loads};
use super::unavailable::Unavailable;
use crate::{Library, SynthError};

const HANDFUL: &str = include_str!("../../cells/handful.lib");

fn library(text: &str) -> Result<PowerLibrary, SynthError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cells.lib");
    std::fs::write(&path, text).unwrap();
    PowerLibrary::read(&Library::read(Path::new(&path))?)
}

/// A flip-flop that toggles at every clock.
const TURNS: &str = "module top(clk, y);\n input clk;\n output y;\n wire q;\n\
    DFF d (.CK(clk), .D(y), .Q(q));\n INV i (.A(q), .Y(y));\nendmodule\n";

fn still(library: &PowerLibrary, netlist: &str) -> Result<StaticData, Unavailable> {
    let flat = Flat::new(netlist, "top", &library.gates, &BTreeMap::new()).unwrap();
    StaticData::new(library, &Arc::new(flat), &BTreeMap::new())
}

/// All values are worked out from the model at the head of the library.
#[test]
fn the_energy_of_two_cells_is_what_it_is_by_hand() {
    let library = library(HANDFUL).unwrap();
    let still = still(&library, TURNS).unwrap();
    // Of a buffer with four of its inputs behind it: t = 2.2 x 2 x (2 + 4) + t / 10.
    let clock = 26.4 / 0.9;
    assert!((still.clock_transition - clock).abs() < 1e-6);
    // `q` goes to an inverter, `y` to the flip-flop and out.
    let (q, y) = (still.flat.inputs(1)[0], still.flat.inputs(0)[0]);
    let at_q = 2.2 * 4.0 * (3.0 + 1.0) + 0.1 * clock;
    let at_y = 2.2 * 4.0 * (1.0 + 4.9) + 0.1 * at_q;
    for (net, load, transition) in [(q, 1.0, at_q), (y, 4.9, at_y)] {
        assert!((still.load(net) - load).abs() < 1e-9);
        assert!((still.transition(net) - transition).abs() < 1e-6);
    }
    // Clock to q, q to y: picoseconds, rounded.
    let to_q = 3.0 * (3.0 + 0.7 * 4.0 * 3.0) + 0.7 * 4.0 + 0.2 * clock;
    let to_y = 3.0 + 0.7 * 4.0 + 0.7 * 4.0 * 4.9 + 0.2 * at_q;
    let each = [to_q, to_q, to_y, to_y].map(|d: f64| d.round() as u32);
    assert_eq!(still.delays.cells, each);

    for is_delayed in [false, true] {
        let mut engine = still.engine(is_delayed, 1, Counter::new(&still)).unwrap();
        let simulator = &mut engine.simulator;
        simulator.is_watched = true;
        for _ in 0..101 {
            simulator.settle().unwrap();
            simulator.edge().unwrap();
        }
        // 101 clocks, 100 of which moved both nets, half of them up.
        assert_eq!(simulator.watch.toggles(), 200);
        let all = simulator.watch.energies(&still, simulator.cycles);
        let found = all[0];
        let switching = 100.0 * 0.5 * (1.0 + 4.9);
        let flop = 50.0 * (2.0 * 1.5 + (0.004 + 0.006) * clock);
        let inverter = 50.0 * (2.0 * 0.5 + (0.004 + 0.006) * at_q);
        let data = 50.0 * (0.6 + 0.5 + 2.0 * 0.004 * at_y);
        let internal = flop + inverter + data;
        let on_clock = 101.0 * (0.8 + 1.5 + 1.0 + 2.0 * 0.004 * clock);
        for (found, expected) in [
            (found.switching, switching),
            (found.internal, internal),
            (found.clock, on_clock),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found}, {expected}");
        }
    }
    // 0.1 and 0.8 nW.
    assert!((still.leakage_nw()[0] - 0.9).abs() < 1e-9);
}

/// In a slice, a net has the load of the whole unit for timing, and its own for energy.
#[test]
fn nets_of_a_larger_unit_are_as_slow_as_there() {
    let library = library(HANDFUL).unwrap();
    let flat = Flat::new(TURNS, "top", &library.gates, &BTreeMap::new()).unwrap();
    let flat = Arc::new(flat);
    let loads = named_loads(&library, &flat).unwrap();
    assert!((loads["q"] - 1.0).abs() < 1e-9 && (loads["y"] - 4.9).abs() < 1e-9);
    let whole = BTreeMap::from([("q".to_owned(), 31.0)]);
    let found = StaticData::new(&library, &flat, &whole).unwrap();
    let (q, y) = (flat.inputs(1)[0], flat.inputs(0)[0]);
    let at_q = 2.2 * 4.0 * (3.0 + 31.0) + 0.1 * found.clock_transition;
    assert!((found.load(q) - 1.0).abs() < 1e-9 && (found.far_load(q) - 31.0).abs() < 1e-9);
    assert!((found.far_load(y) - 4.9).abs() < 1e-9);
    assert!((found.transition(q) - at_q).abs() < 1e-6);
    let to_q = 3.0 * (3.0 + 0.7 * 4.0 * 3.0) + 0.7 * 4.0 * 31.0 + 0.2 * found.clock_transition;
    assert_eq!(found.delays.cells[0], to_q.round() as u32);
}

/// Conditions select energies, two rails are averaged, and energies count by half where the clock's
/// level is not known.
#[test]
fn conditions_and_rails_are_heeded() {
    let two = "internal_power () { related_pin : \"A\"; related_pg_pin : VDD; \
        rise_power (scalar) { values (\"3\"); } fall_power (scalar) { values (\"1\"); } } \
        internal_power () { related_pin : \"A\"; related_pg_pin : VSS; \
        rise_power (scalar) { values (\"1\"); } fall_power (scalar) { values (\"5\"); } }";
    let start = HANDFUL.find("cell (INV)").unwrap();
    let power = start + HANDFUL[start..].find("internal_power").unwrap();
    let end = power + HANDFUL[power..].find("    }\n  }\n").unwrap();
    let mut text = format!("{}{two}{}", &HANDFUL[..power], &HANDFUL[end..]);
    text = text.replace(
        "pin (D) {\n      direction : input;",
        "pin (D) {\n      direction : input;\n      internal_power () { when : \"CK !Q\"; \
         power (scalar) { values (\"8\"); } }",
    );
    let library = library(&text).unwrap();
    let still = still(&library, TURNS).unwrap();
    let [flop, inverter] = [0, 1].map(|cell| still.cell(cell).clone());
    // An output of 0 rises: (3 + 1) / 2; falls: (1 + 5) / 2.
    for (state, expected) in [(0b00, 2.0), (0b10, 3.0)] {
        let class = inverter.output_class(0, 0, state);
        assert!((inverter.energy(&class, 20.0, 2.0) - expected).abs() < 1e-12);
    }
    // D rises from D = 0: with Q = 0 half of 8 and half of what always counts, else
    // that; the state is D, what is held, Q.
    let always = 0.6 + 0.004 * 20.0;
    for (state, expected) in [(0b000, (8.0 + always) / 2.0), (0b110, always)] {
        let class = flop.input_class(0, state);
        let found = flop.energy(&class, 20.0, 0.0);
        assert!((found - expected).abs() < 1e-12, "{state:b}: {found}");
    }
}

fn lack(text: &str) -> Unavailable {
    library(text)
        .map_err(Unavailable::from)
        .and_then(|library| still(&library, TURNS).map(drop))
        .unwrap_err()
}

#[test]
fn what_a_library_does_not_say_is_absent_and_what_is_wrong_is_an_error() {
    for (from, to, expected) in [
        (
            "internal_power",
            "external_power",
            "cell DFF has no internal_power of its output Q",
        ),
        (
            "cell_leakage_power",
            "cell_shrinkage",
            "cell DFF has no leakage",
        ),
        ("cell_fall", "cell_autumn", "no delay from"),
        ("nom_voltage : 1;", "", "no nom_voltage"),
        (
            "capacitance : 0.9;",
            "",
            "cell DFF has no capacitance of its pin D",
        ),
        (
            "rise_power (by_slew_and_load) {\n          values (\"",
            "rise_power (by_slew_and_load) {\n          values (\"-9",
            "cell DFF has negative internal_power",
        ),
    ] {
        let text = HANDFUL.replace(from, to);
        assert_ne!(text, HANDFUL, "{from}");
        match lack(&text) {
            Unavailable::Absent(why) => assert!(why.contains(expected), "{why}"),
            Unavailable::Wrong(error) => unreachable!("{error}"),
        }
    }
    for (from, to, expected) in [
        (
            "\"1.54, 1.66, 2.14\"",
            "\"1.54, 1.66\"",
            "expected 3 values",
        ),
        ("\"1nW\"", "\"1 horse\"", "leakage_power_unit"),
        ("\"1V\"", "\"1\"", "voltage_unit"),
        (
            "cell_leakage_power : 0.8",
            "cell_leakage_power : some",
            "cell_leakage_power, a number",
        ),
    ] {
        let text = HANDFUL.replacen(from, to, 1);
        assert_ne!(text, HANDFUL, "{from}");
        match lack(&text) {
            Unavailable::Wrong(error @ SynthError::Liberty { .. }) => {
                assert!(error.to_string().contains(expected), "{error}");
            }
            other => unreachable!("{expected}: {other:?}"),
        }
    }
}
