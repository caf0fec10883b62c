//! One running instance of a model.

mod access;
mod errors;
mod slot;
mod wave_dump;

use crate::{
    Direction, Error, PortId,
    library::{Library, Loaded, Sim},
};
use slot::{Slot, Store};
use std::{
    ffi::{CStr, c_char, c_int},
    sync::Arc,
};

/// The clock input that [`Model::tick`] drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock(PortId);

/// One running instance of a model.
///
/// Once the Verilog stops it (`$fatal`, `$stop`, `$finish` or a failed assertion), every call
/// returns the same [`Error::Stopped`].
#[derive(Debug)]
pub struct Model {
    sim: Sim,
    /// Empty once the model has stopped, so that one check of a handle covers that too.
    slots: Box<[Slot]>,
    id: u64,
    /// Words of all inputs and of all outputs.
    packed: [usize; 2],
    dead: Option<Box<Error>>,
    loaded: Arc<Loaded>,
}

// SAFETY: the C++ model is owned by this value alone and is reached by one thread at a time,
// since every call that evaluates or writes takes `&mut self`. The shim sets Verilator's
// thread-local context at the start of each such call, so no state stays behind on a thread.
unsafe impl Send for Model {}

impl Library {
    /// A new instance. Registers that are not reset begin with values drawn from `seed`, and
    /// all inputs are 0.
    ///
    /// Seeds that differ modulo 2^31 - 2 give different values.
    ///
    /// # Errors
    /// [`Error::Load`] when memory runs out.
    pub fn model(&self, seed: u32) -> Result<Model, Error> {
        Model::new(self.loaded.clone(), seed)
    }
}

impl Model {
    pub(crate) fn new(loaded: Arc<Loaded>, seed: u32) -> Result<Self, Error> {
        // Verilator takes seeds from 1 to 2^31 - 1, and draws one itself for 0.
        let seed = 1 + (seed % (i32::MAX as u32 - 1)) as c_int;
        // SAFETY: the function comes from the loaded shim and has no precondition.
        let sim = unsafe { (loaded.new)(seed) };
        if sim.is_null() {
            return Err(Error::Load {
                path: loaded.top.clone().into(),
                reason: "memory ran out while the model was made".into(),
            });
        }
        let mut model = Model {
            sim,
            slots: Box::default(),
            id: loaded.id,
            packed: [Direction::Input, Direction::Output].map(|dir| {
                let ports = loaded.ports.iter().filter(|p| p.dir == dir);
                ports.map(crate::Port::words).sum()
            }),
            dead: None,
            loaded,
        };
        let mut slots = Vec::with_capacity(model.loaded.ports.len());
        for (index, port) in model.loaded.ports.iter().enumerate() {
            // SAFETY: `sim` is live.
            let at = unsafe { (model.loaded.port)(model.sim, index as u32) };
            if at.is_null() || at.align_offset(Store::of(port.bits).align()) != 0 {
                return Err(Error::Load {
                    path: model.loaded.top.clone().into(),
                    reason: format!("the shim has no storage for {port}"),
                });
            }
            if port.dir == Direction::Input {
                // SAFETY: the shim asserts that the storage has this many bytes.
                unsafe { at.write_bytes(0, port.bytes()) };
            }
            slots.push(Slot::new(at, port));
        }
        model.slots = slots.into();
        Ok(model)
    }

    /// The port of this name.
    ///
    /// # Errors
    /// [`Error::NoSuchPort`].
    pub fn port(&self, name: &str) -> Result<PortId, Error> {
        self.loaded.find(name)
    }

    /// The one-bit input of this name, as a clock.
    ///
    /// # Errors
    /// [`Error::NoSuchPort`], [`Error::NotAnInput`], or [`Error::WrongWidth`] when it is wider.
    pub fn clock(&self, name: &str) -> Result<Clock, Error> {
        let port = self.loaded.find(name)?;
        if port.dir == Direction::Output {
            return Err(self.not_an_input(port.index));
        }
        if port.bits != 1 {
            return Err(self.wrong_width(port.index, "clock", "1 bit".into(), "a 1-bit input"));
        }
        Ok(Clock(port))
    }

    /// Evaluates the design for the current inputs.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    #[inline]
    pub fn eval(&mut self) -> Result<(), Error> {
        self.alive()?;
        // SAFETY: `sim` is live and exclusively borrowed.
        let cause = unsafe { (self.loaded.eval)(self.sim) };
        self.outcome(cause)
    }

