//! Every misuse of the netlist builder, and what is said of it.

use std::sync::Arc;

use potamoi_formats::fixed::Rounding;
use potamoi_netlist::{Feed, Module, ModuleBuilder, Signal, Ty};

/// What the errors are after a misuse of a module with an input of each type.
fn errors(misuse: impl FnOnce(&mut ModuleBuilder, &Inputs)) -> String {
    let mut b = ModuleBuilder::new("unit");
    let inputs = Inputs {
        bit: b.input("a_bit", Ty::bit(), ""),
        byte: b.input("a_byte", Ty::u(8), ""),
        int: b.input("an_int", Ty::s(8), ""),
        word: b.input("a_word", Ty::u(16), ""),
    };
    for s in [inputs.bit, inputs.byte, inputs.int, inputs.word] {
        b.unused(s, "only there to be misused");
    }
    misuse(&mut b, &inputs);
    b.finish().map(|_| ()).unwrap_err().to_string()
}

struct Inputs {
    bit: Signal,
    byte: Signal,
    int: Signal,
    word: Signal,
}

/// Nothing is done with the stand-in that a misuse gives.
fn done<T>(_: T) {}

type Misuse = fn(&mut ModuleBuilder, &Inputs);

fn leaf() -> Arc<Module> {
    leaf_of(ModuleBuilder::not)
}

fn leaf_of(op: fn(&mut ModuleBuilder, Signal) -> Signal) -> Arc<Module> {
    let mut b = ModuleBuilder::new("leaf");
    let x = b.input("x", Ty::u(8), "");
    let y = op(&mut b, x);
    b.output("y", y, "");
    b.finish().unwrap()
}

#[test]
fn operators_refuse_what_does_not_agree() {
    const DIFFER: &str =
        "operands differ: a_byte: u8 and a_word: u16; extend, truncate or reinterpret one";
    type Two = fn(&mut ModuleBuilder, Signal, Signal) -> Signal;
    let two: [(&str, Two); 9] = [
        ("and", ModuleBuilder::and),
        ("or", ModuleBuilder::or),
        ("xor", ModuleBuilder::xor),
        ("add", ModuleBuilder::add),
        ("sub", ModuleBuilder::sub),
        ("eq", ModuleBuilder::eq),
        ("ne", ModuleBuilder::ne),
        ("lt", ModuleBuilder::lt),
        ("le", ModuleBuilder::le),
    ];
    for (name, op) in two {
        let text = errors(|b, i| {
            op(b, i.byte, i.word);
        });
        assert_eq!(text, format!("module unit: {name}: {DIFFER}"));
        let text = errors(|b, i| {
            op(b, i.byte, i.int);
        });
        assert!(text.contains("a_byte: u8 and an_int: s8"), "{text}");
    }
}

