//! Errors of calls, kept out of the fast path.

use super::{Model, copy};
use crate::{Error, PortId, Stop};
use std::ffi::c_int;

impl Model {
    pub(super) fn name(&self, index: u32) -> String {
        let port = self.loaded.ports.get(index as usize);
        port.map(|p| p.name.clone()).unwrap_or_default()
    }

    #[cold]
    #[inline(never)]
    pub(super) fn not_an_input(&self, index: u32) -> Error {
        Error::NotAnInput {
            port: self.name(index),
        }
    }

    #[cold]
    #[inline(never)]
    pub(super) fn wrong_width(
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
    pub(super) fn too_wide(
        &self,
        port: PortId,
        call: &'static str,
        instead: &'static str,
    ) -> Error {
        self.wrong_width(port.index, call, "up to 64 bits".into(), instead)
    }

    #[cold]
    #[inline(never)]
    pub(super) fn wrong_count(&self, port: PortId, call: &'static str, count: usize) -> Error {
        let expected = format!("{} words for it, not {count}", port.words());
        self.wrong_width(port.index, call, expected, "PortId::words for the number")
    }

    #[cold]
    #[inline(never)]
    pub(super) fn wrong_lengths(&self, inputs: usize, outputs: usize) -> Error {
        Error::Packed {
            top: self.loaded.top.clone(),
            inputs,
            outputs,
            expected: self.packed,
        }
    }

    /// Error for an invalid handle or a stopped model.
    #[cold]
    #[inline(never)]
    pub(super) fn unusable(&self) -> Error {
        match &self.dead {
            Some(error) => error.as_ref().clone(),
            None => Error::ForeignPort,
        }
    }

    #[cold]
    #[inline(never)]
    pub(super) fn died(&mut self, cause: c_int) -> Error {
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
}
