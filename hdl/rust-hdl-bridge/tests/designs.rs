//! rust-hdl designs that instantiate netlists.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Module, ModuleBuilder, Ty};
use potamoi_rust_hdl::{BridgeError, Engine, Netlist};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;
use rust_hdl_core::check_error::check_all;
use rust_hdl_core::prelude::*;
use rust_hdl_core::yosys::SynthError;

/// Sums its input while `enable` is set: an instance below, a register, and a
/// memory of the sums so far.
fn accumulator(width: u32) -> Arc<Module> {
    let mut m = ModuleBuilder::new("widen");
    let a = m.input("a", Ty::u(width), "");
    let wide = m.extend(a, width + 4);
    m.output("wide", wide, "");
    let widen = m.finish().unwrap();

    let mut m = ModuleBuilder::new("accumulate");
    let enable = m.input("enable", Ty::bit(), "adds in this cycle");
    let a = m.input("a", Ty::u(width), "term");
    let inner = m.instance("wider", &widen, &[("a", a)]);
    let wide = m.out(inner, "wide");
    let total = m.reg("total", Ty::u(width + 4), 0);
    let next = m.add(total, wide);
    m.set_next_if(total, enable, next);
    let history = m.memory("history", 4, width + 4, "the last sums");
    let at = m.truncate(total, 2);
    m.mem_write(history, enable, at, next);
    let seen = m.mem_read(history, enable, at, "seen");
    m.output("sum", total, "sum so far");
    m.output("seen_at", seen, "an earlier sum");
    m.finish().unwrap()
}

/// States the ports of an accumulator of 8 bits as signals.
#[derive(LogicBlock)]
struct Accumulate {
    pub clk: Signal<In, Clock>,
    pub rst_n: Signal<In, Bit>,
    pub enable: Signal<In, Bit>,
    pub a: Signal<In, Bits<8>>,
    pub sum: Signal<Out, Bits<12>>,
    pub seen_at: Signal<Out, Bits<12>>,
    engine: Engine,
}

impl Accumulate {
    fn new(seed: u64) -> Self {
        Self {
            clk: Default::default(),
            rst_n: Default::default(),
            enable: Default::default(),
            a: Default::default(),
            sum: Default::default(),
            seen_at: Default::default(),
            engine: Engine::new(&accumulator(8), seed).unwrap(),
        }
    }
}

impl Logic for Accumulate {
    fn update(&mut self) {
        self.engine.set_bit("rst_n", self.rst_n.val());
        self.engine.set_bit("enable", self.enable.val());
        self.engine.set("a", self.a.val());
        self.engine.step(self.clk.val().clk);
        self.sum.next = self.engine.get("sum");
        self.seen_at.next = self.engine.get("seen_at");
    }

    fn connect(&mut self) {
        self.sum.connect();
        self.seen_at.connect();
    }

    fn hdl(&self) -> Verilog {
        self.engine.verilog()
    }
}

/// A kernel with two of them in a row.
#[derive(LogicBlock)]
struct Chain {
    pub clk: Signal<In, Clock>,
    pub rst_n: Signal<In, Bit>,
    pub a: Signal<In, Bits<8>>,
    pub first_sum: Signal<Out, Bits<12>>,
    pub second_sum: Signal<Out, Bits<12>>,
    first: Accumulate,
    second: Accumulate,
}

impl Chain {
    fn new() -> Self {
        Self {
            clk: Default::default(),
            rst_n: Default::default(),
            a: Default::default(),
            first_sum: Default::default(),
            second_sum: Default::default(),
            first: Accumulate::new(1),
            second: Accumulate::new(2),
        }
    }
}

impl Logic for Chain {
    #[hdl_gen]
    fn update(&mut self) {
        self.first.clk.next = self.clk.val();
        self.first.rst_n.next = self.rst_n.val();
        self.first.enable.next = true;
        self.first.a.next = self.a.val();
        self.second.clk.next = self.clk.val();
        self.second.rst_n.next = self.rst_n.val();
        self.second.enable.next = self.first.sum.val().get_bit(0);
        self.second.a.next = self.first.sum.val().get_bits::<8>(0);
        self.first_sum.next = self.first.sum.val();
        self.second_sum.next = self.second.sum.val();
    }
}

