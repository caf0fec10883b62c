//! Netlist interpreter: a simulator without external tools.

mod error;
mod flatten;
mod memory;
mod step;
#[cfg(test)]
mod tests;
mod watch;
mod words;

use std::sync::Arc;

use num_bigint::BigUint;

use super::node::Ty;
use super::{Module, Ranges};
use flatten::{Flat, Layout, Next};
use step::Slot;
use watch::Watch;

pub use error::InterpretError;

/// A port of an interpreted module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortHandle {
    module: usize,
    index: usize,
    width: u32,
}

impl PortHandle {
    /// Width in bits.
    #[must_use]
    pub const fn width(self) -> u32 {
        self.width
    }

    /// Width in 32-bit words.
    #[must_use]
    pub const fn words(self) -> usize {
        self.width.div_ceil(32) as usize
    }
}

#[derive(Debug, Clone)]
struct Pin {
    name: String,
    slot: Slot,
    output: bool,
}

/// Interprets a module and its hierarchy.
///
/// Values are two's complement bits. Ports are read and written as unsigned words, low word first,
/// whatever their signedness. Inputs start at 0, so that a module with registers starts in reset
/// (`rst_n` is an ordinary port here). Registers, memories and outputs of clocked reads start with
/// values drawn from the seed: a result that depends on them before a reset or a write differs
/// between seeds. A read past the depth of a memory returns 0, a write there is ignored, and of two
/// writes to one row the later declared wins.
#[derive(Debug, Clone)]
pub struct Interpreter {
    module: Arc<Module>,
    flat: Flat,
    layout: Layout,
    pins: Vec<Pin>,
    rst_n: Option<Slot>,
    /// Next values of the states.
    pending: Vec<u64>,
    cycle: u64,
    was_reset: bool,
    watch: Vec<Watch>,
}

impl Interpreter {
    /// Flattens the module.
    #[must_use]
    pub fn new(module: &Arc<Module>, seed: u64) -> Self {
        let mut flat = Flat::new(seed);
        let mut pins = vec![];
        let rst_n = module.has_reset().then(|| flat.allocate(Ty::bit()));
        flat.reset = rst_n;
        pins.extend(rst_n.map(|slot| Pin {
            name: "rst_n".to_owned(),
            slot,
            output: false,
        }));
        let inputs = module.ports.iter().filter(|p| !p.output);
        let inputs = inputs
            .map(|p| (p.node, flat.allocate(module.nodes[p.node].ty)))
            .collect();
        let layout = flat.add(module, &inputs);
        pins.extend(module.ports.iter().map(|port| Pin {
            name: port.name.clone(),
            slot: layout.slots[port.node],
            output: port.output,
        }));
        let kept = flat.states.iter().map(|s| s.slot.words()).sum();
        Self {
            module: module.clone(),
            flat,
            layout,
            pins,
            rst_n,
            pending: vec![0; kept],
            cycle: 0,
            was_reset: false,
            watch: vec![],
        }
    }

    /// Enables checks: in cycles after the first reset, every value must be in its range and every
    /// declared bound must hold. Registers start with their reset values, and with 0 where they
    /// have none, as ranges have them.
    ///
    /// # Errors
    /// [`InterpretError::ForeignRanges`].
    pub fn with_ranges(mut self, ranges: &Ranges) -> Result<Self, InterpretError> {
        self.watch = watch::all(&self.module, &self.layout, ranges)?;
        self.flat.reset_registers();
        Ok(self)
    }

    /// The port of this name; modules with registers have the port `rst_n`.
    ///
    /// # Errors
    /// [`InterpretError::NoSuchPort`].
    pub fn port(&self, name: &str) -> Result<PortHandle, InterpretError> {
        let found = self.pins.iter().position(|p| p.name == name);
        let index = found.ok_or_else(|| InterpretError::NoSuchPort {
            module: self.module.name.clone(),
            name: name.to_owned(),
            ports: self
                .pins
                .iter()
                .map(|p| p.name.as_str())
                .collect::<Vec<_>>()
                .join(", "),
        })?;
        Ok(PortHandle {
            module: self.identity(),
            index,
            width: self.pins[index].slot.ty.width,
        })
    }

    fn identity(&self) -> usize {
        Arc::as_ptr(&self.module) as usize
    }

    fn pin(&self, port: PortHandle) -> Result<&Pin, InterpretError> {
        let pin = self
            .pins
            .get(port.index)
            .filter(|_| port.module == self.identity());
        pin.ok_or(InterpretError::ForeignPort)
    }

    fn input(&self, port: PortHandle) -> Result<Slot, InterpretError> {
        let pin = self.pin(port)?;
        if pin.output {
            Err(InterpretError::NotAnInput(pin.name.clone()))
        } else {
            Ok(pin.slot)
        }
    }

    fn wrong(&self, port: PortHandle, got: String) -> InterpretError {
        InterpretError::WrongWidth {
            name: self
                .pins
                .get(port.index)
                .map_or_else(String::new, |p| p.name.clone()),
            bits: port.width,
            words: port.words(),
            got,
        }
    }

    /// Sets an input of up to 64 bits; bits above its width are dropped.
    ///
    /// # Errors
    /// [`InterpretError::WrongWidth`] above 64 bits,
    /// [`InterpretError::NotAnInput`] or [`InterpretError::ForeignPort`].
    pub fn set_u64(&mut self, port: PortHandle, value: u64) -> Result<(), InterpretError> {
        let slot = self.input(port)?;
        if port.width > 64 {
            return Err(self.wrong(port, "set as 64 bits; use set_words".to_owned()));
        }
        self.flat.values[slot.at] = value & words::mask(port.width);
        Ok(())
    }

