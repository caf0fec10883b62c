//! Value change dumps.

use super::Model;
use crate::Error;
use std::{ffi::CString, path::Path};

impl Model {
    /// Opens a value change dump at `path`; an open one is closed first.
    ///
    /// # Errors
    /// [`Error::NoTrace`], [`Error::Trace`] when the file cannot be written, or [`Error::Stopped`].
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

    /// Closes the value change dump.
    ///
    /// # Errors
    /// [`Error::NoTrace`], [`Error::Trace`] when no file is open, or [`Error::Stopped`]; a stopped
    /// model's file is closed when the model is dropped.
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
}
