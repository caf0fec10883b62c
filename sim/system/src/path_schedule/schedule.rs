//! A schedule: tasks, frames, buffer slots, resources and totals.

use schemars::JsonSchema;
use serde::Serialize;

use super::{FrameOrigin, Job, Nanos};
use crate::frame_scheduler::Hold;

/// A resource, which does one job at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resource {
    /// Local renderer of references and of full fallbacks.
    Full,
    /// Renderer of targets.
    Sparse,
    /// Renderer of both, where they are not concurrent.
    Shared,
    /// Remote renderer of references.
    Server,
    /// Link that carries requests and references.
    Link,
}

impl Resource {
    /// All resources.
    pub const ALL: [Self; 5] = [
        Self::Full,
        Self::Sparse,
        Self::Shared,
        Self::Server,
        Self::Link,
    ];

    /// Name of the resource.
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

/// Waiting times in nanoseconds by cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Waits {
    /// Arrival of a pose.
    pub pose: Nanos,
    /// Rendering of a reference.
    pub reference: Nanos,
    /// A free slot of the reference buffer.
    pub buffer: Nanos,
    /// The link, busy or transferring.
    pub link: Nanos,
    /// A lost reference, until it was given up.
    pub loss: Nanos,
    /// Warping that found the angle too large.
    pub angle: Nanos,
    /// A busy renderer.
    pub renderer: Nanos,
}

impl Waits {
    /// Waiting times with the names of their causes.
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

    /// Sum in nanoseconds. Waits of one job follow one another, so that their sum cannot overflow.
    #[must_use]
    pub fn total(&self) -> Nanos {
        self.named().iter().map(|(_, time)| time).sum()
    }
}

/// One job with its resource and its timestamps in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Task {
    /// The job.
    pub job: Job,
    /// Its resource.
    pub resource: Resource,
    /// Arrival of its pose, the earliest possible begin.
    pub asked: Nanos,
    /// Begin: `asked` plus all `waits`.
    pub start: Nanos,
    /// End.
    pub end: Nanos,
    /// Its waits since the arrival of its pose.
    pub waits: Waits,
    /// Idle time of its resource since the last job, by cause.
    pub idle: Waits,
    /// The slot that a reference is written to; `None` for other jobs.
    pub slot: Option<usize>,
}

/// Timestamps of a frame in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FrameTime {
    /// Its number in the path.
    pub number: usize,
    /// The reference that serves it.
    pub reference: usize,
    /// How it was produced.
    pub made: FrameOrigin,
    /// Arrival of its pose.
    pub pose: Nanos,
    /// Rendering finished.
    pub finished: Nanos,
    /// Shown: it and all frames before it are finished.
    pub shown: Nanos,
    /// Waits from its pose until its last job began, or until the reference that it shows was
    /// rendered.
    pub waits: Waits,
}

impl FrameTime {
    /// Latency in nanoseconds, from its pose until it was finished.
    #[must_use]
    pub const fn latency(&self) -> Nanos {
        self.finished - self.pose
    }
}

/// A slot of the reference buffer, held by a reference from its begin until its last target has
/// read it. Times are nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SlotHold {
    /// The reference.
    pub reference: usize,
    /// The slot.
    pub slot: usize,
    /// Begin of the hold.
    pub from: Nanos,
    /// End of the hold.
    pub until: Nanos,
}

impl From<Hold<Nanos>> for SlotHold {
    fn from(hold: Hold<Nanos>) -> Self {
        Self {
            reference: hold.reference,
            slot: hold.slot,
            from: hold.from,
            until: hold.until,
        }
    }
}

/// Time of a resource in nanoseconds: `busy`, all of `idle` and `after` sum to the span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ResourceUse {
    /// The resource.
    pub resource: Resource,
    /// Busy time.
    pub busy: Nanos,
    /// Idle time before jobs, by what they waited for.
    pub idle: Waits,
    /// Idle time after the last job.
    pub after: Nanos,
}

/// Traffic on the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LinkUse {
    /// Bytes in both directions, those of lost and late references included.
    pub bytes: u64,
    /// Energy on the local side, in nanojoules.
    pub nanojoules: u64,
}

/// Totals of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Totals {
    /// Span: nanoseconds until the last task has ended and the last frame is shown.
    pub span: Nanos,
    /// Nanoseconds until the last frame was shown.
    pub shown: Nanos,
    /// Frames a second until the last was shown; `None` where that took no time.
    pub frames_per_second: Option<f64>,
    /// Largest latency of a frame, in nanoseconds.
    pub latency_max: Nanos,
    /// Mean latency of frames, in nanoseconds, rounded down.
    pub latency_mean: Nanos,
    /// Waits of frames, summed over all frames.
    pub frame_waits: Waits,
    /// Waits of references before they were rendered, summed over all references.
    pub reference_waits: Waits,
    /// Nanoseconds in which a reference and a target were rendered at once.
    pub overlap: Nanos,
    /// Traffic on the link.
    pub link: LinkUse,
}

/// A schedule: all tasks and frames with their timestamps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Schedule {
    /// Tasks, sorted by begin, then by end.
    pub tasks: Vec<Task>,
    /// Frames, in order.
    pub frames: Vec<FrameTime>,
    /// Holds of the reference buffer's slots, sorted by begin.
    pub held: Vec<SlotHold>,
    /// Time of each resource.
    pub resources: Vec<ResourceUse>,
    /// Totals.
    pub totals: Totals,
}

impl Schedule {
    /// Utilisation of a resource, from 0 to 1; `None` without that resource or where the span is 0.
    #[must_use]
    pub fn utilisation(&self, resource: Resource) -> Option<f64> {
        let used = self.resources.iter().find(|u| u.resource == resource)?;
        (self.totals.span > 0).then(|| used.busy as f64 / self.totals.span as f64)
    }
}
