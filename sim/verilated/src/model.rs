//! One running instance of a model.

use crate::{
    Direction, Error, Port, PortId, Stop,
    library::{Loaded, Sim},
};
use std::{
    ffi::{CStr, CString, c_char, c_int},
    path::Path,
    sync::Arc,
};

/// The storage of one port inside the C++ model.
#[derive(Debug, Clone, Copy)]
struct Slot {
    at: *mut u8,
    /// The bits of the value, or of its last word above 64 bits.
    mask: u64,
    words: u32,
    store: Store,
    output: bool,
}

/// What Verilator keeps a port in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Store {
    U8,
    U16,
    U32,
    U64,
    Words,
}

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
    /// Empty once the model is dead, so that one check of a handle finds that out too.
    slots: Box<[Slot]>,
    id: u64,
    /// Words of all inputs, and of all outputs.
    packed: [usize; 2],
    dead: Option<Box<Error>>,
    loaded: Arc<Loaded>,
}

// SAFETY: the C++ model is owned by this value alone and is reached by one thread at a time,
// since every call that evaluates or writes takes `&mut self`. The shim sets Verilator's
// thread-local context at the start of each such call, so no state stays behind on a thread.
unsafe impl Send for Model {}

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

    /// Sets an input of up to 64 bits; bits above its width are dropped.
    ///
    /// # Errors
    /// [`Error::WrongWidth`] above 64 bits, [`Error::NotAnInput`], [`Error::ForeignPort`] or
    /// [`Error::Stopped`].
    #[inline]
    pub fn set_u64(&mut self, port: PortId, value: u64) -> Result<(), Error> {
        let slot = self.input(port)?;
        if slot.store == Store::Words {
            return Err(self.too_wide(port, "set_u64", "set_words"));
        }
        // SAFETY: an input of up to 64 bits, live and exclusively borrowed.
        unsafe { slot.store(value) };
        Ok(())
    }

    /// Reads a port of up to 64 bits.
    ///
    /// # Errors
    /// [`Error::WrongWidth`] above 64 bits, [`Error::ForeignPort`] or [`Error::Stopped`].
    #[inline]
    pub fn get_u64(&self, port: PortId) -> Result<u64, Error> {
        let slot = self.slot(port)?;
        if slot.store == Store::Words {
            return Err(self.too_wide(port, "get_u64", "words, get_words or wide"));
        }
        // SAFETY: a port of up to 64 bits, live and not written while `self` is borrowed.
        Ok(unsafe { slot.load() })
    }

    /// Sets an input of any width from 32-bit words, the low word first; bits above its width
    /// are dropped.
    ///
    /// # Errors
    /// [`Error::WrongWidth`] unless there are `port.words()` words, [`Error::NotAnInput`],
    /// [`Error::ForeignPort`] or [`Error::Stopped`].
    #[inline]
    pub fn set_words(&mut self, port: PortId, value: &[u32]) -> Result<(), Error> {
        let slot = self.input(port)?;
        if value.len() != slot.words as usize {
            return Err(self.wrong_count(port, "set_words", value.len()));
        }
        match *value {
            // SAFETY: an input of up to 64 bits, as the number of words shows, live and
            // exclusively borrowed.
            [low] => unsafe { slot.store(u64::from(low)) },
            // SAFETY: as above.
            [low, high] => unsafe { slot.store(u64::from(low) | u64::from(high) << 32) },
            _ => {
                let at = slot.at.cast::<u32>();
                // SAFETY: storage above 64 bits is an aligned array of that many words, and
                // `self` is exclusively borrowed.
                let words = unsafe { std::slice::from_raw_parts_mut(at, value.len()) };
                copy_words(words, value);
                if let Some(last) = words.last_mut() {
                    *last &= slot.mask as u32;
                }
            }
        }
        Ok(())
    }

    /// Copies a port of any width into 32-bit words, the low word first.
    ///
    /// # Errors
    /// [`Error::WrongWidth`] unless there are `port.words()` words, [`Error::ForeignPort`] or
    /// [`Error::Stopped`].
    #[inline]
    pub fn get_words(&self, port: PortId, value: &mut [u32]) -> Result<(), Error> {
        let slot = self.slot(port)?;
        if value.len() != slot.words as usize {
            return Err(self.wrong_count(port, "get_words", value.len()));
        }
        if slot.store == Store::Words {
            // SAFETY: as in `wide`.
            copy_words(value, unsafe { slot.array() });
        } else {
            // SAFETY: as in `get_u64`.
            let bits = unsafe { slot.load() };
            for (i, word) in value.iter_mut().enumerate() {
                *word = (bits >> (32 * i)) as u32;
            }
        }
        Ok(())
    }

    /// A port of any width as 32-bit words, the low word first.
    ///
    /// # Errors
    /// [`Error::ForeignPort`] or [`Error::Stopped`].
    pub fn words(&self, port: PortId) -> Result<Vec<u32>, Error> {
        let mut value = vec![0; self.slot(port)?.words as usize];
        self.get_words(port, &mut value)?;
        Ok(value)
    }

    /// The words of a port wider than 64 bits where the model keeps them, the low word first.
    ///
    /// # Errors
    /// [`Error::WrongWidth`] up to 64 bits, [`Error::ForeignPort`] or [`Error::Stopped`].
    #[inline]
    pub fn wide(&self, port: PortId) -> Result<&[u32], Error> {
        let slot = self.slot(port)?;
        if slot.store != Store::Words {
            let expected = "more than 64 bits".to_string();
            return Err(self.wrong_width(port.index, "wide", expected, "get_u64"));
        }
        // SAFETY: storage above 64 bits is an aligned array of `words` words, which nothing
        // writes while `self` is borrowed.
        Ok(unsafe { slot.array() })
    }

    /// Computes all that follows from the inputs as they are.
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

    /// One clock period: the clock falls, the inputs settle, and it rises. Time goes on by 2,
    /// and an open trace records both halves.
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

    #[cold]
    #[inline(never)]
    fn wrong_lengths(&self, inputs: usize, outputs: usize) -> Error {
        Error::Packed {
            top: self.loaded.top.clone(),
            inputs,
            outputs,
            expected: self.packed,
        }
    }

    /// The first half of [`Model::tick`], after which outputs that depend on inputs within the
    /// cycle can be read.
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

    /// What the Verilog printed (`$display` and the like) since the last call, of which the
    /// first 64 KiB are kept.
    pub fn take_output(&mut self) -> String {
        // SAFETY: `sim` is live, and the text is copied before it is cleared.
        unsafe {
            let text = copy((self.loaded.output)(self.sim));
            (self.loaded.clear_output)(self.sim);
            text
        }
    }

    /// Begins a value change dump at `path`; one that is open is closed first.
    ///
    /// # Errors
    /// [`Error::NoTrace`], [`Error::Trace`] when the file cannot be written, or
    /// [`Error::Stopped`].
    pub fn open_vcd(&mut self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.traced()?;
        let path = path.as_ref();
        let fail = || Error::Trace(format!("cannot write {}", path.display()));
        let text = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| fail())?;
        // SAFETY: `sim` is live and exclusively borrowed, and the text outlives the call.
        match unsafe { (self.loaded.vcd_open)(self.sim, text.as_ptr()) } {
            -1 => Err(fail()),
            cause => self.outcome(cause),
        }
    }

    /// Records all values at `time`, which becomes the simulation time.
    ///
    /// # Errors
    /// [`Error::NoTrace`], [`Error::Trace`] when no file is open or time does not go on, or
    /// [`Error::Stopped`].
    pub fn dump(&mut self, time: u64) -> Result<(), Error> {
        self.traced()?;
        // SAFETY: `sim` is live and exclusively borrowed.
        match unsafe { (self.loaded.vcd_dump)(self.sim, time) } {
            -1 => Err(Error::Trace(format!(
                "cannot record time {time}: either no file is open, or that time is not after \
                 the one recorded last"
            ))),
            cause => self.outcome(cause),
        }
    }

    /// Ends the value change dump.
    ///
    /// # Errors
    /// [`Error::NoTrace`], [`Error::Trace`] when no file is open, or [`Error::Stopped`]; a
    /// stopped model's file is ended when the model is dropped.
    pub fn close_vcd(&mut self) -> Result<(), Error> {
        self.traced()?;
        // SAFETY: `sim` is live and exclusively borrowed.
        match unsafe { (self.loaded.vcd_close)(self.sim) } {
            -1 => Err(Error::Trace("no file is open".into())),
            cause => self.outcome(cause),
        }
    }

    fn traced(&self) -> Result<(), Error> {
        self.alive()?;
        if self.loaded.traced {
            return Ok(());
        }
        Err(Error::NoTrace {
            top: self.loaded.top.clone(),
        })
    }

    #[inline]
    fn alive(&self) -> Result<(), Error> {
        if self.dead.is_some() {
            return Err(self.unusable());
        }
        Ok(())
    }

    /// The storage of `port`, or nothing for a handle that this model does not know.
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

    /// Why a handle or a call is of no use.
    #[cold]
    #[inline(never)]
    fn unusable(&self) -> Error {
        match &self.dead {
            Some(error) => error.as_ref().clone(),
            None => Error::ForeignPort,
        }
    }

    #[inline]
    fn outcome(&mut self, cause: c_int) -> Result<(), Error> {
        if cause == 0 {
            return Ok(());
        }
        Err(self.died(cause))
    }

    #[cold]
    #[inline(never)]
    fn died(&mut self, cause: c_int) -> Error {
        // SAFETY: `sim` is live, and the text is copied.
        let reason = unsafe { copy((self.loaded.error)(self.sim)) };
        let printed = self.take_output();
        let text = if printed.trim().is_empty() {
            reason
        } else {
            format!("{reason}; it printed: {}", printed.trim())
        };
        let error = Error::Stopped {
            top: self.loaded.top.clone(),
            time: self.time(),
            cause: match cause {
                1 => Stop::Finish,
                2 => Stop::Stop,
                3 => Stop::Fatal,
                _ => Stop::Exception,
            },
            text,
        };
        self.dead = Some(Box::new(error.clone()));
        self.slots = Box::default();
        error
    }

    fn name(&self, index: u32) -> String {
        let port = self.loaded.ports.get(index as usize);
        port.map(|p| p.name.clone()).unwrap_or_default()
    }

    #[cold]
    #[inline(never)]
    fn not_an_input(&self, index: u32) -> Error {
        Error::NotAnInput {
            port: self.name(index),
        }
    }

    #[cold]
    #[inline(never)]
    fn wrong_width(
        &self,
        index: u32,
        call: &'static str,
        expected: String,
        instead: &'static str,
    ) -> Error {
        Error::WrongWidth {
            port: self.name(index),
            bits: self.loaded.ports.get(index as usize).map_or(0, |p| p.bits),
            call,
            expected,
            instead,
        }
    }

    #[cold]
    #[inline(never)]
    fn too_wide(&self, port: PortId, call: &'static str, instead: &'static str) -> Error {
        self.wrong_width(port.index, call, "up to 64 bits".into(), instead)
    }

    #[cold]
    #[inline(never)]
    fn wrong_count(&self, port: PortId, call: &'static str, count: usize) -> Error {
        let expected = format!("{} words for it, not {count}", port.words());
        self.wrong_width(port.index, call, expected, "PortId::words for the number")
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: `sim` was made by `new` of the same shim and is dropped once.
        unsafe { (self.loaded.delete)(self.sim) }
    }
}

