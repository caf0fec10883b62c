//! Access to single ports.

use super::{
    Model,
    slot::{Store, copy_words},
};
use crate::{Error, PortId};

impl Model {
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
}
