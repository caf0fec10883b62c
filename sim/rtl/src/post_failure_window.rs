//! Continues a run after a failure, so that a dump shows what follows.

use super::model::RtlError;
use super::wave_dump::AFTER;

/// Observer that continues a run for some cycles after a failure.
pub(super) struct PostFailureWindow<W> {
    inner: W,
    failed: Option<RtlError>,
    left: u64,
}

impl<W> PostFailureWindow<W> {
    pub(super) const fn new(inner: W) -> Self {
        Self {
            inner,
            failed: None,
            left: AFTER,
        }
    }

    pub(super) fn after(
        &mut self,
        step: impl FnOnce(&mut W) -> Result<(), RtlError>,
    ) -> Result<(), RtlError> {
        if self.failed.is_none() {
            self.failed = step(&mut self.inner).err();
        } else if self.left > 0 {
            self.left -= 1;
        } else if let Some(error) = self.failed.take() {
            return Err(error);
        }
        Ok(())
    }
}