impl Store {
    fn of(bits: u32) -> Self {
        match bits {
            0..=8 => Store::U8,
            9..=16 => Store::U16,
            17..=32 => Store::U32,
            33..=64 => Store::U64,
            _ => Store::Words,
        }
    }

    fn align(self) -> usize {
        match self {
            Store::U8 => 1,
            Store::U16 => 2,
            Store::U32 | Store::Words => 4,
            Store::U64 => 8,
        }
    }
}

impl Slot {
    fn new(at: *mut u8, port: &Port) -> Self {
        let last = match port.bits {
            0..=64 => port.bits,
            wide => (wide - 1) % 32 + 1,
        };
        Slot {
            at,
            mask: u64::MAX >> (64 - last.max(1)),
            words: port.words() as u32,
            store: Store::of(port.bits),
            output: port.dir == Direction::Output,
        }
    }

    /// # Safety
    /// The port has at most 64 bits, its model is live, and nothing else reaches it.
    #[inline]
    unsafe fn store(self, value: u64) {
        let value = value & self.mask;
        // SAFETY: the caller's promise, with the size that the shim asserts for this width and
        // the alignment that `Model::new` checked.
        unsafe {
            match self.store {
                Store::U8 => self.at.write(value as u8),
                Store::U16 => self.at.cast::<u16>().write(value as u16),
                Store::U32 => self.at.cast::<u32>().write(value as u32),
                Store::U64 | Store::Words => self.at.cast::<u64>().write(value),
            }
        }
    }

