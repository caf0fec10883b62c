//! Engines that run a unit: Verilated model, netlist interpreter or Icarus Verilog.

use potamoi_netlist::{Interpreter, PortHandle};
use potamoi_verilated::{Clock, Library, Model, PortId};

use super::icarus::{Icarus, Pin};
use super::model::RtlError;

/// A simulator of one module with `clk` and `rst_n`.
///
/// A cycle is a call of [`Engine::settle`], after which outputs follow the inputs, and of
/// [`Engine::edge`].
pub(super) trait Engine {
    /// Handle of a port.
    type Port: Copy;

    fn port(&self, name: &str) -> Result<Self::Port, RtlError>;
    /// 32-bit words of a port.
    fn words(&self, port: Self::Port) -> usize;
    /// Sets an input of up to 64 bits.
    fn set(&mut self, port: Self::Port, value: u64) -> Result<(), RtlError>;
    /// Reads a port of up to 64 bits.
    fn get(&self, port: Self::Port) -> Result<u64, RtlError>;
    /// Sets an input, low word first.
    fn set_words(&mut self, port: Self::Port, value: &[u32]) -> Result<(), RtlError>;
    /// Reads a port, low word first.
    fn get_words(&self, port: Self::Port, value: &mut [u32]) -> Result<(), RtlError>;
    /// Bits of a port that are neither 0 nor 1, in engines that have them.
    fn unknown(&self, _: Self::Port) -> Option<&[u32]> {
        None
    }
    /// Called once before the first beat of a job's work, for engines that measure it.
    fn work_begins(&mut self) {}
    fn settle(&mut self) -> Result<(), RtlError>;
    fn edge(&mut self) -> Result<(), RtlError>;

    /// Three clocks with `rst_n` low, then releases it.
    fn reset(&mut self) -> Result<(), RtlError> {
        let reset = self.port("rst_n")?;
        self.set(reset, 0)?;
        for _ in 0..3 {
            self.settle()?;
            self.edge()?;
        }
        self.set(reset, 1)
    }
}

/// Forwards port accesses to the inner engine.
macro_rules! pass_on {
    ($port:ty) => {
        type Port = $port;

        fn port(&self, name: &str) -> Result<Self::Port, RtlError> {
            self.inner.port(name)
        }

        fn words(&self, port: Self::Port) -> usize {
            self.inner.words(port)
        }

        fn set(&mut self, port: Self::Port, value: u64) -> Result<(), RtlError> {
            self.inner.set(port, value)
        }

        fn get(&self, port: Self::Port) -> Result<u64, RtlError> {
            self.inner.get(port)
        }

        fn set_words(&mut self, port: Self::Port, value: &[u32]) -> Result<(), RtlError> {
            self.inner.set_words(port, value)
        }

        fn get_words(&self, port: Self::Port, value: &mut [u32]) -> Result<(), RtlError> {
            self.inner.get_words(port, value)
        }

        fn unknown(&self, port: Self::Port) -> Option<&[u32]> {
            self.inner.unknown(port)
        }
    };
}

pub(super) use pass_on;

/// A Verilated model and its clock.
pub(super) struct Verilated {
    pub(super) model: Model,
    clock: Clock,
}

impl Verilated {
    pub(super) fn new(library: &Library, seed: u64) -> Result<Self, RtlError> {
        let model = library.model(seed as u32)?;
        let clock = model.clock("clk")?;
        Ok(Self { model, clock })
    }
}

impl Engine for Verilated {
    type Port = PortId;

    fn port(&self, name: &str) -> Result<PortId, RtlError> {
        Ok(self.model.port(name)?)
    }

    fn words(&self, port: PortId) -> usize {
        port.words()
    }

    #[inline]
    fn set(&mut self, port: PortId, value: u64) -> Result<(), RtlError> {
        Ok(self.model.set_u64(port, value)?)
    }

    #[inline]
    fn get(&self, port: PortId) -> Result<u64, RtlError> {
        Ok(self.model.get_u64(port)?)
    }

    #[inline]
    fn set_words(&mut self, port: PortId, value: &[u32]) -> Result<(), RtlError> {
        Ok(self.model.set_words(port, value)?)
    }

    #[inline]
    fn get_words(&self, port: PortId, value: &mut [u32]) -> Result<(), RtlError> {
        Ok(self.model.get_words(port, value)?)
    }

    #[inline]
    fn settle(&mut self) -> Result<(), RtlError> {
        Ok(self.model.fall(self.clock)?)
    }

    #[inline]
    fn edge(&mut self) -> Result<(), RtlError> {
        Ok(self.model.rise(self.clock)?)
    }
}

impl Engine for Interpreter {
    type Port = PortHandle;

    fn port(&self, name: &str) -> Result<PortHandle, RtlError> {
        Ok(Interpreter::port(self, name)?)
    }

    fn words(&self, port: PortHandle) -> usize {
        port.words()
    }

    fn set(&mut self, port: PortHandle, value: u64) -> Result<(), RtlError> {
        Ok(self.set_u64(port, value)?)
    }

    fn get(&self, port: PortHandle) -> Result<u64, RtlError> {
        Ok(self.get_u64(port)?)
    }

    fn set_words(&mut self, port: PortHandle, value: &[u32]) -> Result<(), RtlError> {
        Ok(Interpreter::set_words(self, port, value)?)
    }

    fn get_words(&self, port: PortHandle, value: &mut [u32]) -> Result<(), RtlError> {
        value.copy_from_slice(&Interpreter::words(self, port)?);
        Ok(())
    }

    fn settle(&mut self) -> Result<(), RtlError> {
        Ok(self.eval()?)
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        Ok(self.clock()?)
    }
}

/// Engine that runs the units.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum EngineKind {
    /// Verilator: the emitted Verilog as compiled C++.
    Verilator,
    /// The netlist's own interpreter: no tool, no Verilog.
    Interpreter,
    /// Icarus Verilog: the emitted Verilog, event-driven.
    Icarus,
}

impl std::fmt::Display for EngineKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Verilator => "verilator",
            Self::Interpreter => "interpreter",
            Self::Icarus => "icarus",
        })
    }
}

impl Engine for Icarus {
    type Port = Pin;

    fn port(&self, name: &str) -> Result<Pin, RtlError> {
        self.pin(name)
    }

    fn words(&self, port: Pin) -> usize {
        port.words()
    }

    fn set(&mut self, port: Pin, value: u64) -> Result<(), RtlError> {
        self.write(port, &[value as u32, (value >> 32) as u32])
    }

    fn get(&self, port: Pin) -> Result<u64, RtlError> {
        self.read_known(port)
    }

    fn set_words(&mut self, port: Pin, value: &[u32]) -> Result<(), RtlError> {
        self.write(port, value)
    }

    fn get_words(&self, port: Pin, value: &mut [u32]) -> Result<(), RtlError> {
        self.read(port, value)
    }

    fn unknown(&self, port: Pin) -> Option<&[u32]> {
        Icarus::unknown(self, port)
    }

    fn settle(&mut self) -> Result<(), RtlError> {
        self.exchange()
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        Ok(())
    }
}

/// A job for any running engine.
pub(super) trait Job {
    type Output;

    fn run<E: Engine>(self, engine: &mut E) -> Result<Self::Output, RtlError>;
}
