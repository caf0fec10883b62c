//! Dialects of trajectories, and how one is recognised.

use potamoi_base::file_keys::Notes;

use super::error::TrajectoryError;
use super::lines::{Line, Lines, shown};

/// A dialect of trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// TUM RGB-D.
    Tum,
    /// EuRoC MAV.
    Euroc,
    /// KITTI odometry.
    Kitti,
    /// Replica, as NICE-SLAM distributes it.
    Replica,
    /// Timestamped matrices.
    Poses,
}

/// Digits of a time in nanoseconds since 1970: no time in seconds has as many before its point.
const NANOSECONDS: usize = 16;

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 5] = [
        Self::Tum,
        Self::Euroc,
        Self::Kitti,
        Self::Replica,
        Self::Poses,
    ];

    /// Its name in descriptions.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tum => "tum",
            Self::Euroc => "euroc",
            Self::Kitti => "kitti",
            Self::Replica => "replica",
            Self::Poses => "poses",
        }
    }

    /// The dialect of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// Whether every pose has a time.
    #[must_use]
    pub const fn has_times(self) -> bool {
        matches!(self, Self::Tum | Self::Euroc | Self::Poses)
    }

    /// Recognises the dialect from the first line of numbers.
    pub(super) fn recognised(
        lines: &Lines<'_>,
        notes: &mut Notes,
    ) -> Result<Self, TrajectoryError> {
        let first = lines.data().find(|line| !is_header(*line));
        let Some(first) = first else {
            return Err(TrajectoryError::file(lines.path, "no pose", "at least two"));
        };
        let words = first.words().map_err(|wrong| lines.at(first, wrong))?;
        let has_commas = first.text().is_ok_and(|text| text.contains(','));
        let (dialect, sign) = match (words.len(), words[..].first()) {
            (_, Some(time)) if has_commas && is_nanoseconds(time) => (
                Self::Euroc,
                "times in nanoseconds between commas".to_owned(),
            ),
            (count @ (8 | 12 | 13 | 16 | 17), _) => {
                let dialect = match count {
                    8 => Self::Tum,
                    12 => Self::Kitti,
                    16 => Self::Replica,
                    _ => Self::Poses,
                };
                (dialect, format!("{count} numbers a line"))
            }
            (count, _) => {
                let line = shown(first.text().unwrap_or_default());
                let wrong = (
                    "the first line of numbers",
                    format!("{line:?}, {count} values"),
                    "8 values (tum), 12 (kitti), 16 (replica), 13 or 17 (poses), or times in \
                     nanoseconds between commas (euroc); camera.format names the dialect"
                        .to_owned(),
                );
                return Err(lines.at(first, wrong));
            }
        };
        notes.assume(format!("format: {}, from {sign}", dialect.name()));
        Ok(dialect)
    }
}

fn is_nanoseconds(text: &str) -> bool {
    text.len() >= NANOSECONDS && text.bytes().all(|b| b.is_ascii_digit())
}

/// Whether a line names columns, as those of EuRoC do where the `#` was removed.
pub(super) fn is_header(line: Line<'_>) -> bool {
    let text = line.text().unwrap_or_default();
    text.trim_start_matches('#')
        .trim_start()
        .starts_with("timestamp")
}