    /// # Safety
    /// The port has at most 64 bits, its model is live, and nothing writes to it.
    #[inline]
    unsafe fn load(self) -> u64 {
        // SAFETY: as in `store`.
        unsafe {
            match self.store {
                Store::U8 => u64::from(self.at.read()),
                Store::U16 => u64::from(self.at.cast::<u16>().read()),
                Store::U32 => u64::from(self.at.cast::<u32>().read()),
                Store::U64 | Store::Words => self.at.cast::<u64>().read(),
            }
        }
    }

    /// # Safety
    /// The port has more than 64 bits, its model lives for `'a`, and nothing writes to it then.
    #[inline]
    unsafe fn array<'a>(self) -> &'a [u32] {
        // SAFETY: the caller's promise, and the shim asserts that there are as many words.
        unsafe { std::slice::from_raw_parts(self.at.cast::<u32>(), self.words as usize) }
    }
}

/// Copies without a call: most ports are too short to pay for one.
#[inline]
fn copy_words(to: &mut [u32], from: &[u32]) {
    const CHUNK: usize = 8;
    let (to, to_rest) = to.as_chunks_mut::<CHUNK>();
    let (from, from_rest) = from.as_chunks::<CHUNK>();
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
    for (to, from) in to_rest.iter_mut().zip(from_rest) {
        *to = *from;
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
