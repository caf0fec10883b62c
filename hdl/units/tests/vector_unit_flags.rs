//! The vector unit's flags and counters, by hand.

use potamoi_formats::config::Config;
use potamoi_netlist::Interpreter;
use potamoi_units::vector_unit::vector_unit;

struct Unit {
    run: Interpreter,
}

impl Unit {
    /// A lane that adds and nothing else.
    fn new() -> Self {
        let config = Config::from_toml("[vu]\nlanes = 1\nops = [\"add\"]", "test").unwrap();
        let module = vector_unit(&config).unwrap();
        let mut unit = Self {
            run: Interpreter::new(&module, 5),
        };
        for port in module.ports().iter().filter(|p| !p.output) {
            unit.set(&port.name, 0);
        }
        unit.set("m_axis_vec_tready", 1);
        unit.set("rst_n", 0);
        unit.run.clock().unwrap();
        unit.set("rst_n", 1);
        unit
    }

    fn set(&mut self, name: &str, value: u64) {
        let port = self.run.port(name).unwrap();
        self.run.set_u64(port, value).unwrap();
    }

    fn get(&mut self, name: &str) -> u64 {
        let port = self.run.port(name).unwrap();
        self.run.eval().unwrap();
        self.run.get_u64(port).unwrap()
    }

    fn vector(&mut self, code: u64, rounding: u64) {
        self.kept(0xff, code, rounding);
    }

    fn kept(&mut self, keep: u64, code: u64, rounding: u64) {
        self.set("s_axis_vec_tvalid", 1);
        self.set("s_axis_vec_tkeep", keep);
        self.set("s_axis_vec_tuser", code | rounding << 10);
        assert_eq!(self.get("s_axis_vec_tready"), 1);
        self.run.clock().unwrap();
        self.set("s_axis_vec_tvalid", 0);
        self.run.clock().unwrap();
    }
}

#[test]
fn each_flag_has_its_own_bit_and_clears() {
    const ADD: u64 = 2;
    for (code, rounding, flags) in [
        (ADD, 0, 0),
        (ADD, 2, 0),
        (3, 0, 1 << 0),
        (15, 0, 1 << 0),
        (ADD, 3, 1 << 1),
        (0, 3, 0b11),
    ] {
        let mut unit = Unit::new();
        unit.vector(code, rounding);
        assert_eq!(unit.get("stat_errors"), flags, "{code} {rounding}");
        unit.vector(ADD, 0);
        assert_eq!(unit.get("stat_errors"), flags, "sticky");
        assert_eq!(unit.get("stat_vectors"), 2);
        unit.set("cfg_clear", 1);
        unit.run.clock().unwrap();
        unit.set("cfg_clear", 0);
        for name in ["stat_errors", "stat_vectors", "stat_busy", "stat_stall_out"] {
            assert_eq!(unit.get(name), 0, "{name} is cleared");
        }
    }
}

/// A lane is kept whole or not at all; its lowest byte decides.
#[test]
fn a_lane_with_some_of_its_bytes_is_flagged() {
    const ADD: u64 = 2;
    for keep in 0..=0xff {
        let mut unit = Unit::new();
        unit.set("s_axis_vec_tdata", 7 << 32 | 5);
        unit.set("m_axis_vec_tready", 0);
        unit.kept(keep, ADD, 0);
        let torn = !matches!(keep, 0 | 0xff);
        assert_eq!(unit.get("stat_errors"), u64::from(torn) << 2, "{keep:#x}");
        for _ in 0..4 {
            unit.run.clock().unwrap();
        }
        assert_eq!(unit.get("m_axis_vec_tvalid"), 1);
        let (bytes, sum) = if keep & 1 == 1 { (0xf, 12) } else { (0, 0) };
        assert_eq!(unit.get("m_axis_vec_tkeep"), bytes, "{keep:#x}");
        assert_eq!(unit.get("m_axis_vec_tdata"), sum, "{keep:#x}");
    }
}

#[test]
fn idle_falls_with_a_vector_and_rises_with_its_result() {
    let mut unit = Unit::new();
    assert_eq!(unit.get("idle"), 1);
    unit.set("m_axis_vec_tready", 0);
    unit.vector(2, 0);
    for _ in 0..20 {
        assert_eq!(unit.get("idle"), 0);
        unit.run.clock().unwrap();
    }
    unit.set("m_axis_vec_tready", 1);
    assert_eq!((unit.get("m_axis_vec_tvalid"), unit.get("idle")), (1, 0));
    unit.run.clock().unwrap();
    assert_eq!((unit.get("m_axis_vec_tvalid"), unit.get("idle")), (0, 1));
}
