//! The table of samples that every dialect is read into, and poses between them.

use std::path::Path;
use std::sync::Arc;

use potamoi_base::file_keys::Notes;
use serde::{Serialize, Serializer};

use super::error::TrajectoryError;
use super::lines::Line;
use super::pose::Pose;

/// Maximum number of poses.
const MAX_POSES: usize = 1 << 20;
/// A step of more than this multiple of the median step is a gap.
pub const GAP: f64 = 10.0;

/// A pose at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sample {
    /// Seconds since the first sample.
    pub seconds: f64,
    /// The pose, camera to world.
    pub pose: Pose,
}

/// Poses over time: at least two, at increasing times from 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trajectory {
    /// Shared by copies of a scene.
    #[serde(serialize_with = "all")]
    samples: Arc<[Sample]>,
}

fn all<S: Serializer>(samples: &Arc<[Sample]>, to: S) -> Result<S::Ok, S::Error> {
    samples[..].serialize(to)
}

/// Samples as they are read.
pub(super) struct Table<'a> {
    path: &'a Path,
    samples: Vec<Sample>,
    /// Lines that repeat a time, and the first of them.
    repeated: Option<(usize, usize)>,
}

impl<'a> Table<'a> {
    pub(super) const fn new(path: &'a Path) -> Self {
        Self {
            path,
            samples: vec![],
            repeated: None,
        }
    }

    /// Poses read.
    pub(super) const fn count(&self) -> usize {
        self.samples.len()
    }

    /// Adds the pose of a line; `time` is its time as the file has it.
    pub(super) fn push(
        &mut self,
        line: Line<'_>,
        time: &str,
        sample: Sample,
    ) -> Result<(), TrajectoryError> {
        let last = self.samples.last().map(|last| last.seconds);
        if last.is_some_and(|last| sample.seconds < last) {
            let expected = "at least the time of the pose before; sort the lines by time";
            let wrong = ("timestamp", time.to_owned(), expected.to_owned());
            return Err(line.wrong(self.path, wrong));
        }
        if last == Some(sample.seconds) {
            let (count, first) = self.repeated.unwrap_or((0, line.number));
            self.repeated = Some((count + 1, first));
            return Ok(());
        }
        if self.samples.len() == MAX_POSES {
            let expected = format!("at most {MAX_POSES} poses; cut the file");
            return Err(TrajectoryError::file(self.path, "more poses", &expected));
        }
        self.samples.push(sample);
        Ok(())
    }

    pub(super) fn finish(self, notes: &mut Notes) -> Result<Trajectory, TrajectoryError> {
        let count = self.samples.len();
        if count < 2 {
            let found = match count {
                0 => "no pose",
                _ => "one pose",
            };
            let expected = "at least two, at different times";
            return Err(TrajectoryError::file(self.path, found, expected));
        }
        if let Some((count, first)) = self.repeated {
            notes.list(match count {
                1 => format!("line {first}, which repeats a time"),
                _ => format!("{count} lines that repeat a time, the first is line {first}"),
            });
        }
        Ok(Trajectory {
            samples: self.samples.into(),
        })
    }
}

impl Trajectory {
    /// A trajectory from samples.
    ///
    /// # Panics
    /// Fewer than two samples, or times that do not increase from 0.
    #[cfg(test)]
    pub(super) fn of(samples: &[Sample]) -> Self {
        assert!(samples.len() > 1 && samples[0].seconds == 0.0);
        assert!(samples.windows(2).all(|w| w[0].seconds < w[1].seconds));
        Self {
            samples: samples.into(),
        }
    }

    /// The samples, at least two.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The time of the last sample, in seconds since the first.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.samples.last().map_or(0.0, |last| last.seconds)
    }

    /// The pose at a time in seconds since the first sample: between the samples around it, position
    /// along the line and rotation along the shortest arc at a constant rate. `None` before the
    /// first and after the last sample.
    ///
    /// Between samples `h` seconds apart, a motion whose acceleration is at most `a` deviates from
    /// the line by at most `a * h * h / 8`.
    #[must_use]
    pub fn pose(&self, seconds: f64) -> Option<Pose> {
        let behind = self.samples.partition_point(|s| s.seconds <= seconds);
        let before = &self.samples[behind.checked_sub(1)?];
        if before.seconds == seconds {
            return Some(before.pose);
        }
        let after = self.samples.get(behind)?;
        let share = (seconds - before.seconds) / (after.seconds - before.seconds);
        Some(before.pose.towards(&after.pose, share))
    }

    /// The median time between samples, in seconds.
    #[must_use]
    pub fn usual_step(&self) -> f64 {
        let mut steps: Vec<f64> = self.steps().map(|(_, step)| step).collect();
        let half = steps.len() / 2;
        *steps.select_nth_unstable_by(half, f64::total_cmp).1
    }

    /// Begin and length of each step, in seconds.
    fn steps(&self) -> impl Iterator<Item = (f64, f64)> {
        let pairs = self.samples.windows(2);
        pairs.map(|pair| (pair[0].seconds, pair[1].seconds - pair[0].seconds))
    }

    /// Begin and length of the steps within a span that are longer than [`GAP`] times the usual
    /// one, in seconds.
    #[must_use]
    pub fn gaps(&self, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
        let most = GAP * self.usual_step();
        let within = |(at, step): &(f64, f64)| at + step > from && *at < to;
        let steps = self.steps().filter(within);
        steps.filter(|(_, step)| *step > most).collect()
    }

    /// The largest distance from the position at the begin of a span to those within it, in the
    /// file's units.
    #[must_use]
    pub fn extent(&self, [from, to]: [f64; 2]) -> f64 {
        let Some(first) = self.pose(from) else {
            return 0.0;
        };
        let within = self.samples.iter().filter(|s| s.seconds > from);
        let within = within.take_while(|s| s.seconds < to).map(|s| s.pose);
        let all = within.chain(self.pose(to));
        let far = all.map(|pose| (pose.position - first.position).length());
        far.fold(0.0, f64::max)
    }

    /// Turns poses of a body into those of a sensor on it.
    pub(super) fn move_to_sensor(&mut self, sensor: Pose) {
        let moved = self.samples.iter().map(|sample| Sample {
            pose: sample.pose.then(&sensor),
            ..*sample
        });
        self.samples = moved.collect();
    }
}
