//! Settings, clearing, reset, and the ends of counters.

use potamoi_formats::config::Config;
use potamoi_netlist::{Change, Fault, Interpreter};
use potamoi_units::gathering_unit::gathering_unit;

use super::{UNIT, Unit, entry, even};

/// What a unit goes through before.
type Before<'a> = &'a dyn Fn(&mut Unit);

/// Settings may change while `idle` is high; a change at any other time raises bit 8.
#[test]
fn a_setting_that_moves_while_the_unit_works_is_flagged() {
    let moved = |name: &str, value: u64, when: Before<'_>| {
        let mut unit = Unit::of("", 3, 1);
        when(&mut unit);
        unit.set(name, value);
        unit.run.clock().unwrap();
        unit.run.clock().unwrap();
        unit.get("stat_errors") & 1 << 8
    };
    let whole = |unit: &mut Unit| {
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry(even()));
        assert_eq!(unit.get("idle"), 1);
    };
    let cases: [(&str, Before<'_>, u64); 5] = [
        ("nothing received", &|_| (), 0),
        ("all is done", &whole, 0),
        ("a row received", &|unit| unit.rows(&[1]), 1 << 8),
        ("entries wait", &|unit| unit.rit(&entry(even())), 1 << 8),
        (
            "a result waits",
            &|unit| {
                unit.set("m_axis_feat_tready", 0);
                unit.rows(&[1, 2, 3, 4]);
                unit.rit(&entry(even()));
            },
            1 << 8,
        ),
    ];
    for (what, when, flag) in cases {
        for (name, value) in [("cfg_vertices", 1), ("cfg_segments", 2)] {
            assert_eq!(moved(name, value, when), flag, "{name}, {what}");
        }
    }
}

/// `cfg_clear` in the middle of a job touches counters and flags alone.
#[test]
fn clearing_in_the_middle_changes_no_beat() {
    let beats = |clear: Option<u64>| {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.set("s_axis_rit_tvalid", 1);
        for (data, keep, last) in entry(even()) {
            unit.set("s_axis_rit_tdata", data);
            unit.set("s_axis_rit_tkeep", keep);
            unit.set("s_axis_rit_tlast", u64::from(last));
            unit.run.clock().unwrap();
        }
        unit.set("s_axis_rit_tvalid", 0);
        let mut found = vec![];
        for cycle in 0..40 {
            unit.set("cfg_clear", u64::from(clear == Some(cycle)));
            let ports = ["m_axis_feat_tvalid", "m_axis_feat_tdata", "idle"];
            found.push(ports.map(|name| unit.get(name)));
            unit.run.clock().unwrap();
        }
        assert!(found.iter().any(|[valid, ..]| *valid == 1));
        found
    };
    for cycle in 0..30 {
        assert_eq!(beats(Some(cycle)), beats(None), "cleared in cycle {cycle}");
    }
}

/// In every clock of a reset, the first one included, and before any clock.
#[test]
fn no_stream_is_ready_in_reset() {
    let module = gathering_unit(&Config::from_toml(UNIT, "test").unwrap()).unwrap();
    let mut unit = Unit::new(&module, 3, 1);
    for reset in [1, 0, 0, 1] {
        unit.set("rst_n", reset);
        for stream in ["rit", "mft"] {
            assert_eq!(unit.get(&format!("s_axis_{stream}_tready")), reset);
        }
        unit.run.clock().unwrap();
    }
    let mut fresh = Unit {
        run: Interpreter::new(&module, 5),
    };
    for stream in ["rit", "mft"] {
        assert_eq!(fresh.get(&format!("s_axis_{stream}_tready")), 0);
    }
}

/// A counter of 24 bits would take minutes: its end is forced near instead.
#[test]
fn counters_stop_at_their_maximum() {
    let config = Config::from_toml(UNIT, "test").unwrap();
    let module = gathering_unit(&config).unwrap();
    let near = Fault {
        module: module.name().to_owned(),
        register: "stat_busy".to_owned(),
        change: Change::Reset(((1 << 24) - 5).into()),
    };
    let mut unit = Unit::new(&near.inject(&module).unwrap(), 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    unit.rit(&entry(even()));
    assert_eq!(unit.get("stat_busy"), (1 << 24) - 1);
}
