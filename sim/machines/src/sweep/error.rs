//! Errors of sweeps.

use std::path::PathBuf;

use potamoi_explore::Cause;
use potamoi_scene::SceneError;
use thiserror::Error;

use crate::machine::MachineError;
use crate::space::SpaceError;

/// Why a sweep cannot be run.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The plan cannot be read.
    #[error("cannot read {path}: {source}; name a plan: a TOML file with [vary]")]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The plan is none.
    #[error("{name}: {problem}")]
    Plan {
        /// Its file.
        name: String,
        /// The problem, with its field.
        problem: String,
    },
    /// A part of a plan names what is no machine, scene, field or value.
    #[error("{name}: {part}: {source}")]
    Within {
        /// The plan.
        name: String,
        /// The key or section.
        part: &'static str,
        /// The problem.
        source: Box<SweepError>,
    },
    /// Its fields vary as no machine's do.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// It names what is no machine.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// It names what is no scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The journal cannot be written.
    #[error("cannot write {path}: {source}; name another folder in --work-dir")]
    Journal {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// Another process writes the journal.
    #[error(
        "{path} is in use by another sweep or search: wait until it ends, or name another folder in --work-dir"
    )]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The journal is another program's.
    #[error(
        "{path} has the rows of {found}: expected those of this program ({own}); name another folder in --work-dir, or remove that one"
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it says.
        found: String,
        /// What this program would say.
        own: String,
    },
    /// A column has no better end, or is none.
    #[error("--front {name}: expected some of {known}")]
    Column {
        /// The name.
        name: String,
        /// Columns that can be on a front.
        known: String,
    },
    /// A number is no point's.
    #[error("--points {number}: expected numbers below {points}, that of the plan's points")]
    Point {
        /// The number.
        number: usize,
        /// Number of points.
        points: usize,
    },
    /// What an engine hands over is no line of a point.
    #[error(
        "the engine handed over what is no line of a point: {problem}; expected what `potamoi sweep --points` prints"
    )]
    Line {
        /// The problem.
        problem: String,
    },
    /// An engine ended before all points had their lines.
    #[error(
        "{count} of {points} points have no rows: the engine ended before they were evaluated; the same command goes on"
    )]
    Lacking {
        /// Points without a line; equal ones once.
        count: usize,
        /// Number of points.
        points: usize,
    },
    /// Rows of another sweep cannot be read.
    #[error("{path}: {problem}; expected the folder of a finished sweep")]
    Rows {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: String,
    },
    /// A file that is no table of a sweep stands where its rows are written.
    #[error(
        "{path} is no table of this program's sweeps, and stays as it is: name another folder in --work-dir, or move it away"
    )]
    Taken {
        /// The file.
        path: PathBuf,
    },
}

impl SweepError {
    /// Where its cause is.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match self {
            Self::Machine(error) | Self::Space(SpaceError::Machine(error)) => error.cause(),
            Self::Within { source, .. } => source.cause(),
            Self::Line { .. } | Self::Lacking { .. } => Cause::Tool,
            _ => Cause::Input,
        }
    }
}