#[test]
fn every_misuse_is_reported_and_none_panics() {
    let cases: &[(Misuse, &str)] = &[
        (
            |b, i| done(b.mul(i.byte, i.int)),
            "mul: signedness differs: a_byte: u8 and an_int: s8",
        ),
        (
            |b, i| done(b.shl(i.byte, i.int)),
            "shl: the amount is signed",
        ),
        (
            |b, i| done(b.shr(i.byte, i.int)),
            "shr: the amount is signed",
        ),
        (
            |b, i| done(b.slice(i.byte, 4, 5)),
            "slice: bits 4+5 of a_byte: u8",
        ),
        (
            |b, i| done(b.slice(i.byte, 4, 0)),
            "slice: bits 4+0 of a_byte: u8",
        ),
        (
            |b, i| done(b.slice(i.byte, u32::MAX, 2)),
            "slice: bits 4294967295+2 of a_byte: u8",
        ),
        (
            |b, i| done(b.bit(i.byte, 8)),
            "slice: bits 8+1 of a_byte: u8",
        ),
        (|b, _| done(b.cat(&[])), "cat: no parts"),
        (
            |b, i| done(b.repeat(i.byte, 0)),
            "repeat: 0 copies of a_byte: u8",
        ),
        (
            |b, i| done(b.repeat(i.byte, 8193)),
            "width 65544: expected 1 to 65536",
        ),
        (
            |b, i| done(b.repeat(i.byte, u32::MAX)),
            "expected 1 to 65536",
        ),
        (
            |b, i| done(b.extend(i.byte, 7)),
            "extend: a_byte: u8 to 7 bits is narrower: truncate, round or saturate",
        ),
        (
            |b, i| done(b.extend(i.byte, u32::MAX)),
            "expected 1 to 65536",
        ),
        (
            |b, i| done(b.extend(i.byte, 0)),
            "extend: a_byte: u8 to 0 bits",
        ),
        (
            |b, i| done(b.truncate(i.byte, 9)),
            "slice: bits 0+9 of a_byte: u8",
        ),
        (
            |b, i| done(b.truncate(i.int, 0)),
            "slice: bits 0+0 of an_int: s8",
        ),
        (
            |b, i| done(b.round(i.byte, 8, Rounding::Floor)),
            "round: 8 bits off a_byte: u8",
        ),
        (
            |b, i| done(b.saturate(i.byte, Ty::s(0))),
            "expected 1 to 65536",
        ),
        (
            |b, i| done(b.saturate(i.byte, Ty::u(u32::MAX))),
            "expected 1 to 65536",
        ),
        (
            |b, i| done(b.saturated(i.byte, Ty::s(0))),
            "expected 1 to 65536",
        ),
        (
            |b, i| done(b.mux(i.byte, i.byte, i.byte)),
            "mux: condition a_byte: u8 is not one unsigned bit",
        ),
        (
            |b, i| done(b.mux(i.bit, i.byte, i.int)),
            "mux: operands differ",
        ),
        (|b, i| done(b.select(i.byte, &[])), "select: no options"),
        (
            |b, i| done(b.select(i.int, &[i.byte, i.byte])),
            "select: the index is signed",
        ),
        (
            |b, i| done(b.select(i.byte, &[i.byte, i.word])),
            "select: operands differ",
        ),
        (
            |b, _| done(b.lit(256, Ty::u(8))),
            "a constant: 256 does not fit u8",
        ),
        (
            |b, _| done(b.lit(-1, Ty::u(8))),
            "a constant: -1 does not fit u8",
        ),
        (
            |b, _| done(b.lit(128, Ty::s(8))),
            "a constant: 128 does not fit s8",
        ),
        (
            |b, _| done(b.lit(0, Ty::u(0))),
            "width 0: expected 1 to 65536",
        ),
        (
            |b, _| done(b.lit(0, Ty::s(0))),
            "width 0: expected 1 to 65536",
        ),
        (
            |b, _| done(b.lit(0, Ty::u(u32::MAX))),
            "width 4294967295: expected 1 to 65536",
        ),
        (
            |b, _| done(b.input("none", Ty::u(0), "")),
            "width 0: expected 1 to 65536",
        ),
        (
            |b, _| done(b.reg("r", Ty::u(8), 256)),
            "r: reset value 256 does not fit u8",
        ),
        (
            |b, _| done(b.reg("r", Ty::s(0), 0)),
            "width 0: expected 1 to 65536",
        ),
        (
            |b, i| b.set_next(i.byte, i.byte),
            "a_byte: u8: not a register",
        ),
        (
            |b, i| {
                let r = b.reg("r", Ty::u(8), 0);
                b.set_next(r, i.word);
            },
            "operands differ: r: u8 and a_word: u16",
        ),
        (
            |b, i| {
                let r = b.reg("r", Ty::u(8), 0);
                b.set_next(r, i.byte);
                b.set_next_if(r, i.bit, i.byte);
            },
            "r: u8: driven twice",
        ),
        (
            |b, i| {
                let r = b.reg("r", Ty::u(8), 0);
                b.set_next_if(r, i.word, i.byte);
            },
            "set_next_if: enable a_word: u16 is not one unsigned bit",
        ),
        (
            |b, _| done(b.memory("m", 1, 8, "")),
            "memory of 1 rows of 8 bits: expected 2 rows",
        ),
        (
            |b, _| done(b.memory("m", 4, 0, "")),
            "of 0 bits: expected 2 rows at least, of 1 to 65536 bits",
        ),
        (
            |b, _| done(b.memory("m", 4, 65_537, "")),
            "4 rows of 65537 bits: expected 2 rows",
        ),
        (
            |b, i| {
                let m = b.memory("m", 4, 8, "");
                done(b.mem_read_async(m, i.byte));
            },
            "m: address a_byte: u8: expected u2",
        ),
        (
            |b, i| {
                let m = b.memory("m", 256, 8, "");
                b.mem_write(m, i.bit, i.byte, i.word);
            },
            "data a_word: u16 (expected u8)",
        ),
        (
            |b, i| {
                let m = b.memory("m", 256, 8, "");
                b.mem_write(m, i.byte, i.byte, i.byte);
            },
            "mem_write: ",
        ),
        (
            |b, i| {
                let m = b.memory("m", 256, 8, "");
                done(b.mem_read(m, i.byte, i.byte, "q"));
            },
            "enable a_byte: u8 is not one unsigned bit",
        ),
        (
            |b, i| done(b.instance("l", &leaf(), &[("z", i.byte)])),
            "l: module leaf has no input `z`",
        ),
        (
            |b, i| done(b.instance("l", &leaf(), &[("y", i.byte)])),
            "l: module leaf has no input `y`",
        ),
        (
            |b, i| done(b.instance("l", &leaf(), &[("x", i.word)])),
            "l: port `x` is u8, connected to a_word: u16",
        ),
        (
            |b, i| done(b.instance("l", &leaf(), &[("x", i.byte), ("x", i.byte)])),
            "l: port `x` is connected twice",
        ),
        (
            |b, i| {
                let l = b.instance("l", &leaf(), &[("x", i.byte)]);
                done(b.out(l, "x"));
            },
            "l: module leaf has no output `x`",
        ),
    ];
    for (n, (misuse, want)) in cases.iter().enumerate() {
        let text = errors(misuse);
        assert!(
            text.contains(want),
            "case {n}: `{text}` does not say `{want}`"
        );
    }
}