/// What the chain shows while the clock is low: sums of 12 bits.
fn chain_by_hand(terms: &[u64]) -> Vec<[u64; 2]> {
    let (mut first, mut second) = (0, 0);
    let step = terms.iter().map(|a| {
        let shown = [first, second];
        if first & 1 == 1 {
            second = (second + (first & 0xff)) & 0xfff;
        }
        first = (first + a) & 0xfff;
        shown
    });
    step.collect()
}

#[test]
fn a_kernel_instantiates_netlists_and_its_verilog_does_the_same() {
    let terms: Vec<u64> = (0..60u64).map(|i| (i * 151 + 3) % 256).collect();
    let mut chain = Chain::new();
    chain.connect_all();
    check_all(&chain).expect("rust-hdl's checks");
    let settle = |chain: &mut Chain, clk: bool| {
        chain.clk.next = Clock { clk };
        assert!(simulate(chain, 20), "the simulation settles");
    };
    chain.rst_n.next = false;
    settle(&mut chain, false);
    settle(&mut chain, true);
    chain.rst_n.next = true;
    let mut simulated = vec![];
    for term in &terms {
        chain.a.next = (*term).into();
        settle(&mut chain, false);
        simulated.push([
            chain.first_sum.val().to_u64(),
            chain.second_sum.val().to_u64(),
        ]);
        settle(&mut chain, true);
    }
    assert_eq!(chain.first.engine.error(), None);
    let expected = chain_by_hand(&terms);
    assert_eq!(simulated, expected);

    let text = generate_verilog(&chain);
    crate::common::validate("chain", &text).expect("yosys_validate");
    let mut steps = vec![vec![("clk", 0), ("rst_n", 0), ("a", 0)], vec![("clk", 1)]];
    for term in &terms {
        steps.push(vec![("clk", 0), ("rst_n", 1), ("a", *term)]);
        steps.push(vec![("clk", 1)]);
    }
    let inputs = [("clk", 1), ("rst_n", 1), ("a", 8)];
    let shown = crate::common::icarus(
        &text,
        &inputs,
        &[("first_sum", 12), ("second_sum", 12)],
        &steps,
    );
    let shown: Vec<_> = shown.into_iter().skip(2).step_by(2).collect();
    let expected: Vec<_> = expected
        .iter()
        .map(|row| row.map(|v| v.to_string()).to_vec())
        .collect();
    assert_eq!(shown, expected);
}

/// A block around a netlist whose width comes at run time.
#[derive(LogicBlock)]
struct Around {
    pub clk: Signal<In, Clock>,
    pub rst_n: Signal<In, Bit>,
    pub a: Signal<In, Bits<8>>,
    pub sum: Signal<Out, Bits<12>>,
    unit: Netlist,
}

impl Logic for Around {
    fn update(&mut self) {
        let inputs = [
            ("clk", u64::from(self.clk.val().clk)),
            ("rst_n", u64::from(self.rst_n.val())),
            ("enable", 1),
            ("a", self.a.val().to_u64()),
        ];
        for (port, value) in inputs {
            self.unit.set(port, value).unwrap();
        }
        self.sum.next = self.unit.get("sum").unwrap().into();
    }

    fn connect(&mut self) {
        self.sum.connect();
    }

    fn hdl(&self) -> Verilog {
        let text = "always @(*) begin
  unit$clk = clk;
  unit$rst_n = rst_n;
  unit$enable = 1'b1;
  unit$a = a;
  sum = unit$sum;
end";
        Verilog::Custom(text.to_owned())
    }
}

