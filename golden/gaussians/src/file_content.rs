//! The content of a splat file.

use glam::DVec3;
use rayon::prelude::*;

use super::axes::Axes;
use super::cloud::Cloud;
use potamoi_base::file_keys::{Format, Notes};

/// What a file says of itself beside its Gaussians.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Facts {
    /// The format's name.
    pub format: &'static str,
    /// The version that the file states.
    pub version: Option<String>,
    /// The program that the file names as its writer.
    pub generator: Option<String>,
    /// Other properties, such as the compression level: names and values.
    pub more: Vec<(String, String)>,
    /// Values that were held at a limit, and how many of each kind.
    pub clamped: Vec<(String, u64)>,
    /// Bytes of all files that were read.
    pub bytes: u64,
    /// Directions of x, y and z in the file.
    pub axes: Option<Axes>,
    /// Who says so.
    pub axes_from: AxesFrom,
}

/// Who says where a file's axes point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AxesFrom {
    /// Nobody: those that files of the format usually have.
    #[default]
    Format,
    /// The file.
    File,
    /// The user.
    User,
}

impl Facts {
    /// A file of a format of which nothing else is known yet.
    #[must_use]
    pub fn of(format: &'static Format) -> Self {
        Self {
            format: format.name,
            ..Self::default()
        }
    }

    /// The same file, which states this version.
    #[must_use]
    pub fn version(mut self, version: impl ToString) -> Self {
        self.version = Some(version.to_string());
        self
    }

    /// Adds a property.
    pub(super) fn say(&mut self, name: &str, value: impl ToString) {
        self.more.push((name.to_owned(), value.to_string()));
    }

    /// Adds values that were held at a limit, if there are any.
    pub(super) fn clamp(&mut self, what: &str, count: u64) {
        if count > 0 {
            self.clamped.push((what.to_owned(), count));
        }
    }
}

/// Gaussians of a file, with further information from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The Gaussians in cloud axes: right, down, front.
    pub cloud: Cloud,
    /// Unused parts of the file, and assumptions.
    pub notes: Notes,
    /// Position of the cloud's origin in the file's world. It differs from zero if the centres are
    /// too far off for 32-bit floats.
    pub origin: DVec3,
    /// The vertical axis, if the file names one.
    pub up: Option<DVec3>,
    /// What the file says of itself.
    pub facts: Facts,
}

/// The content of a file in its own axes.
#[derive(Debug)]
pub struct Raw {
    pub(super) cloud: Cloud,
    pub(super) notes: Notes,
    pub(super) origin: DVec3,
    pub(super) up: Option<DVec3>,
    pub(super) facts: Facts,
    /// The axes that the file names.
    pub(super) axes: Option<Axes>,
    /// The default axes of the format.
    pub usual: Axes,
}

impl Raw {
    /// For a format whose axes are those of a cloud.
    pub fn new(cloud: Cloud, notes: Notes) -> Self {
        Self {
            cloud,
            notes,
            origin: DVec3::ZERO,
            up: None,
            facts: Facts::default(),
            axes: None,
            usual: Axes::RIGHT_DOWN_FRONT,
        }
    }

    /// The same content, with what the file says of itself.
    #[must_use]
    pub fn with(self, facts: Facts) -> Self {
        Self { facts, ..self }
    }

    /// Converts to cloud axes from the `asked` ones, or else from those that the file names, or
    /// else from the format's default.
    pub fn turned(mut self, asked: Option<Axes>) -> Loaded {
        let (axes, from) = match (asked, self.axes) {
            (Some(asked), said) => {
                if said.is_some_and(|said| said != asked) {
                    self.notes
                        .list("its axes, in place of which others are given");
                }
                (asked, AxesFrom::User)
            }
            (None, Some(said)) => (said, AxesFrom::File),
            (None, None) => {
                self.notes.assume(format!("axes {}", self.usual));
                (self.usual, AxesFrom::Format)
            }
        };
        let facts = Facts {
            axes: Some(axes),
            axes_from: from,
            ..self.facts
        };
        let zero = |q: &&[f32; 4]| q.iter().all(|v| *v == 0.0);
        let rotations = self.cloud.rotations().par_iter().with_min_len(1 << 14);
        let turnless = rotations.filter(zero).count();
        if turnless > 0 {
            self.notes.assume(format!(
                "no rotation where a quaternion is 0 ({turnless} of {} Gaussians)",
                self.cloud.len()
            ));
        }
        for sentence in self.cloud.implausible() {
            self.notes.assume(sentence);
        }
        let vector = |v: DVec3| DVec3::from(axes.point(v.to_array()));
        Loaded {
            cloud: self.cloud.turned(axes),
            notes: self.notes,
            origin: vector(self.origin),
            up: self.up.map(vector),
            facts,
        }
    }
}
