#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use super::*;
use crate::{Change, Fault, Header, ModuleBuilder, Ty, verilog};

/// A counter that stops at 9, with or without checks.
fn counter(checked: bool) -> Arc<Module> {
    let mut m = ModuleBuilder::new("counter");
    let up = m.input("up", Ty::bit(), "counts");
    let count = m.reg("count", Ty::u(4), 0);
    let most = m.param("MOST", 9, Ty::u(4), "");
    let below = m.lt(count, most);
    let steps = m.and(below, up);
    let one = m.lit(1, Ty::u(4));
    let next = m.add(count, one);
    m.set_next_if(count, steps, next);
    m.output("value", count, "");
    if checked {
        m.begin_checks();
        m.free("pick", 4);
        let past = m.ghost_reg("past", 4);
        m.ghost_next(past, "1", "count");
        m.ghost("moved", "count == past + 1");
        m.assume("calm", "up -> count != 15", "No count beyond the last.");
        m.assert("range", "count <= 9", "The count stays in its range.");
        m.invariant("picked", "count == pick -> pick < 10", "");
        m.assert("steps", "moved | count == past", "It counts by one.");
        m.cover("full", "count == 9", "The end is reached.");
    }
    m.finish().unwrap()
}

fn text(module: &Arc<Module>) -> String {
    verilog(module, &Header::default()).into_values().collect()
}

fn without_checks(text: &str) -> String {
    let mut kept = String::new();
    let mut depth = 0;
    for line in text.lines() {
        match line {
            "`ifdef POTAMOI_CHECKS" => depth = 1,
            _ if depth > 0 && line.starts_with("`ifdef") => depth += 1,
            "`endif" if depth > 0 => depth -= 1,
            _ if depth == 0 => kept.extend([line, "\n"]),
            _ => {}
        }
    }
    kept.replace("\n\nendmodule", "\nendmodule")
}

#[test]
fn checks_change_neither_the_text_without_them_nor_the_digest() {
    let (plain, checked) = (counter(false), counter(true));
    assert_eq!(without_checks(&text(&checked)), text(&plain));
    assert_eq!(checked.digest(), plain.digest());
}

#[test]
fn an_instance_asserts_what_a_top_module_assumes() {
    let checked = counter(true);
    assert!(text(&checked).contains("potamoi_assume check_calm"));
    let mut m = ModuleBuilder::new("top");
    let up = m.input("up", Ty::bit(), "");
    let inner = m.instance("inner", &checked, &[("up", up)]);
    let value = m.out(inner, "value");
    m.output("value", value, "");
    m.begin_checks();
    m.inside(inner, "past");
    m.assert("follows", "inner_past <= value + 9", "");
    let top = m.finish().unwrap();
    let text = text(&top);
    assert!(text.contains("potamoi_assert check_calm"), "{text}");
    assert!(
        text.contains("wire [3:0] inner_past = inner.past;"),
        "{text}"
    );
    let all: Vec<_> = top.checks().into_iter().map(|c| (c.path, c.kind)).collect();
    let expected = [
        ("follows", CheckKind::Assert),
        ("inner.calm", CheckKind::Assert),
        ("inner.range", CheckKind::Assert),
        ("inner.picked", CheckKind::Invariant),
        ("inner.steps", CheckKind::Assert),
        ("inner.full", CheckKind::Cover),
    ];
    let expected = expected.map(|(path, kind)| (path.to_owned(), kind));
    assert_eq!(all, expected);
}

#[test]
fn checks_outlive_a_fault() {
    let fault = Fault {
        module: "counter".to_owned(),
        register: "count".to_owned(),
        change: Change::Invert(3),
    };
    let faulty = text(&fault.inject(&counter(true)).unwrap());
    let right = text(&counter(true));
    let checks = |text: &str| {
        text.split("`ifdef POTAMOI_CHECKS")
            .nth(1)
            .map(str::to_owned)
    };
    assert_eq!(checks(&faulty), checks(&right));
    assert_ne!(faulty, right);
}

