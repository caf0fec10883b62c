//! Every element-wise operation: a unit that has no other, against the reference unit in every bit.
//!
//! An operation that is added to `OpCode::ALL` is tested here as well.

use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_netlist::Interpreter;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_units::vector_unit::vector_unit;

/// Operands at the ends and around 0, and some between.
const OPERANDS: [i32; 9] = [
    i32::MIN,
    i32::MIN + 1,
    -65_537,
    -1,
    0,
    1,
    12_345,
    i32::MAX - 1,
    i32::MAX,
];

/// Units in which an operation is built in another way, or beside another operation.
const UNITS: [&str; 3] = [
    "",
    "registered = true",
    "operands = { multiply = [20, 12], square_sum = 10 }",
];

#[test]
fn every_operation_is_its_reference_unit() {
    for own in UNITS {
        for op in OpCode::ALL.into_iter().filter(|op| !op.is_exponential()) {
            // Alone, and beside the operations whose sums it may share.
            let others = [OpCode::Add, OpCode::SquareSum].into_iter();
            let beside = [op].into_iter().chain(others.filter(|other| *other != op));
            for ops in [vec![op], beside.collect()] {
                let text = format!("[vu]\nlanes = 1\n{own}\n");
                let mut config = Config::from_toml(&text, "test").unwrap();
                config.vu.ops = ops;
                compare(&config, op);
            }
        }
    }
}

/// An operation of a unit on all pairs of operands.
fn compare(config: &Config, op: OpCode) {
    let module = vector_unit(config).unwrap();
    let mut run = Interpreter::new(&module, 7);
    let reference = ReferenceVectorUnit::new(&config.vu);
    let ports: Vec<_> = module.ports().into_iter().filter(|p| !p.output).collect();
    let set = |run: &mut Interpreter, name: &str, value: u64| {
        let port = run.port(name).unwrap();
        run.set_u64(port, value).unwrap();
    };
    for port in &ports {
        set(&mut run, &port.name, 0);
    }
    for (name, value) in [("s_axis_vec_tkeep", 0xff), ("m_axis_vec_tready", 1)] {
        set(&mut run, name, value);
    }
    run.clock().unwrap();
    set(&mut run, "rst_n", 1);
    for rounding in [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven] {
        for shift in [0, 7, 33] {
            for (a, b) in OPERANDS.iter().flat_map(|a| OPERANDS.map(|b| (*a, b))) {
                let code = VectorOp {
                    code: op,
                    shift,
                    rounding,
                };
                let data = u64::from(a as u32) | u64::from(b as u32) << 32;
                set(&mut run, "s_axis_vec_tdata", data);
                set(&mut run, "s_axis_vec_tuser", code.field().into());
                set(&mut run, "s_axis_vec_tvalid", 1);
                run.clock().unwrap();
                set(&mut run, "s_axis_vec_tvalid", 0);
                let valid = run.port("m_axis_vec_tvalid").unwrap();
                let mut waited = 0;
                loop {
                    run.eval().unwrap();
                    if run.get_u64(valid).unwrap() == 1 {
                        break;
                    }
                    waited += 1;
                    assert!(waited < 10, "{op:?} gives no result");
                    run.clock().unwrap();
                }
                let data = run.port("m_axis_vec_tdata").unwrap();
                let found = run.get_u64(data).unwrap() as u32 as i32;
                let expected = reference.element(code, a, b).unwrap();
                let unit = &config.vu;
                assert_eq!(found, expected, "{code:?} of {a} and {b} in {unit:?}");
                run.clock().unwrap();
            }
        }
    }
}