#[test]
fn checks_find_what_is_wrong_with_the_whole() {
    let cases: &[(Misuse, &str)] = &[
        (
            |b, _| {
                let r = b.reg("r", Ty::u(8), 0);
                b.output("y", r, "");
            },
            "module unit: r: register is never driven: call set_next or set_next_if",
        ),
        (
            |b, _| done(b.input("extra", Ty::u(8), "")),
            "module unit: extra: input is not read: use it, or give the reason with unused()",
        ),
        (
            |b, _| done(b.instance("l", &leaf(), &[])),
            "module unit: l: port `x` of leaf is not connected",
        ),
        (
            |b, _| {
                let l = b.instance("l", &leaf(), &[]);
                let y = b.out(l, "y");
                b.connect(l, "x", y);
            },
            "is part of a combinational loop through an instance: put a register on the way",
        ),
        (
            |b, i| b.output("a b", i.byte, ""),
            "port `a b` is no plain Verilog identifier",
        ),
        (
            |b, i| b.output("3rd", i.byte, ""),
            "port `3rd` is no plain Verilog identifier",
        ),
        (
            |b, i| b.output("", i.byte, ""),
            "port `` is no plain Verilog identifier",
        ),
        (
            |b, i| b.output("wire", i.byte, ""),
            "port `wire` is no plain Verilog identifier",
        ),
        (
            |b, i| b.output("clk", i.byte, ""),
            "port `clk` is no plain Verilog identifier",
        ),
        (
            |b, i| b.output("a_byte", i.byte, ""),
            "`a_byte` names a port and a port",
        ),
        (
            |b, i| b.output("unit", i.byte, ""),
            "`unit` names a port and a module",
        ),
        (
            |b, i| {
                let m = b.memory("m", 256, 8, "");
                let q = b.mem_read_async(m, i.byte);
                b.name(q, "m");
                b.output("q", q, "");
            },
            "`m` is given twice",
        ),
        (
            |b, i| {
                let (x, y) = (b.not(i.byte), b.not(i.int));
                b.name(x, "same");
                b.name(y, "same");
            },
            "`same` is given twice",
        ),
        (
            |b, i| {
                let feeds = [("x", Feed::Each(i.byte))];
                b.array("row", &leaf(), &[("n", 2)], &feeds);
            },
            "port `x` is u8, 2 of it are connected to a_byte: u8",
        ),
        (
            |b, i| {
                let array = b.array("row", &leaf(), &[("n", 2)], &[("x", Feed::Shared(i.byte))]);
                b.feed(array, "x", Feed::Along(&[1], i.byte));
            },
            "it has no loop 1",
        ),
        (
            |b, i| {
                b.array("row", &leaf(), &[], &[("x", Feed::Shared(i.byte))]);
            },
            "an array needs a loop",
        ),
        (
            |b, i| {
                b.as_values(i.byte, 3);
            },
            "no vector of 3 bits each",
        ),
        (
            |b, i| {
                // One that is made alike is the same.
                let (one, alike, other) = (leaf(), leaf(), leaf_of(ModuleBuilder::neg));
                b.instance("l", &one, &[("x", i.byte)]);
                b.instance("j", &alike, &[("x", i.byte)]);
                b.instance("k", &other, &[("x", i.byte)]);
            },
            "two different modules are called `leaf`",
        ),
    ];
    for (n, (misuse, want)) in cases.iter().enumerate() {
        let text = errors(misuse);
        assert!(
            text.contains(want),
            "case {n}: `{text}` does not say `{want}`"
        );
    }
}

#[test]
fn all_errors_are_reported_at_once() {
    let text = errors(|b, i| {
        b.add(i.byte, i.word);
        b.slice(i.byte, 9, 9);
    });
    assert_eq!(text.lines().count(), 2, "{text}");
}

#[test]
fn what_is_right_is_not_refused() {
    let mut b = ModuleBuilder::new("right");
    let x = b.input("x", Ty::u(8), "");
    let l = b.instance("l", &leaf(), &[("x", x)]);
    let again = b.out(l, "y");
    let same = b.out(l, "y");
    assert_eq!(again, same, "an output of an instance is one signal");
    let r = b.reg("r", Ty::u(8), 255);
    b.set_next(r, again);
    b.output("y", r, "");
    let module = b.finish().unwrap();
    assert!(module.is_clocked() && module.has_reset());
    assert_eq!(module.ports().len(), 2);
}
