//! VCD dump of the window around a cycle.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use potamoi_netlist::Module;
use vcd::{IdCode, TimescaleUnit, Value, Writer};

use super::engine::{Engine, Verilated, pass_on};
use super::model::RtlError;

/// Cycles dumped before and after the one of interest.
const BEFORE: u64 = 24;
pub(super) const AFTER: u64 = 8;
/// Clocks before cycle 0, in reset.
const RESET: u64 = 3;

/// Range of cycles to dump, and the file.
#[derive(Debug, Clone)]
pub(super) struct Window {
    pub(super) path: PathBuf,
    cycle: u64,
}

impl Window {
    pub(super) fn around(cycle: u64, path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            cycle,
        }
    }

    /// Whether a clock, counted from the first in reset, is in the window.
    fn holds(&self, clock: u64) -> bool {
        let at = self.cycle + RESET;
        (at.saturating_sub(BEFORE)..=at + AFTER).contains(&clock)
    }

    /// Time of the cycle of interest in the dump: its first half.
    pub(super) const fn time(&self) -> u64 {
        2 * (self.cycle + RESET) + 1
    }
}

/// Dumps every signal of a Verilated model.
pub(super) struct TracedModel {
    inner: Verilated,
    window: Window,
    clock: u64,
    open: bool,
}

impl TracedModel {
    pub(super) const fn new(inner: Verilated, window: Window) -> Self {
        Self {
            inner,
            window,
            clock: 0,
            open: false,
        }
    }
}

impl Engine for TracedModel {
    pass_on!(<Verilated as Engine>::Port);

    fn settle(&mut self) -> Result<(), RtlError> {
        let inside = self.window.holds(self.clock);
        if inside && !self.open {
            self.inner.model.open_vcd(&self.window.path)?;
        } else if !inside && self.open {
            self.inner.model.close_vcd()?;
        }
        self.open = inside;
        self.inner.settle()
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        self.clock += 1;
        self.inner.edge()
    }
}

/// Dumps the ports of a module on any engine.
pub(super) struct TracedPorts<E: Engine> {
    inner: E,
    window: Window,
    clock: u64,
    writer: Writer<BufWriter<File>>,
    ports: Vec<(E::Port, u32, IdCode)>,
    clk: IdCode,
}

impl<E: Engine> TracedPorts<E> {
    pub(super) fn new(inner: E, module: &Arc<Module>, window: Window) -> Result<Self, RtlError> {
        let lost = |e: std::io::Error| unwritable(&window, &e);
        let file = File::create(&window.path).map_err(lost)?;
        let mut writer = Writer::new(BufWriter::new(file));
        let mut ports = vec![];
        let begin = |writer: &mut Writer<_>, ports: &mut Vec<_>| -> std::io::Result<_> {
            writer.timescale(1, TimescaleUnit::NS)?;
            writer.add_module(module.name())?;
            let clk = writer.add_wire(1, "clk")?;
            ports.push(("rst_n".to_owned(), 1, writer.add_wire(1, "rst_n")?));
            for port in module.ports() {
                let id = writer.add_wire(port.ty.width, &port.name)?;
                ports.push((port.name, port.ty.width, id));
            }
            writer.upscope()?;
            writer.enddefinitions()?;
            Ok(clk)
        };
        let clk = begin(&mut writer, &mut ports).map_err(lost)?;
        let ports = ports
            .into_iter()
            .map(|(name, width, id)| Ok((inner.port(&name)?, width, id)))
            .collect::<Result<_, RtlError>>()?;
        Ok(Self {
            inner,
            window,
            clock: 0,
            writer,
            ports,
            clk,
        })
    }

    fn dump(&mut self) -> Result<(), RtlError> {
        let lost = |window: &Window, e: std::io::Error| unwritable(window, &e);
        // As Verilator counts: time goes on before each half of a clock.
        let time = 2 * self.clock + 1;
        let w = &mut self.writer;
        let clock = w
            .timestamp(time)
            .and_then(|()| w.change_scalar(self.clk, Value::V0));
        clock.map_err(|e| lost(&self.window, e))?;
        for &(port, width, id) in &self.ports {
            let mut words = vec![0; self.inner.words(port)];
            self.inner.get_words(port, &mut words)?;
            let unknown = self.inner.unknown(port);
            let bit = |i: u32| {
                let (word, low) = ((i / 32) as usize, i % 32);
                if unknown.is_some_and(|u| u[word] >> low & 1 == 1) {
                    Value::X
                } else if words[word] >> low & 1 == 1 {
                    Value::V1
                } else {
                    Value::V0
                }
            };
            let bits = (0..width).rev().map(bit);
            let done = if width == 1 {
                self.writer.change_scalar(id, bit(0))
            } else {
                self.writer.change_vector(id, bits)
            };
            done.map_err(|e| lost(&self.window, e))?;
        }
        let w = &mut self.writer;
        let clock = w
            .timestamp(time + 1)
            .and_then(|()| w.change_scalar(self.clk, Value::V1))
            .and_then(|()| w.flush());
        clock.map_err(|e| lost(&self.window, e))
    }
}

fn unwritable(window: &Window, error: &std::io::Error) -> RtlError {
    RtlError::Usage(format!(
        "cannot write {}: {error}; name a folder that can be written",
        window.path.display()
    ))
}

impl<E: Engine> Engine for TracedPorts<E> {
    pass_on!(E::Port);

    fn settle(&mut self) -> Result<(), RtlError> {
        self.inner.settle()?;
        if self.window.holds(self.clock) {
            self.dump()?;
        }
        Ok(())
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        self.clock += 1;
        self.inner.edge()
    }
}