#[test]
fn misuse_is_named() {
    let failed = |with: &dyn Fn(&mut ModuleBuilder)| {
        let mut m = ModuleBuilder::new("m");
        let a = m.input("a", Ty::u(4), "");
        m.output("y", a, "");
        with(&mut m);
        m.finish().unwrap_err().to_string()
    };
    let error = failed(&|m| m.assert("x", "a == 1", ""));
    assert!(error.contains("call begin_checks first"), "{error}");
    let error = failed(&|m| {
        m.begin_checks();
        m.assert("x", "b == 1", "");
    });
    assert!(error.contains("no signal has this name"), "{error}");
    let error = failed(&|m| {
        m.begin_checks();
        m.assert("x", "a + 1", "");
    });
    assert!(error.contains("`a + 1` is u5: expected one bit"), "{error}");
    let error = failed(&|m| {
        m.begin_checks();
        let s = m.formula("a == 2");
        m.output("late", s, "");
    });
    assert!(error.contains("output"), "{error}");
    let error = failed(&|m| {
        m.begin_checks();
        m.assert("x", "a == 1", "");
    });
    assert!(error.contains("has no clock"), "{error}");
    let error = failed(&|m| {
        let held = m.data_reg("held", Ty::u(4));
        let a = m.named("a");
        m.set_next(held, a);
        m.output("z", held, "");
        m.begin_checks();
        let past = m.ghost_reg("past", 4);
        m.ghost_next(past, "1", "z");
        m.assert("x", "z == past", "");
    });
    assert!(error.contains("use ghost_data_reg"), "{error}");
}

/// A memory that a macro may replace, with a check of its output.
fn memory() -> Arc<Module> {
    let mut m = ModuleBuilder::new("bank");
    m.macro_hook();
    let re = m.input("re", Ty::bit(), "");
    let address = m.input("addr", Ty::u(5), "");
    let mem = m.memory("mem", 32, 8, "");
    let data = m.input("wdata", Ty::u(8), "");
    m.mem_write(mem, re, address, data);
    let word = m.mem_read(mem, re, address, "word");
    m.output("rdata", word, "");
    m.begin_checks();
    let past = m.ghost_data_reg("past", 8);
    m.ghost_next(past, "1", "rdata");
    m.same_in_all_bits("same", "rdata", "past");
    m.assert("holds", "re | same", "It holds.");
    m.finish().unwrap()
}

#[test]
fn checks_without_a_reset_begin_at_the_second_edge_and_see_ports_of_a_macro() {
    let module = memory();
    let all = text(&module);
    let checks = all.split("`ifdef POTAMOI_CHECKS").nth(1).unwrap();
    assert!(
        checks.contains("potamoi_begun check_begun (.clk(clk)"),
        "{checks}"
    );
    assert!(checks.contains("past <= rdata;"), "{checks}");
    assert!(checks.contains(".WHOLE(1)"), "{checks}");
    assert!(
        !checks.contains("word") && !checks.contains("rst_n"),
        "{checks}"
    );
}

#[test]
fn modules_without_a_reset_are_proven_alone() {
    let bank = memory();
    assert!(bank.is_proven_alone());
    let mut m = ModuleBuilder::new("m");
    let bit = m.input("re", Ty::bit(), "");
    let address = m.input("addr", Ty::u(5), "");
    let data = m.input("wdata", Ty::u(8), "");
    let low = m.instance(
        "low",
        &bank,
        &[("re", bit), ("addr", address), ("wdata", data)],
    );
    let word = m.out(low, "rdata");
    m.output("y", word, "");
    let parent = m.finish().unwrap();
    let cut = parent.data_modules();
    assert_eq!(cut, BTreeSet::from(["bank".to_owned()]));
    assert!(!parent.modules_outside(&cut).contains("bank"));
    assert!(parent.modules_outside(&BTreeSet::new()).contains("bank"));
    assert!(parent.proven_alone().contains_key("bank"));
    assert!(parent.checks().is_empty());
}