    /// One clock period: the clock falls, inputs settle, and it rises. Time advances by 2, and an
    /// open waveform records both halves.
    ///
    /// # Errors
    /// [`Error::Stopped`] or [`Error::ForeignPort`].
    #[inline]
    pub fn tick(&mut self, clock: Clock) -> Result<(), Error> {
        let at = self.slot(clock.0)?.at;
        // SAFETY: `sim` is live and exclusively borrowed, and `at` is a 1-bit input of it.
        let cause = unsafe { (self.loaded.tick)(self.sim, at) };
        self.outcome(cause)
    }

    /// One clock period with all ports at once: sets every input, does what [`Model::tick`] does,
    /// and reads every output. The fastest way to drive a model whose inputs change every cycle.
    ///
    /// `inputs` holds the words of every input in the order of [`Library::ports`](crate::Library::ports),
    /// the low word of each first, the clock's own among them, whose value does not matter; `outputs` is filled in the
    /// same way. Bits above a port's width are dropped.
    ///
    /// # Errors
    /// [`Error::Packed`] for slices of other lengths, [`Error::Stopped`] or
    /// [`Error::ForeignPort`].
    #[inline]
    pub fn cycle(
        &mut self,
        clock: Clock,
        inputs: &[u32],
        outputs: &mut [u32],
    ) -> Result<(), Error> {
        let at = self.slot(clock.0)?.at;
        if [inputs.len(), outputs.len()] != self.packed {
            return Err(self.wrong_lengths(inputs.len(), outputs.len()));
        }
        // SAFETY: `sim` is live and exclusively borrowed, `at` is a 1-bit input of it, and the
        // slices have as many words as the shim's inputs and outputs.
        let cause =
            unsafe { (self.loaded.cycle)(self.sim, at, inputs.as_ptr(), outputs.as_mut_ptr()) };
        self.outcome(cause)
    }

    /// The first half of [`Model::tick`], after which combinational outputs can be read.
    ///
    /// # Errors
    /// As [`Model::tick`].
    #[inline]
    pub fn fall(&mut self, clock: Clock) -> Result<(), Error> {
        self.half(clock, 0)
    }

    /// The second half of [`Model::tick`].
    ///
    /// # Errors
    /// As [`Model::tick`].
    #[inline]
    pub fn rise(&mut self, clock: Clock) -> Result<(), Error> {
        self.half(clock, 1)
    }

    #[inline]
    fn half(&mut self, clock: Clock, level: c_int) -> Result<(), Error> {
        let at = self.slot(clock.0)?.at;
        // SAFETY: as in `tick`.
        let cause = unsafe { (self.loaded.half)(self.sim, at, level) };
        self.outcome(cause)
    }

    /// Simulation time, in half clock periods when only [`Model::tick`] moves it.
    pub fn time(&self) -> u64 {
        // SAFETY: `sim` is live.
        unsafe { (self.loaded.time)(self.sim) }
    }

    /// Text printed by the Verilog (`$display` and the like) since the last call; at most the first
    /// 64 KiB.
    pub fn take_output(&mut self) -> String {
        // SAFETY: `sim` is live, and the text is copied before it is cleared.
        unsafe {
            let text = copy((self.loaded.output)(self.sim));
            (self.loaded.clear_output)(self.sim);
            text
        }
    }

    #[inline]
    fn alive(&self) -> Result<(), Error> {
        if self.dead.is_some() {
            return Err(self.unusable());
        }
        Ok(())
    }

    /// Storage of `port`; `None` for a handle of another model.
    #[inline(always)]
    fn find(&self, port: PortId) -> Option<Slot> {
        match self.slots.get(port.index as usize) {
            Some(slot) if port.library == self.id => Some(*slot),
            _ => None,
        }
    }

    #[inline(always)]
    fn slot(&self, port: PortId) -> Result<Slot, Error> {
        match self.find(port) {
            Some(slot) => Ok(slot),
            None => Err(self.unusable()),
        }
    }

    #[inline(always)]
    fn input(&self, port: PortId) -> Result<Slot, Error> {
        match self.find(port) {
            Some(slot) if !slot.output => Ok(slot),
            Some(_) => Err(self.not_an_input(port.index)),
            None => Err(self.unusable()),
        }
    }

    #[inline]
    fn outcome(&mut self, cause: c_int) -> Result<(), Error> {
        if cause == 0 {
            return Ok(());
        }
        Err(self.died(cause))
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: `sim` was made by `new` of the same shim and is dropped once.
        unsafe { (self.loaded.delete)(self.sim) }
    }
}

/// # Safety
/// `text` is a live C string.
unsafe fn copy(text: *const c_char) -> String {
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}