    /// Reads a port of up to 64 bits.
    ///
    /// # Errors
    /// [`InterpretError::WrongWidth`] above 64 bits, or
    /// [`InterpretError::ForeignPort`].
    pub fn get_u64(&self, port: PortHandle) -> Result<u64, InterpretError> {
        let slot = self.pin(port)?.slot;
        if port.width > 64 {
            return Err(self.wrong(port, "read as 64 bits; use words".to_owned()));
        }
        Ok(self.flat.values[slot.at])
    }

    /// Sets an input of any width; bits above its width are dropped.
    ///
    /// # Errors
    /// [`InterpretError::WrongWidth`] unless there are [`PortHandle::words`]
    /// words, [`InterpretError::NotAnInput`] or
    /// [`InterpretError::ForeignPort`].
    pub fn set_words(&mut self, port: PortHandle, value: &[u32]) -> Result<(), InterpretError> {
        let slot = self.input(port)?;
        if value.len() != port.words() {
            return Err(self.wrong(port, format!("set with {} words", value.len())));
        }
        let out = &mut self.flat.values[slot.at..slot.at + slot.words()];
        for (o, pair) in out.iter_mut().zip(value.chunks(2)) {
            *o = pair
                .iter()
                .rev()
                .fold(0, |all, w| all << 32 | u64::from(*w));
        }
        words::trim(out, port.width);
        Ok(())
    }

    /// A port of any width, low word first.
    ///
    /// # Errors
    /// [`InterpretError::ForeignPort`].
    pub fn words(&self, port: PortHandle) -> Result<Vec<u32>, InterpretError> {
        let slot = self.pin(port)?.slot;
        let halves = slot
            .of(&self.flat.values)
            .iter()
            .flat_map(|w| [*w as u32, (w >> 32) as u32]);
        Ok(halves.take(port.words()).collect())
    }

    /// The bits of a signal with the hierarchical name `instance.instance.signal`, after the last
    /// [`eval`](Self::eval).
    #[must_use]
    pub fn peek(&self, path: &str) -> Option<BigUint> {
        let (mut module, mut layout) = (&*self.module, &self.layout);
        let mut parts: Vec<&str> = path.split('.').collect();
        let name = parts.pop()?;
        for part in parts {
            let i = module.instances.iter().position(|i| i.name == part)?;
            (module, layout) = (&*module.instances[i].module, &layout.instances[i]);
        }
        let named = module
            .nodes
            .iter()
            .position(|n| n.name.as_deref() == Some(name));
        let port = || module.ports.iter().find(|p| p.name == name).map(|p| p.node);
        let slot = layout.slots[named.or_else(port)?];
        let digits = slot
            .of(&self.flat.values)
            .iter()
            .flat_map(|w| [*w as u32, (w >> 32) as u32]);
        Some(BigUint::new(digits.collect()))
    }

    /// Clock edges so far.
    #[must_use]
    pub const fn cycle(&self) -> u64 {
        self.cycle
    }

    /// Evaluates the netlist for the current inputs.
    ///
    /// # Errors
    /// [`InterpretError::OutOfRange`], if ranges are checked.
    pub fn eval(&mut self) -> Result<(), InterpretError> {
        let Flat {
            values,
            steps,
            memories,
            ..
        } = &mut self.flat;
        for step in steps {
            step.run(values, memories);
        }
        let in_reset = self
            .rst_n
            .is_some_and(|s| self.flat.values[s.at] == 0 || !self.was_reset);
        if in_reset {
            return Ok(());
        }
        self.watch
            .iter()
            .try_for_each(|w| w.check(&self.flat.values, self.cycle))
    }

    /// Evaluates, applies the rising clock edge, and evaluates again.
    ///
    /// # Errors
    /// [`InterpretError::OutOfRange`], if ranges are checked.
    pub fn clock(&mut self) -> Result<(), InterpretError> {
        self.eval()?;
        let in_reset = self.rst_n.is_some_and(|s| self.flat.values[s.at] == 0);
        let Flat {
            values,
            states,
            writes,
            memories,
            ..
        } = &mut self.flat;
        let mut at = 0;
        for state in &*states {
            let out = &mut self.pending[at..at + state.slot.words()];
            at += out.len();
            match &state.next {
                Next::Value {
                    reset: Some(reset), ..
                } if in_reset => out.copy_from_slice(reset),
                Next::Value { from, enable, .. } if enable.is_none_or(|e| values[e.at] == 1) => {
                    out.copy_from_slice(from.of(values))
                }
                Next::Row {
                    memory,
                    enable,
                    address,
                } if values[enable.at] == 1 => {
                    memories[*memory].read(words::amount(address.of(values), u32::MAX), out);
                }
                _ => out.copy_from_slice(state.slot.of(values)),
            }
        }
        for write in &*writes {
            if values[write.enable.at] == 1 {
                let row = words::amount(write.address.of(values), u32::MAX);
                memories[write.memory].write(row, write.data.of(values));
            }
        }
        let mut at = 0;
        for state in &*states {
            let count = state.slot.words();
            values[state.slot.at..][..count].copy_from_slice(&self.pending[at..at + count]);
            at += count;
        }
        self.cycle += 1;
        self.was_reset |= in_reset;
        self.eval()
    }
}
