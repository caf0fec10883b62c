//! Why the units are not written as rust-hdl kernels: what a kernel simulates
//! and the Verilog that is printed for it disagree, and its `yosys_validate`
//! has nothing against it. The same expressions as a netlist agree.

use std::sync::Arc;

use potamoi_netlist::{Header, Interpreter, Module, ModuleBuilder, Ty, verilog};
use rust_hdl_core::prelude::*;

#[derive(LogicBlock, Default)]
struct Kernel {
    pub a: Signal<In, Bits<8>>,
    pub b: Signal<In, Bits<8>>,
    pub f: Signal<In, Signed<16>>,
    pub g: Signal<In, Signed<16>>,
    pub wide_sum: Signal<Out, Bits<9>>,
    pub wraps: Signal<Out, Bit>,
    pub product: Signal<Out, Signed<48>>,
    pub complement: Signal<Out, Bit>,
}

impl Logic for Kernel {
    #[hdl_gen]
    fn update(&mut self) {
        self.wide_sum.next = bit_cast::<9, 8>(self.a.val() + self.b.val());
        self.wraps.next = (self.a.val() + 1) == 0;
        self.product.next = signed_bit_cast::<48, 32>(self.f.val() * self.g.val());
        self.complement.next = !self.a.val() == (self.b.val() + 0);
    }
}

const INPUTS: [(&str, u32); 4] = [("a", 8), ("b", 8), ("f", 16), ("g", 16)];
const OUTPUTS: [(&str, u32); 4] = [
    ("wide_sum", 9),
    ("wraps", 1),
    ("product", 48),
    ("complement", 1),
];

/// Inputs, and the output that they are for.
const CASES: [([u64; 4], usize); 4] = [
    ([255, 1, 0, 0], 0),
    ([255, 0, 0, 0], 1),
    ([0, 0, 1000, 1000], 2),
    ([15, 240, 0, 0], 3),
];

fn steps() -> Vec<Vec<(&'static str, u64)>> {
    let names = INPUTS.map(|i| i.0);
    let step = |values: [u64; 4]| names.into_iter().zip(values).collect();
    CASES.iter().map(|(values, _)| step(*values)).collect()
}

#[test]
fn kernels_and_their_verilog_disagree() {
    let mut kernel = Kernel::default();
    kernel.connect_all();
    let text = generate_verilog(&kernel);
    crate::common::validate("kernel", &text).expect("rust-hdl's own check passes");
    let printed = crate::common::icarus(&text, &INPUTS, &OUTPUTS, &steps());
    let mut table = vec![];
    for (([a, b, f, g], output), printed) in CASES.into_iter().zip(&printed) {
        kernel.a.next = a.into();
        kernel.b.next = b.into();
        kernel.f.next = signed::<16>(f as i64);
        kernel.g.next = signed::<16>(g as i64);
        assert!(simulate(&mut kernel, 10));
        let simulated = [
            kernel.wide_sum.val().to_u64(),
            u64::from(kernel.wraps.val()),
            u64::try_from(kernel.product.val().bigint()).unwrap(),
            u64::from(kernel.complement.val()),
        ];
        table.push((simulated[output].to_string(), printed[output].clone()));
    }
    // Its simulator, Icarus on its Verilog.
    let expected = [("0", "256"), ("1", "0"), ("1000000", "16960"), ("1", "0")];
    assert_eq!(table, expected.map(|(s, p)| (s.to_owned(), p.to_owned())));
}

fn netlist() -> Arc<Module> {
    let mut m = ModuleBuilder::new("top");
    let [a, b] = ["a", "b"].map(|n| m.input(n, Ty::u(8), ""));
    let [f, g] = ["f", "g"].map(|n| m.input(n, Ty::s(16), ""));
    let sum = m.add(a, b);
    let sum = m.extend(sum, 9);
    let (one, zero) = (m.lit(1, Ty::u(8)), m.lit(0, Ty::u(8)));
    let next = m.add(a, one);
    let wraps = m.eq(next, zero);
    let product = m.mul(f, g);
    let product = m.extend(product, 48);
    let (not, same) = (m.not(a), m.add(b, zero));
    let complement = m.eq(not, same);
    for ((name, _), s) in OUTPUTS.into_iter().zip([sum, wraps, product, complement]) {
        m.output(name, s, "");
    }
    m.finish().unwrap()
}

#[test]
fn netlists_and_their_verilog_agree() {
    let module = netlist();
    let text = &verilog(&module, &Header::default())["top.v"];
    let printed = crate::common::icarus(text, &INPUTS, &OUTPUTS, &steps());
    let mut run = Interpreter::new(&module, 1);
    for (step, printed) in steps().iter().zip(&printed) {
        for (name, value) in step {
            run.set_u64(run.port(name).unwrap(), *value).unwrap();
        }
        run.eval().unwrap();
        let simulated =
            OUTPUTS.map(|(name, _)| run.get_u64(run.port(name).unwrap()).unwrap().to_string());
        assert_eq!(&simulated[..], &printed[..], "{step:?}");
    }
    // What the kernels simulate, the netlist also prints.
    let own: Vec<_> = CASES
        .iter()
        .zip(&printed)
        .map(|((_, o), p)| p[*o].as_str())
        .collect();
    assert_eq!(own, ["0", "1", "1000000", "1"]);
}
