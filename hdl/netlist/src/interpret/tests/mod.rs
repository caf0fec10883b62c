#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod operators;

use num_bigint::{BigInt, BigUint};

use super::{InterpretError, Interpreter};
use crate::{ModuleBuilder, Ty};
use operators::value;

#[test]
fn a_register_resets_holds_and_takes_over() {
    let mut b = ModuleBuilder::new("count");
    let en = b.input("en", Ty::bit(), "");
    let r = b.reg("r", Ty::s(70), -3);
    let one = b.lit(1, Ty::s(70));
    let next = b.add(r, one);
    b.set_next_if(r, en, next);
    b.output("q", r, "");
    let module = b.finish().unwrap();
    let mut run = Interpreter::new(&module, 7);
    let (rst_n, en, q) = (
        run.port("rst_n").unwrap(),
        run.port("en").unwrap(),
        run.port("q").unwrap(),
    );
    let read = |run: &Interpreter| value(&run.words(q).unwrap(), Ty::s(70));
    let other = Interpreter::new(&module, 8);
    assert_ne!(read(&run), read(&other), "registers start as the seed says");
    run.clock().unwrap();
    assert_eq!(read(&run), BigInt::from(-3));
    run.set_u64(rst_n, 1).unwrap();
    run.clock().unwrap();
    assert_eq!(read(&run), BigInt::from(-3), "not enabled");
    run.set_u64(en, 1).unwrap();
    for want in -2..5 {
        run.clock().unwrap();
        assert_eq!(read(&run), BigInt::from(want));
    }
    run.set_u64(rst_n, 0).unwrap();
    run.eval().unwrap();
    assert_eq!(read(&run), BigInt::from(4), "reset is synchronous");
    run.clock().unwrap();
    assert_eq!(read(&run), BigInt::from(-3));
    assert_eq!(run.peek("r").unwrap().count_ones(), 69);
}

/// Before any clock, and again in the middle of a run; without its gate it is what it
/// is out of reset. No register asks for the `rst_n` of this module.
#[test]
fn a_port_that_is_low_in_reset_is_so_at_once() {
    let mut b = ModuleBuilder::new("gate");
    let up = b.input("up", Ty::bit(), "");
    b.output_low_in_reset("ready", up, "as up");
    let module = b.finish().unwrap();
    let mut run = Interpreter::new(&module, 7);
    let [rst_n, up, ready] = ["rst_n", "up", "ready"].map(|name| run.port(name).unwrap());
    run.set_u64(up, 1).unwrap();
    for reset in [0, 1, 0] {
        run.set_u64(rst_n, reset).unwrap();
        run.eval().unwrap();
        assert_eq!(run.get_u64(ready).unwrap(), reset);
    }
    let header = crate::Header {
        origin: String::new(),
        command: String::new(),
    };
    let text = crate::verilog(&module, &header).remove("gate.v").unwrap();
    assert!(text.contains("// as up; low in reset\n"), "{text}");
    assert!(text.contains("assign ready = rst_n & up;"), "{text}");
    let bare = module.without_reset_gates();
    let text = crate::verilog(&bare.into(), &header)
        .remove("gate.v")
        .unwrap();
    assert!(text.contains("// as up\n"), "{text}");
    assert!(text.contains("assign ready = up;"), "{text}");
}

#[test]
fn memories_read_first_hold_and_ignore_what_is_past_them() {
    let mut b = ModuleBuilder::new("store");
    let (we, re) = (b.input("we", Ty::bit(), ""), b.input("re", Ty::bit(), ""));
    let (addr, data) = (
        b.input("addr", Ty::u(3), ""),
        b.input("data", Ty::u(100), ""),
    );
    let mem = b.memory("rows", 6, 100, "");
    b.mem_write(mem, we, addr, data);
    let q = b.mem_read(mem, re, addr, "q_reg");
    b.output("q", q, "");
    let now = b.mem_read_async(mem, addr);
    b.output("now", now, "");
    let module = b.finish().unwrap();
    let start = |seed| {
        let mut run = Interpreter::new(&module, seed);
        let names = ["we", "re", "addr", "data", "q", "now"];
        let ports = names.map(|n| run.port(n).unwrap());
        run.set_u64(ports[0], 0).unwrap();
        (run, ports)
    };
    let (mut run, [we, re, addr, data, q, now]) = start(1);
    run.eval().unwrap();
    let (mut other, _) = start(2);
    other.eval().unwrap();
    assert_ne!(run.words(now).unwrap(), other.words(now).unwrap());
    assert_ne!(run.words(q).unwrap(), other.words(q).unwrap());

    run.set_u64(we, 1).unwrap();
    run.set_u64(re, 1).unwrap();
    let before = run.words(now).unwrap();
    run.set_words(data, &[1, 2, 3, 0xf]).unwrap();
    run.clock().unwrap();
    assert_eq!(
        run.words(q).unwrap(),
        before,
        "what was there before the write"
    );
    assert_eq!(run.words(now).unwrap(), [1, 2, 3, 0xf]);
    run.set_u64(re, 0).unwrap();
    run.clock().unwrap();
    assert_eq!(run.words(q).unwrap(), before, "holds");
    for past in 6..8 {
        run.set_u64(addr, past).unwrap();
        run.set_words(data, &[9; 4]).unwrap();
        run.clock().unwrap();
        assert_eq!(run.words(now).unwrap(), [0; 4]);
    }
    run.set_u64(addr, 0).unwrap();
    run.eval().unwrap();
    assert_eq!(run.words(now).unwrap(), [1, 2, 3, 0xf]);
}

