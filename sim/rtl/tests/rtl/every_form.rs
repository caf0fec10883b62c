//! Every form of the exponential, as plain as it gets: the netlist against the reference unit in
//! every bit, and against the cycle model in every cycle.
//!
//! A form that is added to the registries is tested here as well.

use potamoi_cycles::exponential::Exponents;
use potamoi_cycles::vector_unit::{VectorInputs, VectorModel};
use potamoi_formats::config::{Config, ExpForm};
use potamoi_formats::units::OpCode;
use potamoi_netlist::Interpreter;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_units::vector_unit::vector_unit;

/// Operands of a form, spread over its input.
const OPERANDS: usize = 257;

struct Unit {
    run: Interpreter,
}

impl Unit {
    fn new(config: &Config) -> Self {
        let module = vector_unit(config).unwrap();
        let mut unit = Self {
            run: Interpreter::new(&module, 7),
        };
        for port in module.ports().iter().filter(|p| !p.output) {
            unit.set(&port.name, 0);
        }
        unit.set("s_axis_vec_tkeep", 0xff);
        unit.set("s_axis_vec_tuser", OpCode::Exp.code().into());
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
}

#[test]
fn every_form_is_its_reference_unit_and_its_cycle_model() {
    for &form in ExpForm::ALL {
        let mut config = Config::default();
        config.vu.lanes = 1;
        config.vu.ops = vec![OpCode::Exp];
        config.vu.exp = form.plain();
        follow(&config, form.name());
    }
}

fn follow(config: &Config, name: &str) {
    let exp = &config.vu.exp;
    let (reference, exponents) = (ReferenceExponential::new(exp), Exponents::of(config));
    let (low, high) = (exp.input.min() as i64, exp.input.max() as i64);
    let last = (OPERANDS - 1) as i64;
    let operands: Vec<i32> = (0..=last)
        .map(|i| (low + (high - low) * i / last) as i32)
        .collect();
    let mut unit = Unit::new(config);
    let mut model = VectorModel::new(config).unwrap();
    let (mut sent, mut results) = (0, vec![]);
    let mut cycle = 0u64;
    while results.len() < operands.len() {
        assert!(cycle < 100_000, "{name}: {} results", results.len());
        let next = operands.get(sent).copied();
        // The sink is busy in two cycles of five.
        let ready = cycle % 5 < 3;
        unit.set("s_axis_vec_tvalid", next.is_some().into());
        unit.set("s_axis_vec_tdata", next.unwrap_or(0) as u32 as u64);
        unit.set("m_axis_vec_tready", ready.into());
        let out = model.step(&VectorInputs {
            op: next.map(|_| OpCode::Exp.code()),
            exponent: next.map_or(0, |a| exponents.least(OpCode::Exp, &[a])),
            ready,
        });
        for (port, expected) in [
            ("s_axis_vec_tready", u64::from(out.ready)),
            ("m_axis_vec_tvalid", out.valid.into()),
            ("stat_vectors", out.vectors.into()),
            ("stat_busy", out.busy.into()),
            ("stat_stall_out", out.stall_out.into()),
        ] {
            assert_eq!(unit.get(port), expected, "{name}: {port} in cycle {cycle}");
        }
        if out.valid && ready {
            results.push(unit.get("m_axis_vec_tdata") as u32 as i32);
        }
        sent += usize::from(next.is_some() && out.ready);
        unit.run.clock().unwrap();
        cycle += 1;
    }
    for (a, found) in operands.iter().zip(results) {
        assert_eq!(found, reference.exp(*a), "{name}: the power of {a}");
    }
}
