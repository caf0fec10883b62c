//! Gathering through the unit, with a check of the number of features.

use potamoi_reference::{GatherTask, Units};

use crate::error::MarchError;

/// Features of all entries of the tasks, in order; an error if their number is wrong.
pub fn gather(
    units: &mut dyn Units,
    tasks: &[GatherTask],
    features: &mut Vec<i16>,
) -> Result<(), MarchError> {
    features.clear();
    if tasks.is_empty() {
        return Ok(());
    }
    units.gather(tasks, features).map_err(MarchError::Unit)?;
    let expected: usize = tasks.iter().map(|t| t.entries.len() * t.channels).sum();
    if features.len() != expected {
        return Err(MarchError::Features {
            found: features.len(),
            expected,
        });
    }
    Ok(())
}
