//! Recorded motion: trajectories of TUM, EuRoC, KITTI and Replica, and lists of timestamped poses.
//!
//! A file is read into a table of [`Sample`]s: camera-to-world poses over time, where a camera looks
//! along its +z axis, x right and y down. [`Trajectory::pose`] interpolates between the samples, and
//! [`Motion`] places the motion in a scene.
//!
//! | dialect | a line | time | pose |
//! |---|---|---|---|
//! | `tum` | `timestamp tx ty tz qx qy qz qw` | seconds | of the optical centre of the camera in the world |
//! | `euroc` | `timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z, ...` | nanoseconds | of the body in the world |
//! | `kitti` | 12 numbers, by rows | none, or a `times.txt` | of the left camera in the first one's frame |
//! | `replica` | 16 numbers, by rows | none | of the camera in the world |
//! | `poses` | `timestamp`, then 12 or 16 numbers, by rows | seconds | of the camera in the world |

mod dialect;
mod error;
mod euroc;
mod keys;
mod lines;
mod matrices;
mod motion;
mod pose;
mod table;
#[cfg(test)]
mod tests;
mod times;
mod tum;

use std::path::{Path, PathBuf};

use potamoi_base::file_keys::Notes;

pub use dialect::Dialect;
pub use error::TrajectoryError;
pub(super) use keys::FORMATS;
pub(super) use motion::Span;
pub use motion::{Motion, Placement};
pub use pose::Pose;
pub use table::{GAP, Sample, Trajectory};

use lines::Lines;
use table::Table;

/// The largest file, in bytes.
const LIMIT: u64 = 1 << 28;

/// Facts that a file itself does not hold.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileFacts {
    /// The dialect; by default it is recognised from the first line of numbers.
    pub dialect: Option<Dialect>,
    /// A file with the times of a `kitti` trajectory, in seconds, one a line; by default `times.txt`
    /// in the folder of the poses, where there is one.
    pub times: Option<PathBuf>,
    /// Poses a second of a file without times, 0.001 to 1000.
    pub file_hz: Option<f64>,
    /// The camera's pose in the frame that the file's poses are of, as `T_BS` of EuRoC's
    /// `sensor.yaml`: 16 numbers by rows. By default the identity.
    pub t_bs: Option<[f64; 16]>,
}

/// Reads a trajectory of at least two poses. Unused parts and assumptions are added to `notes`.
///
/// # Errors
/// The file cannot be read, is of no known dialect, or has a line that is no pose, times that go
/// back, or fewer than two poses.
pub fn read(
    path: &Path,
    facts: &FileFacts,
    notes: &mut Notes,
) -> Result<Trajectory, TrajectoryError> {
    let bytes = bytes_of(path)?;
    let lines = Lines::new(path, &bytes);
    let dialect = match facts.dialect {
        Some(dialect) => dialect,
        None => Dialect::recognised(&lines, notes)?,
    };
    let file_frame = facts.t_bs.map(|all| pose::extrinsics(path, &all));
    let mut table = Table::new(path);
    match dialect {
        Dialect::Tum => tum::read(&lines, &mut table)?,
        Dialect::Euroc => euroc::read(&lines, &mut table, notes)?,
        Dialect::Kitti | Dialect::Replica | Dialect::Poses => {
            let clock = times::Clock::of(path, dialect, facts, notes)?;
            matrices::read(&lines, dialect, &clock, &mut table)?;
        }
    }
    if dialect.has_times() {
        for (field, given) in [
            ("camera.times", facts.times.is_some()),
            ("camera.file_hz", facts.file_hz.is_some()),
        ] {
            if given {
                let found = format!("{field} is given for the dialect {}", dialect.name());
                let expected = "it left out, as every pose has a time";
                return Err(TrajectoryError::file(path, &found, expected));
            }
        }
    }
    let mut trajectory = table.finish(notes)?;
    match file_frame.transpose()? {
        Some(sensor) => trajectory.move_to_sensor(sensor),
        None if dialect == Dialect::Euroc => {
            notes.assume("T_BS: the identity, so that the camera is the body");
        }
        None => {}
    }
    Ok(trajectory)
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, TrajectoryError> {
    let fail = |source| TrajectoryError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
    bytes.ok_or_else(|| {
        let expected = format!("at most {LIMIT} bytes");
        TrajectoryError::file(path, "the file is larger", &expected)
    })
}