#[test]
fn a_memory_of_any_size_costs_what_is_written() {
    let mut b = ModuleBuilder::new("huge");
    let (we, addr) = (b.input("we", Ty::bit(), ""), b.input("addr", Ty::u(32), ""));
    let data = b.input("data", Ty::u(65_536), "");
    let mem = b.memory("rows", u32::MAX, 65_536, "");
    b.mem_write(mem, we, addr, data);
    let now = b.mem_read_async(mem, addr);
    b.output("now", now, "");
    let mut run = Interpreter::new(&b.finish().unwrap(), 1);
    let [we, addr, data, now] = ["we", "addr", "data", "now"].map(|n| run.port(n).unwrap());
    run.set_u64(we, 1).unwrap();
    for row in [0, 77, u64::from(u32::MAX) - 1] {
        run.set_u64(addr, row).unwrap();
        run.set_words(data, &[row as u32; 2048]).unwrap();
        run.clock().unwrap();
        assert_eq!(run.words(now).unwrap(), vec![row as u32; 2048]);
    }
    run.set_u64(addr, 78).unwrap();
    run.eval().unwrap();
    let first = run.words(now).unwrap();
    run.eval().unwrap();
    assert_eq!(
        run.words(now).unwrap(),
        first,
        "contents never written stay what they are"
    );
    assert_ne!(first, vec![0; 2048]);
}

#[test]
fn instances_are_in_the_middle_of_their_parents() {
    let mut b = ModuleBuilder::new("step");
    let x = b.input("x", Ty::u(8), "");
    let r = b.reg("kept", Ty::u(8), 0);
    b.set_next(r, x);
    let sum = b.add(x, r);
    b.output("sum", sum, "");
    let inner = b.finish().unwrap();
    let mut b = ModuleBuilder::new("two");
    let x = b.input("x", Ty::u(8), "");
    let not = b.not(x);
    let first = b.instance("first", &inner, &[("x", not)]);
    let s = b.out(first, "sum");
    let second = b.instance("second", &inner, &[("x", s)]);
    let t = b.out(second, "sum");
    let t = b.not(t);
    b.output("y", t, "");
    let mut run = Interpreter::new(&b.finish().unwrap(), 1);
    let [rst_n, x, y] = ["rst_n", "x", "y"].map(|n| run.port(n).unwrap());
    run.clock().unwrap();
    run.set_u64(rst_n, 1).unwrap();
    let (mut r1, mut r2) = (0u8, 0u8);
    for value in [3u8, 200, 17, 0, 255] {
        run.set_u64(x, u64::from(value)).unwrap();
        run.eval().unwrap();
        let s = (!value).wrapping_add(r1);
        assert_eq!(run.get_u64(y).unwrap(), u64::from(!s.wrapping_add(r2)));
        assert_eq!(run.peek("second.kept"), Some(BigUint::from(r2)));
        assert_eq!(run.peek("second.x"), Some(BigUint::from(s)));
        assert_eq!(run.peek("third.x"), None);
        run.clock().unwrap();
        (r1, r2) = (!value, s);
    }
}

#[test]
fn an_instance_may_be_given_what_follows_from_its_outputs() {
    let mut b = ModuleBuilder::new("stage");
    let x = b.input("x", Ty::u(8), "");
    let r = b.reg("kept", Ty::u(8), 9);
    b.set_next(r, x);
    let not = b.not(x);
    b.output("q", r, "");
    b.output("not_x", not, "");
    let inner = b.finish().unwrap();
    let mut b = ModuleBuilder::new("ring");
    let stage = b.instance("stage_0", &inner, &[]);
    let (q, not) = (b.out(stage, "q"), b.out(stage, "not_x"));
    let one = b.lit(1, Ty::u(8));
    let more = b.add(q, one);
    b.connect(stage, "x", more);
    b.output("count", q, "");
    b.output("down", not, "");
    let mut run = Interpreter::new(&b.finish().unwrap(), 1);
    let [rst_n, count, down] = ["rst_n", "count", "down"].map(|n| run.port(n).unwrap());
    run.clock().unwrap();
    run.set_u64(rst_n, 1).unwrap();
    for want in 10..30 {
        run.clock().unwrap();
        assert_eq!(run.get_u64(count).unwrap(), want);
        assert_eq!(run.get_u64(down).unwrap(), 255 - (want + 1));
    }
}

#[test]
fn wrong_uses_are_refused() {
    let mut b = ModuleBuilder::new("wide");
    let x = b.input("x", Ty::u(65), "");
    b.output("y", x, "");
    let module = b.finish().unwrap();
    let mut run = Interpreter::new(&module, 1);
    let error = run.port("z").unwrap_err().to_string();
    assert_eq!(error, "module wide has no port `z`; its ports are x, y");
    assert!(run.port("rst_n").is_err(), "nothing to reset");
    let [x, y] = ["x", "y"].map(|n| run.port(n).unwrap());
    assert!(matches!(
        run.set_u64(x, 0),
        Err(InterpretError::WrongWidth {
            bits: 65,
            words: 3,
            ..
        })
    ));
    assert!(matches!(
        run.get_u64(y),
        Err(InterpretError::WrongWidth { .. })
    ));
    assert!(matches!(
        run.set_words(x, &[0; 2]),
        Err(InterpretError::WrongWidth { .. })
    ));
    assert_eq!(
        run.set_words(y, &[0; 3]),
        Err(InterpretError::NotAnInput("y".to_owned()))
    );
    let mut b = ModuleBuilder::new("other");
    let a = b.input("a", Ty::u(65), "");
    b.output("b", a, "");
    let other = Interpreter::new(&b.finish().unwrap(), 1);
    assert_eq!(other.words(x), Err(InterpretError::ForeignPort));
    run.set_words(x, &[u32::MAX; 3]).unwrap();
    assert_eq!(
        run.words(y).unwrap(),
        [u32::MAX, u32::MAX, 1],
        "bits above the width are dropped"
    );
}
