//! A netlist in a block that declares its ports as signals.

use std::sync::Arc;

use num_bigint::BigUint;
use potamoi_netlist::{Interpreter, Module};
use rust_hdl_core::prelude::{Bits, Block, Logic, Probe, Verilog};

use crate::BridgeError;
use crate::text;

/// Simulates and prints a netlist for the block that contains it.
///
/// rust-hdl's blocks cannot return errors during simulation. The first error is kept, see
/// [`Engine::error`], and stops the simulation.
#[derive(Debug, Clone)]
pub struct Engine {
    module: Arc<Module>,
    files: Vec<(String, String)>,
    sim: Interpreter,
    clk: bool,
    error: Option<BridgeError>,
}

impl Engine {
    /// A netlist whose registers and memories start with values of this seed.
    ///
    /// # Errors
    /// [`BridgeError::NamedTop`].
    pub fn new(module: &Arc<Module>, seed: u64) -> Result<Self, BridgeError> {
        Ok(Self {
            module: module.clone(),
            files: text::files(module)?,
            sim: Interpreter::new(module, seed),
            clk: false,
            error: None,
        })
    }

    /// The netlist.
    #[must_use]
    pub fn module(&self) -> &Arc<Module> {
        &self.module
    }

    /// The first error, if any.
    #[must_use]
    pub fn error(&self) -> Option<&BridgeError> {
        self.error.as_ref()
    }

    /// Sets an input of `N` bits; `rst_n` is one where there are registers.
    pub fn set<const N: usize>(&mut self, port: &str, value: Bits<N>) {
        self.keep(|e| {
            e.fits(port, N as u64)?;
            e.write(port, &value.into())
        });
    }

    /// Sets an input of one bit.
    pub fn set_bit(&mut self, port: &str, value: bool) {
        self.set::<1>(port, value.into());
    }

    /// Value of a port of `N` bits at the last [`Engine::step`]; 0 after an error.
    pub fn get<const N: usize>(&mut self, port: &str) -> Bits<N> {
        let mut value = BigUint::ZERO;
        self.keep(|e| {
            e.fits(port, N as u64)?;
            value = e.read(port)?;
            Ok(())
        });
        value.into()
    }

    /// Value of a port of one bit.
    pub fn get_bit(&mut self, port: &str) -> bool {
        self.get::<1>(port).into()
    }

    /// Evaluates the outputs, after a clock edge if `clk` has risen since the last step. The edge
    /// samples the inputs of the previous step.
    pub fn step(&mut self, clk: bool) {
        let rose = clk && !self.clk;
        self.clk = clk;
        self.keep(|e| {
            if rose {
                e.sim.clock()?;
            } else {
                e.sim.eval()?;
            }
            Ok(())
        });
    }

    /// Result for the block's [`Logic::hdl`]. The block's signals must have the names of the
    /// netlist's ports, including `clk` and `rst_n` where present.
    #[must_use]
    pub fn verilog(&self) -> Verilog {
        text::wrapper(&self.module, &self.files)
    }

    fn keep(&mut self, action: impl FnOnce(&mut Self) -> Result<(), BridgeError>) {
        if self.error.is_none() {
            self.error = action(self).err();
        }
    }

    fn fits(&self, port: &str, used: u64) -> Result<(), BridgeError> {
        let bits = self.sim.port(port)?.width();
        if u64::from(bits) == used {
            return Ok(());
        }
        Err(BridgeError::Width {
            module: self.module.name().to_owned(),
            port: port.to_owned(),
            bits,
            used,
        })
    }

    /// Sets an input; the value must fit the port.
    pub(crate) fn write(&mut self, port: &str, value: &BigUint) -> Result<(), BridgeError> {
        let handle = self.sim.port(port)?;
        if value.bits() > u64::from(handle.width()) {
            return self.fits(port, value.bits());
        }
        let mut words = value.to_u32_digits();
        words.resize(handle.words(), 0);
        Ok(self.sim.set_words(handle, &words)?)
    }

    pub(crate) fn read(&self, port: &str) -> Result<BigUint, BridgeError> {
        let handle = self.sim.port(port)?;
        Ok(BigUint::new(self.sim.words(handle)?))
    }
}

impl Logic for Engine {
    fn update(&mut self) {}
}

/// Not visible to rust-hdl's passes: the block that holds the engine is.
impl Block for Engine {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {}

    fn has_changed(&self) -> bool {
        false
    }

    fn accept(&self, _name: &str, _probe: &mut dyn Probe) {}
}
