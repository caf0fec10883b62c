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
        self.set("s_axis_vec_tvalid", 1);
        self.set("s_axis_vec_tkeep", 1);
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
