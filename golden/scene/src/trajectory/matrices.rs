//! Poses as matrices by rows.
//!
//! - KITTI odometry (Geiger et al. 2012; `readme.txt` of its development kit): 12 numbers, the pose of
//!   the left camera in the frame of the first, where x is right, y down and z ahead.
//! - Replica as NICE-SLAM distributes it (`traj.txt`): 16 numbers, camera to world, x right, y down and
//!   z ahead. NICE-SLAM turns y and z round for its own renderer, which looks along -z.
//! - Timestamped matrices, as of PennCOSYVIO: seconds, then 12 or 16 numbers, camera to world.

use super::dialect::Dialect;
use super::error::{TrajectoryError, Wrong};
use super::lines::{Line, Lines, number};
use super::pose::{FAR, Pose};
use super::table::{Sample, Table};
use super::times::Clock;
use super::tum::LATEST;

/// Numbers of a matrix, by rows.
const FIELDS: [&str; 16] = [
    "r11", "r12", "r13", "t1", "r21", "r22", "r23", "t2", "r31", "r32", "r33", "t3", "r41", "r42",
    "r43", "r44",
];

pub(super) fn read(
    lines: &Lines<'_>,
    dialect: Dialect,
    clock: &Clock,
    table: &mut Table<'_>,
) -> Result<(), TrajectoryError> {
    let mut first = None;
    let mut count = 0;
    for line in lines.data() {
        let (time, pose) = pose(line, dialect).map_err(|wrong| lines.at(line, wrong))?;
        let (told, seconds) = match time {
            Some((told, seconds)) => (told, seconds - *first.get_or_insert(seconds)),
            None => ("", clock.seconds(count)?),
        };
        table.push(line, told, Sample { seconds, pose })?;
        count += 1;
    }
    clock.check(count)
}

/// A line's time as text and in seconds, where it has one.
type Time<'a> = Option<(&'a str, f64)>;

fn pose(line: Line<'_>, dialect: Dialect) -> Result<(Time<'_>, Pose), Wrong> {
    let words = line.words()?;
    let (counts, expected): (&[usize], _) = match dialect {
        Dialect::Kitti => (&[12], "12: three rows of a matrix"),
        Dialect::Replica => (&[16], "16: four rows of a matrix"),
        _ => (
            &[13, 17],
            "13 or 17: a timestamp, and three or four rows of a matrix",
        ),
    };
    if !counts.contains(&words.len()) {
        let found = words.len().to_string();
        return Err(("the number of values", found, expected.to_owned()));
    }
    let (time, rest) = match dialect.has_times() {
        true => {
            let seconds = number("timestamp", words[0], LATEST)?;
            (Some((words[0], seconds)), &words[1..])
        }
        false => (None, &words[..]),
    };
    let numbers = rest.iter().zip(FIELDS);
    let numbers = numbers.map(|(word, field)| number(field, word, FAR));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    Ok((time, Pose::of_matrix(&numbers)?))
}
