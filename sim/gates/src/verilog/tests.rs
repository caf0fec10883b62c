//! A small netlist, read and broken.
#![allow(clippy::unwrap_used)]
use super::*;

const SMALL: &str = "/* made */\nmodule top(clk, a, \\y );\n  wire _0_;\n  input clk;\n  \
    wire clk;\n  input [2:1] a;\n  wire [2:1] a;\n  output \\y ;\n  wire \\y ;\n  \
    wire \\held[1] ; // of a\n  NAND2 _1_ (\n    .A(a[1]),\n    .B(\\held[1] ),\n    .Y()\n  );\n  \
    part p ( .x({ a, 1'h1, 2'b01 }), .y(_0_) );\n  assign \\y = _0_;\nendmodule\n\
    module part(x, y);\n  input [4:0] x;\n  output y;\n  assign y = x[4];\nendmodule\n";

#[test]
fn modules_wires_and_instances_are_read() {
    let modules = read(SMALL).unwrap();
    let top = &modules["top"];
    // _0_, clk, a[1], a[2], y, held[1].
    assert_eq!(top.bits, 6);
    let names: Vec<_> = top.ports.iter().map(|p| (&*p.name, p.output)).collect();
    assert_eq!(names, [("clk", false), ("a", false), ("y", true)]);
    assert_eq!(top.ports[1].bits, [Bit::Wire(2), Bit::Wire(3)]);
    let [nand, part] = &top.instances[..] else {
        unreachable!("two instances")
    };
    assert_eq!(nand.kind, "NAND2");
    assert_eq!(nand.pins[1], ("B".to_owned(), vec![Bit::Wire(5)]));
    assert_eq!(nand.pins[2].1, []);
    let [zero, one] = [false, true].map(Bit::Constant);
    assert_eq!(part.pins[0].1, [one, zero, one, Bit::Wire(2), Bit::Wire(3)]);
    assert_eq!(top.assigned, [(Bit::Wire(4), Bit::Wire(0))]);
    assert_eq!(modules["part"].assigned, [(Bit::Wire(5), Bit::Wire(4))]);
}

#[test]
fn numbers_are_read_lowest_bit_first() {
    let [zero, one] = [false, true].map(Bit::Constant);
    assert_eq!(constant("4'h5").unwrap(), [one, zero, one, zero]);
    assert_eq!(constant("2'b10").unwrap(), [zero, one]);
    assert_eq!(constant("3'd6").unwrap(), [zero, one, one]);
    assert_eq!(constant("6'hf").unwrap(), [one, one, one, one, zero, zero]);
    for bad in ["5", "2'bx0", "0'h0", "4'o7", "4'hg", "99999999'h0"] {
        assert_eq!(constant(bad), None, "{bad}");
    }
}

#[test]
fn what_is_no_netlist_is_named_with_its_line() {
    for (from, to, expected) in [
        (
            "module top(",
            "modul top(",
            "line 2 of the netlist: expected `module`",
        ),
        (
            ".B(\\held[1] )",
            ".B(\\gone )",
            "expected a wire, found `gone`",
        ),
        ("a[1]", "a[3]", "bits that a has"),
        ("2'b01", "2'bxx", "a number of 0 and 1"),
        ("input [4:0] x", "wire [4:0] x", "a direction of port x"),
        ("assign \\y = _0_", "assign \\y = a", "as many bits"),
        ("[4:0] x", "[4:99999999] x", "a number"),
    ] {
        let text = SMALL.replace(from, to);
        assert_ne!(text, SMALL, "{from}");
        let found = read(&text).unwrap_err();
        assert!(found.contains(expected), "{found}");
    }
    let cut = &SMALL[..SMALL.len() - 11];
    assert!(
        read(cut)
            .unwrap_err()
            .contains("`endmodule`, found its end")
    );
}