#[test]
fn a_block_holds_a_netlist_of_a_width_of_run_time() {
    let mut around = Around {
        clk: Default::default(),
        rst_n: Default::default(),
        a: Default::default(),
        sum: Default::default(),
        unit: Netlist::new(&accumulator(8), 3).unwrap(),
    };
    around.connect_all();
    check_all(&around).expect("rust-hdl's checks");
    let (mut shown, mut steps) = (vec![], vec![]);
    for (cycle, term) in [9u64, 200, 255, 255, 1, 77].into_iter().enumerate() {
        for clk in [false, true] {
            around.clk.next = Clock { clk };
            around.rst_n.next = cycle > 0;
            around.a.next = term.into();
            assert!(simulate(&mut around, 20));
            shown.push(vec![around.sum.val().to_u64().to_string()]);
            steps.push(vec![
                ("clk", u64::from(clk)),
                ("rst_n", u64::from(cycle > 0)),
                ("a", term),
            ]);
        }
    }
    assert_eq!(around.unit.error(), None);
    let last: Vec<_> = shown
        .iter()
        .skip(1)
        .step_by(2)
        .map(|s| s[0].as_str())
        .collect();
    assert_eq!(last, ["0", "200", "455", "710", "711", "788"]);
    let text = generate_verilog(&around);
    crate::common::validate("around", &text).expect("yosys_validate");
    let inputs = [("clk", 1), ("rst_n", 1), ("a", 8)];
    let printed = crate::common::icarus(&text, &inputs, &[("sum", 12)], &steps);
    assert_eq!(printed[1..], shown[1..]);
}

#[test]
fn yosys_validate_accepts_netlists_of_any_width() {
    for width in [1, 8, 16, 65, 512] {
        let block = Netlist::new(&accumulator(width), 1).unwrap();
        check_all(&block).expect("rust-hdl's checks");
        crate::common::validate(&format!("width_{width}"), &generate_verilog(&block))
            .expect("yosys_validate");
    }
}

#[test]
fn yosys_validate_accepts_the_generated_units() {
    let config = Config::paper();
    for module in [
        gathering_unit(&config).unwrap(),
        vector_unit(&config).unwrap(),
    ] {
        let block = Netlist::new(&module, 1).unwrap();
        check_all(&block).expect("rust-hdl's checks");
        let text = generate_verilog(&block);
        crate::common::validate(module.name(), &text).expect("yosys_validate");
    }
}

/// Two netlists side by side, not connected.
#[derive(LogicBlock)]
struct Pair {
    one: Netlist,
    other: Netlist,
}

impl Logic for Pair {
    fn update(&mut self) {}

    fn hdl(&self) -> Verilog {
        Verilog::Custom(String::new())
    }
}

fn pair(widths: [u32; 2]) -> String {
    let [one, other] = widths.map(|w| Netlist::new(&accumulator(w), 1).unwrap());
    generate_verilog(&Pair { one, other })
}

#[test]
fn one_netlist_twice_is_defined_once_and_two_of_one_name_are_an_error() {
    crate::common::validate("twice", &pair([8, 8])).expect("yosys_validate");
    match crate::common::validate("one_name", &pair([8, 16])) {
        Err(SynthError::SynthesisFailed { stderr, .. }) => {
            assert!(stderr.contains("Re-definition of module"), "{stderr}");
        }
        other => panic!("expected a failure, found {other:?}"),
    }
}

#[test]
fn wrong_uses_are_refused() {
    let mut block = Netlist::new(&accumulator(8), 1).unwrap();
    let said = |r: Result<(), BridgeError>| r.unwrap_err().to_string();
    assert!(said(block.set("b", 1u32)).contains("no port `b`"));
    assert!(said(block.set("sum", 1u32)).contains("`sum` is an output"));
    assert_eq!(
        said(block.set("a", 256u32)),
        "port `a` of accumulate has 8 bits, and was used with 9: use a value of 8 bits"
    );
    assert!(said(block.set("clk", 2u32)).contains("has 1 bits"));
    assert!(said(block.get("nothing").map(|_| ())).contains("no port `nothing`"));

    // The first of an engine's errors stays.
    let mut engine = Engine::new(&accumulator(8), 1).unwrap();
    assert_eq!(engine.error(), None);
    engine.set::<9>("a", 1.into());
    engine.set_bit("nothing", true);
    engine.step(true);
    assert_eq!(engine.get::<12>("sum"), 0u64);
    let error = engine.error().unwrap().to_string();
    assert!(
        error.contains("port `a` of accumulate has 8 bits"),
        "{error}"
    );

    let mut m = ModuleBuilder::new("top");
    let a = m.input("a", Ty::bit(), "");
    m.output("b", a, "");
    let top = m.finish().unwrap();
    assert_eq!(Netlist::new(&top, 1).unwrap_err(), BridgeError::NamedTop);
}
