//! What a schedule says.

use serde::Serialize;

use super::{Job, Made, Nanos};
use crate::frame_scheduler::Hold;

/// What does one thing at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resource {
    /// Renders references that are rendered here, and full fallbacks.
    Full,
    /// Renders targets.
    Sparse,
    /// Renders both, where they are not concurrent.
    Shared,
    /// Renders references elsewhere.
    Server,
    /// Carries requests, and references.
    Link,
}

impl Resource {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Full,
        Self::Sparse,
        Self::Shared,
        Self::Server,
        Self::Link,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full renderer",
            Self::Sparse => "sparse renderer",
            Self::Shared => "renderer",
            Self::Server => "server",
            Self::Link => "link",
        }
    }
}

/// Nanoseconds by what was waited for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Waits {
    /// For a pose to arrive.
    pub pose: Nanos,
    /// For a reference to be rendered.
    pub reference: Nanos,
    /// For a slot of the reference buffer, all being read.
    pub buffer: Nanos,
    /// For bytes on the link, or for the link.
    pub link: Nanos,
    /// For a reference that never came, until it was given up.
    pub loss: Nanos,
    /// For warping that found the angle too large.
    pub angle: Nanos,
    /// For a renderer that was busy.
    pub renderer: Nanos,
}

impl Waits {
    /// Causes by name.
    #[must_use]
    pub const fn named(&self) -> [(&'static str, Nanos); 7] {
        [
            ("pose", self.pose),
            ("reference", self.reference),
            ("buffer", self.buffer),
            ("link", self.link),
            ("loss", self.loss),
            ("angle", self.angle),
            ("renderer", self.renderer),
        ]
    }

    /// Nanoseconds in all; as they follow one another, they are held.
    #[must_use]
    pub fn total(&self) -> Nanos {
        self.named().iter().map(|(_, time)| time).sum()
    }
}

/// One job, when and where it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Task {
    /// What was done.
    pub job: Job,
    /// By what.
    pub resource: Resource,
    /// When its pose was there, before which nobody could have begun it.
    pub asked: Nanos,
    /// When it began: `asked` and all `waits`.
    pub start: Nanos,
    /// When it ended.
    pub end: Nanos,
    /// What it waited for since its pose was there.
    pub waits: Waits,
    /// What its resource waited for, idle, since its last job.
    pub idle: Waits,
    /// Of a reference: the slot that it is written to.
    pub slot: Option<usize>,
}

/// When a frame was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FrameTime {
    /// Its number in the path.
    pub number: usize,
    /// The reference that serves it.
    pub reference: usize,
    /// How it came about.
    pub made: Made,
    /// When its pose arrived.
    pub pose: Nanos,
    /// When it was finished.
    pub finished: Nanos,
    /// When it was shown: finished, and all before it shown.
    pub shown: Nanos,
    /// What it waited for from its pose until it was begun for the last time, or
    /// until the reference that it is was there.
    pub waits: Waits,
}

impl FrameTime {
    /// Nanoseconds from its pose until it was finished.
    #[must_use]
    pub const fn latency(&self) -> Nanos {
        self.finished - self.pose
    }
}

/// A slot of the reference buffer, held by a reference from when it is begun
/// until its last target has read it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Held {
    /// The reference.
    pub reference: usize,
    /// The slot.
    pub slot: usize,
    /// From when.
    pub from: Nanos,
    /// Until when.
    pub until: Nanos,
}

impl From<Hold<Nanos>> for Held {
    fn from(hold: Hold<Nanos>) -> Self {
        Self {
            reference: hold.reference,
            slot: hold.slot,
            from: hold.from,
            until: hold.until,
        }
    }
}

/// How a resource spent its time: `busy`, all `idle` and `after` are the span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ResourceUse {
    /// The resource.
    pub resource: Resource,
    /// Nanoseconds at work.
    pub busy: Nanos,
    /// Nanoseconds idle before a job, by what that job waited for.
    pub idle: Waits,
    /// Nanoseconds after its last job.
    pub after: Nanos,
}

/// What went over the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LinkUse {
    /// Bytes both ways, of references that were lost or came too late too.
    pub bytes: u64,
    /// Their energy, here, in nanojoules.
    pub nanojoules: u64,
}

/// A schedule in few numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Totals {
    /// Nanoseconds until the last task has ended, and the last frame is shown.
    pub span: Nanos,
    /// When the last frame was shown, in nanoseconds.
    pub shown: Nanos,
    /// Frames a second until the last was shown; none where that took no time.
    pub frames_per_second: Option<f64>,
    /// The longest latency of a frame, in nanoseconds.
    pub latency_max: Nanos,
    /// The mean latency of frames, in nanoseconds, rounded down.
    pub latency_mean: Nanos,
    /// What frames waited for, each for itself, summed.
    pub frame_waits: Waits,
    /// What references waited for before they were rendered, summed.
    pub reference_waits: Waits,
    /// Nanoseconds in which a reference and a target were rendered at once.
    pub overlap: Nanos,
    /// What went over the link.
    pub link: LinkUse,
}

/// What was done when.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Schedule {
    /// Tasks, by when they began; those that began at once by when they ended.
    pub tasks: Vec<Task>,
    /// Frames, in order.
    pub frames: Vec<FrameTime>,
    /// What the reference buffer held, by when it was held.
    pub held: Vec<Held>,
    /// How each resource spent its time.
    pub resources: Vec<ResourceUse>,
    /// All in few numbers.
    pub totals: Totals,
}

impl Schedule {
    /// Share of the span in which a resource was at work; none where there was
    /// no such resource, or no time.
    #[must_use]
    pub fn utilisation(&self, resource: Resource) -> Option<f64> {
        let used = self.resources.iter().find(|u| u.resource == resource)?;
        (self.totals.span > 0).then(|| used.busy as f64 / self.totals.span as f64)
    }
}
