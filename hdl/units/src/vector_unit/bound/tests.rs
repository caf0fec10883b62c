#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use potamoi_netlist::{Change, Fault, Interpreter};

use super::*;

fn config(n: u32, change: impl Fn(&mut Config)) -> Config {
    let mut config = Config::default();
    config.vu.lanes = 1;
    config.vu.ops = vec![OpCode::Exp, OpCode::OneMinusExp];
    config.vu.exp.iterations = n;
    change(&mut config);
    config
}

/// The largest error of an operation over every `apart`-th operand, measured by interpreting the
/// netlist.
fn measured_of(op: OpCode, config: &Config, module: &Arc<Module>, apart: usize) -> f64 {
    let mut unit = Interpreter::new(module, 1);
    let port = |name: &str| unit.port(name).unwrap();
    let (data, valid, ready) = (
        port("s_axis_vec_tdata"),
        port("s_axis_vec_tvalid"),
        port("s_axis_vec_tready"),
    );
    let (result, done) = (port("m_axis_vec_tdata"), port("m_axis_vec_tvalid"));
    let others = [
        ("rst_n", 1),
        ("cfg_clear", 0),
        ("s_axis_vec_tkeep", 0xff),
        ("s_axis_vec_tlast", 0),
        ("s_axis_vec_tuser", u64::from(op.code())),
        ("m_axis_vec_tready", 1),
    ]
    .map(|(name, value)| (port(name), value));
    unit.clock().unwrap();
    for (port, value) in others {
        unit.set_u64(port, value).unwrap();
    }
    let exp = &config.vu.exp;
    let one = 2f64.powi(exp.output_bits as i32);
    let mut worst = 0.0f64;
    let codes = match op.is_logistic() {
        true => -(16i64 << exp.input.frac_bits())..=16 << exp.input.frac_bits(),
        false => 1..=exp.input.max() as i64,
    };
    for code in codes.step_by(apart) {
        unit.set_u64(data, code as u64 & 0xffff_ffff).unwrap();
        unit.set_u64(valid, 1).unwrap();
        unit.eval().unwrap();
        while unit.get_u64(ready).unwrap() == 0 {
            unit.clock().unwrap();
            unit.eval().unwrap();
        }
        unit.clock().unwrap();
        unit.set_u64(valid, 0).unwrap();
        unit.eval().unwrap();
        while unit.get_u64(done).unwrap() == 0 {
            unit.clock().unwrap();
            unit.eval().unwrap();
        }
        let found = unit.get_u64(result).unwrap() as f64;
        let x = code as f64 * 2f64.powi(-(exp.input.frac_bits() as i32));
        let exact = match op {
            OpCode::Sigmoid => (one / (1.0 + (-x).exp())).min(one - 1.0),
            OpCode::Softplus => one * (x.max(0.0) + (-x.abs()).exp().ln_1p()),
            _ => one * (-x).exp(),
        };
        worst = worst.max((found - exact).abs());
        unit.clock().unwrap();
    }
    worst
}

fn measured(config: &Config, module: &Arc<Module>, apart: usize) -> f64 {
    measured_of(OpCode::Exp, config, module, apart)
}

/// A configuration with sigmoid and softplus.
fn logistic(n: u32, tail: bool, clock: u32, widths: (u32, u32)) -> Config {
    config(n, |c| {
        c.vu.ops = vec![OpCode::Exp, OpCode::Sigmoid, OpCode::Softplus];
        c.vu.exp.tail = tail;
        c.vu.exp.iterations_per_clock = clock;
        c.vu.exp.accumulator_bits = Some(widths.0);
        c.vu.exp.constant_bits = Some(widths.1);
        c.vu.exp.offset = Some(0);
    })
}

/// With a tail.
#[test]
fn sigmoid_and_softplus_have_a_bound_of_the_same_kind() {
    logistic_results_keep_to_their_bound(&[logistic(9, true, 1, (18, 19))]);
}

/// Two steps a clock, and few steps.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn other_steps_of_sigmoid_and_softplus_have_a_bound_of_the_same_kind() {
    logistic_results_keep_to_their_bound(&[
        logistic(18, false, 2, (20, 20)),
        logistic(10, false, 1, (18, 18)),
    ]);
}

fn logistic_results_keep_to_their_bound(configs: &[Config]) {
    for config in configs {
        let module = vector_unit(config).unwrap();
        for op in [OpCode::Softplus, OpCode::Sigmoid] {
            let bound = error_bound(config, op).unwrap().unwrap();
            let found = measured_of(op, config, &module, 997);
            println!("{op:?}: {found:.3} of {bound:?}");
            assert!(found <= bound.ulp, "{op:?}: {found}, bound {bound:?}");
            assert!(found > 0.2 * bound.ulp, "{op:?}: {found}, bound {bound:?}");
        }
    }
}

