//! TUM RGB-D: `timestamp tx ty tz qx qy qz qw`, seconds since 1970, and the pose of the optical
//! centre of the colour camera in the world of the motion capture system (Sturm et al. 2012; "File
//! Formats" of the benchmark's page). Commas between the numbers are read as blanks, as the
//! benchmark's own `associate.py` does.

use glam::DVec3;

use super::error::{TrajectoryError, Wrong};
use super::lines::{Line, Lines, number};
use super::pose::{FAR, Pose};
use super::table::{Sample, Table};

/// The largest time in seconds.
pub(super) const LATEST: f64 = 1e12;
const FIELDS: [&str; 8] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

pub(super) fn read(lines: &Lines<'_>, table: &mut Table<'_>) -> Result<(), TrajectoryError> {
    let mut first = None;
    for line in lines.data() {
        let (words, seconds, pose) = pose(line).map_err(|wrong| lines.at(line, wrong))?;
        let seconds = seconds - *first.get_or_insert(seconds);
        table.push(line, words, Sample { seconds, pose })?;
    }
    Ok(())
}

/// A line's time as text and in seconds, and its pose.
fn pose(line: Line<'_>) -> Result<(&str, f64, Pose), Wrong> {
    let words = line.words()?;
    if words.len() != FIELDS.len() {
        let expected = format!("{}: {}", FIELDS.len(), FIELDS.join(" "));
        return Err(("the number of values", words.len().to_string(), expected));
    }
    let value = |at: usize, most| number(FIELDS[at], words[at], most);
    let seconds = value(0, LATEST)?;
    let position = DVec3::new(value(1, FAR)?, value(2, FAR)?, value(3, FAR)?);
    let parts = [
        value(4, FAR)?,
        value(5, FAR)?,
        value(6, FAR)?,
        value(7, FAR)?,
    ];
    Ok((words[0], seconds, Pose::of_quaternion(position, parts)?))
}
