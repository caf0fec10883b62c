//! Times of files whose lines have none: a file of times, or a rate.

use std::path::{Path, PathBuf};

use potamoi_base::file_keys::Notes;

use super::dialect::Dialect;
use super::error::TrajectoryError;
use super::lines::{Lines, number};
use super::tum::LATEST;
use super::{FileFacts, bytes_of};

/// Poses a second of KITTI's recordings (Geiger et al. 2013).
const KITTI_HZ: f64 = 10.0;
/// Poses a second that are assumed of Replica's trajectories, which state none.
const REPLICA_HZ: f64 = 30.0;

/// Source of the times of poses.
pub(super) enum Clock {
    /// In the lines themselves.
    Lines,
    /// Poses a second.
    Rate(f64),
    /// Seconds since the first, from a file.
    Times(PathBuf, Vec<f64>),
}

impl Clock {
    pub(super) fn of(
        path: &Path,
        dialect: Dialect,
        facts: &FileFacts,
        notes: &mut Notes,
    ) -> Result<Self, TrajectoryError> {
        let usual = match dialect {
            Dialect::Kitti => KITTI_HZ,
            Dialect::Replica => REPLICA_HZ,
            _ => return Ok(Self::Lines),
        };
        match (&facts.times, facts.file_hz) {
            (Some(_), Some(hz)) => {
                let found = format!("camera.file_hz is {hz}");
                let expected = "it left out, as camera.times is given";
                return Err(TrajectoryError::file(path, &found, expected));
            }
            (Some(times), None) => return Self::times(times.clone()),
            (None, Some(hz)) if (1e-3..=1e3).contains(&hz) => return Ok(Self::Rate(hz)),
            (None, Some(hz)) => {
                let found = format!("camera.file_hz is {hz}");
                let expected = "0.001 to 1000 poses a second";
                return Err(TrajectoryError::file(path, &found, expected));
            }
            (None, None) => {}
        }
        let beside = path.with_file_name("times.txt");
        if dialect == Dialect::Kitti && beside.is_file() {
            notes.assume("times: those of times.txt beside it");
            return Self::times(beside);
        }
        notes.assume(format!("times: {usual} poses a second (camera.file_hz)"));
        Ok(Self::Rate(usual))
    }

    /// Reads seconds, one a line.
    fn times(path: PathBuf) -> Result<Self, TrajectoryError> {
        let bytes = bytes_of(&path)?;
        let lines = Lines::new(&path, &bytes);
        let mut all: Vec<f64> = vec![];
        let mut first = None;
        for line in lines.data() {
            let text = line.text().map_err(|wrong| lines.at(line, wrong))?;
            let time = number("the time", text, LATEST).map_err(|wrong| lines.at(line, wrong))?;
            let time = time - *first.get_or_insert(time);
            if all.last().is_some_and(|last| *last >= time) {
                let expected = "after the time before".to_owned();
                return Err(lines.at(line, ("the time", text.to_owned(), expected)));
            }
            all.push(time);
        }
        Ok(Self::Times(path, all))
    }

    /// Seconds of a pose since the first; 0 where lines have their own times.
    pub(super) fn seconds(&self, pose: usize) -> Result<f64, TrajectoryError> {
        match self {
            Self::Lines => Ok(0.0),
            Self::Rate(hz) => Ok(pose as f64 / hz),
            Self::Times(path, all) => all.get(pose).copied().ok_or_else(|| {
                let found = format!("{} times", all.len());
                TrajectoryError::file(path, &found, "one for each pose, and there are more poses")
            }),
        }
    }

    /// Refuses times beyond those of `poses`.
    pub(super) fn check(&self, poses: usize) -> Result<(), TrajectoryError> {
        match self {
            Self::Times(path, all) if all.len() != poses => {
                let found = format!("{} times", all.len());
                let expected = format!("{poses}, one for each pose");
                Err(TrajectoryError::file(path, &found, &expected))
            }
            _ => Ok(()),
        }
    }
}