/// A constant is used by both exponential and logarithm.
#[test]
fn a_wrong_constant_is_in_the_bound_of_softplus() {
    wrong_constants_are_in_the_bound(OpCode::Softplus, &[("sr_sub[6]", 7)]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn every_wrong_constant_is_in_the_bound_of_sigmoid_and_softplus() {
    wrong_constants_are_in_the_bound(OpCode::Softplus, &[("sr_mul[9]", 0)]);
    wrong_constants_are_in_the_bound(OpCode::Sigmoid, &[("sr_sub[6]", 7), ("sr_mul[9]", 0)]);
}

/// Registers of constants, and the bit that is inverted.
fn wrong_constants_are_in_the_bound(op: OpCode, faults: &[(&str, u32)]) {
    let config = logistic(18, false, 2, (20, 20));
    let module = vector_unit(&config).unwrap();
    let right = largest(&config, op, &module).unwrap();
    for &(register, bit) in faults {
        let fault = Fault {
            module: "exp_constants".to_owned(),
            register: register.to_owned(),
            change: Change::ResetBit(bit),
        };
        let wrong = fault.inject(&module).unwrap();
        let bound = largest(&config, op, &wrong).map_or(f64::INFINITY, |b| b.ulp);
        let found = measured_of(op, &config, &wrong, 4_001);
        println!("{op:?} {register}: {found:.3} of {bound:.3}, {right:?}");
        assert!(
            found <= bound && bound > right.ulp + 0.5,
            "{op:?} {register}: {found}, {bound}"
        );
    }
}

#[test]
fn widths_bound_the_error_from_both_sides() {
    for n in [8, 12, 16, 27] {
        let config = config(n, |_| ());
        let bound = error_bound(&config, OpCode::Exp).unwrap().unwrap();
        let found = measured(&config, &vector_unit(&config).unwrap(), 7);
        println!("n {n}: {found:.3} of {bound:?}");
        assert!(found <= bound.ulp, "n = {n}: {found}, bound {bound:?}");
        assert!(found > 0.5 * bound.ulp, "n = {n}: {found}, bound {bound:?}");
        assert!(
            bound.dropped < bound.ulp && bound.dropped >= 0.5,
            "{bound:?}"
        );
    }
}

#[test]
fn pieces_have_a_bound_of_the_same_kind() {
    for pieces in [64, 128] {
        let config = config(16, |c| {
            c.vu.exp.form = ExpForm::Piecewise;
            c.vu.exp.pipelined = true;
            c.vu.exp.pieces = pieces;
        });
        let bound = error_bound(&config, OpCode::Exp).unwrap().unwrap();
        let found = measured(&config, &vector_unit(&config).unwrap(), 7);
        println!("{pieces} pieces: {found:.3} of {bound:?}");
        assert!(found <= bound.ulp, "{pieces}: {found}, bound {bound:?}");
        assert!(
            found > 0.6 * bound.ulp,
            "{pieces}: {found}, bound {bound:?}"
        );
    }
}

/// The analysis reads the netlist: a wrong constant or shift amount changes the bound.
#[test]
fn a_wrong_register_is_in_the_bound() {
    let config = config(16, |_| ());
    let module = vector_unit(&config).unwrap();
    let right = largest(&config, OpCode::Exp, &module).unwrap();
    for (register, bit) in [
        ("sr_sub[6]", 5),
        ("sr_sub[0]", 5),
        ("sr_mul[9]", 0),
        ("sr_sub[15]", 2),
    ] {
        let fault = Fault {
            module: "exp_constants".to_owned(),
            register: register.to_owned(),
            change: Change::ResetBit(bit),
        };
        let wrong = fault.inject(&module).unwrap();
        let bound = largest(&config, OpCode::Exp, &wrong).map_or(f64::INFINITY, |b| b.ulp);
        let found = measured(&config, &wrong, 31);
        println!(
            "{register} bit {bit}: {found:.3} of {bound:.3}, {:.3} unharmed",
            right.ulp
        );
        assert!(found <= bound, "{register}: {found}, bound {bound}");
        assert!(
            bound > right.ulp + 0.5,
            "{register}: {bound}, unharmed {right:?}"
        );
    }
}

/// Other schedules of the same steps, and pipelines, have about the same error.
#[test]
fn schedules_change_little() {
    let plain = error_bound(&config(16, |_| ()), OpCode::Exp)
        .unwrap()
        .unwrap();
    for (iterations_per_clock, pipelined) in [(2, false), (4, false), (1, true), (2, true)] {
        let other = config(16, |c| {
            c.vu.exp.iterations_per_clock = iterations_per_clock;
            c.vu.exp.pipelined = pipelined;
        });
        let other = error_bound(&other, OpCode::Exp).unwrap().unwrap();
        assert!(
            (other.ulp / plain.ulp - 1.0).abs() < 0.02,
            "{other:?} {plain:?}"
        );
    }
}

#[test]
fn other_results_have_no_bound_here() {
    let none =
        |change: &dyn Fn(&mut Config), op| error_bound(&config(16, change), op).unwrap().is_none();
    assert!(none(&|c| c.vu.exp.form = ExpForm::Literal, OpCode::Exp));
    assert!(none(&|c| c.vu.ops = vec![OpCode::OneMinusExp], OpCode::Exp));
    assert!(none(&|_| (), OpCode::Add));
    assert!(!none(&|_| (), OpCode::OneMinusExp));
}
