//! A netlist as a block with ports known at run time.

use std::sync::Arc;

use num_bigint::BigUint;
use potamoi_netlist::Module;
use rust_hdl_core::ast::VerilogLiteral;
use rust_hdl_core::prelude::{
    Atom, AtomKind, Block, Logic, PinConstraint, Probe, TypeDescriptor, TypeKind, VCDValue, Verilog,
};
use rust_hdl_core::signal::get_signal_id;

use crate::{BridgeError, Engine};

/// A port for rust-hdl's passes.
#[derive(Debug, Clone)]
struct Pin {
    name: String,
    bits: u32,
    kind: AtomKind,
    id: usize,
    value: BigUint,
    changed: bool,
}

/// A block of which the widths, names and number of ports are those of a
/// netlist. In Verilog its ports are plain vectors; signedness is a matter of
/// what the netlist does with them.
///
/// A block that contains one sets and reads it in its own `update`, and states
/// the connections in its `hdl` as custom Verilog: port `a` of a field `unit`
/// is `unit$a` there.
#[derive(Debug, Clone)]
pub struct Netlist {
    engine: Engine,
    pins: Vec<Pin>,
}

impl Netlist {
    /// A netlist whose registers and memories start with values of this seed.
    ///
    /// # Errors
    /// [`BridgeError::NamedTop`].
    pub fn new(module: &Arc<Module>, seed: u64) -> Result<Self, BridgeError> {
        let mut pins = vec![];
        let mut add = |name: &str, bits, kind| {
            pins.push(Pin {
                name: name.to_owned(),
                bits,
                kind,
                id: get_signal_id(),
                value: BigUint::ZERO,
                changed: false,
            });
        };
        if module.is_clocked() {
            add("clk", 1, AtomKind::InputParameter);
        }
        if module.has_reset() {
            add("rst_n", 1, AtomKind::InputParameter);
        }
        for port in module.ports() {
            let kind = if port.output {
                AtomKind::OutputParameter
            } else {
                AtomKind::InputParameter
            };
            add(&port.name, port.ty.width, kind);
        }
        let engine = Engine::new(module, seed)?;
        Ok(Self { engine, pins })
    }

    /// Sets an input, `clk` and `rst_n` included; effective at the next update.
    ///
    /// # Errors
    /// An unknown input, or a value wider than the port.
    pub fn set(&mut self, port: &str, value: impl Into<BigUint>) -> Result<(), BridgeError> {
        let value = value.into();
        let clock = port == "clk" && self.engine.module().is_clocked();
        if clock && value.bits() > 1 {
            return Err(BridgeError::Width {
                module: self.engine.module().name().to_owned(),
                port: port.to_owned(),
                bits: 1,
                used: value.bits(),
            });
        }
        if !clock {
            self.engine.write(port, &value)?;
        }
        for pin in self.pins.iter_mut().filter(|p| p.name == port) {
            pin.changed |= pin.value != value;
            pin.value = value.clone();
        }
        Ok(())
    }

    /// Value of a port at the last update.
    ///
    /// # Errors
    /// An unknown port.
    pub fn get(&self, port: &str) -> Result<BigUint, BridgeError> {
        match self.pins.iter().find(|p| p.name == port) {
            Some(pin) => Ok(pin.value.clone()),
            None => self.engine.read(port),
        }
    }

    /// The first error of an update, if any.
    #[must_use]
    pub fn error(&self) -> Option<&BridgeError> {
        self.engine.error()
    }
}

impl Logic for Netlist {
    fn update(&mut self) {
        let clk = self.pins.first().filter(|p| p.name == "clk");
        let clk = clk.is_some_and(|p| p.value.bit(0));
        self.engine.step(clk);
    }

    fn hdl(&self) -> Verilog {
        self.engine.verilog()
    }
}

impl Block for Netlist {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        self.update();
        for pin in &mut self.pins {
            if pin.kind == AtomKind::OutputParameter {
                let Ok(value) = self.engine.read(&pin.name) else {
                    continue;
                };
                pin.changed = value != pin.value;
                pin.value = value;
            } else {
                pin.changed = false;
            }
        }
    }

    fn has_changed(&self) -> bool {
        self.pins.iter().any(|p| p.changed)
    }

    fn accept(&self, name: &str, probe: &mut dyn Probe) {
        probe.visit_start_scope(name, self);
        for pin in &self.pins {
            probe.visit_atom(&pin.name, pin);
        }
        probe.visit_end_scope(name, self);
    }
}

impl Atom for Pin {
    fn bits(&self) -> usize {
        self.bits as usize
    }

    /// Outputs are driven by the netlist, inputs through [`Netlist::set`].
    fn connected(&self) -> bool {
        true
    }

    fn changed(&self) -> bool {
        self.changed
    }

    fn kind(&self) -> AtomKind {
        self.kind
    }

    fn descriptor(&self) -> TypeDescriptor {
        TypeDescriptor {
            name: format!("Bits::<{}>", self.bits),
            kind: TypeKind::Bits(self.bits as usize),
        }
    }

    fn vcd(&self) -> VCDValue {
        let bits = (0..self.bits).rev();
        let bits = bits.filter_map(|i| match VCDValue::from(self.value.bit(u64::from(i))) {
            VCDValue::Single(bit) => Some(bit),
            _ => None,
        });
        let bits: Vec<_> = bits.collect();
        match bits[..] {
            [one] => VCDValue::Single(one),
            _ => VCDValue::Vector(bits),
        }
    }

    fn id(&self) -> usize {
        self.id
    }

    /// Printed for constants only, which a port never is.
    fn verilog(&self) -> VerilogLiteral {
        VerilogLiteral::from(0u32)
    }

    fn constraints(&self) -> Vec<PinConstraint> {
        vec![]
    }
}
