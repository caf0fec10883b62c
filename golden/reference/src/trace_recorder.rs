//! An observer that records the calls of units.

use potamoi_formats::units::VectorOp;

use super::observer::{GatherCall, Observer, SplatCall, VectorCall};
use super::{GatherTask, Product, UnitError};

/// A gathering task and its results.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// The task.
    pub task: GatherTask,
    /// `channels` values for every entry: codes of 16 bits, or unrounded sums if the unit has
    /// `gu.sums = "exact"`.
    pub features: Vec<i32>,
}

/// A vector operation and its results.
#[derive(Debug, Clone, PartialEq)]
pub struct Computed {
    /// The operation.
    pub op: VectorOp,
    /// First operands.
    pub a: Vec<i32>,
    /// Second operands, of the same length.
    pub b: Vec<i32>,
    /// Results, of the same length.
    pub out: Vec<i32>,
}

/// Limits of the recording. Calls past a limit are computed but not recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// RIT entries; the last recorded task may exceed it.
    pub entries: u64,
    /// Elements of vector operations; an operation is recorded whole or not at all.
    pub elements: u64,
}

impl Limits {
    /// No limits.
    pub const NONE: Self = Self {
        entries: u64::MAX,
        elements: u64::MAX,
    };
}

/// Records the tasks and operations of units with their results.
pub struct Recorder {
    limits: Limits,
    /// Tasks, in order.
    pub gathered: Vec<Gathered>,
    /// Operations, in order.
    pub computed: Vec<Computed>,
}

impl Recorder {
    /// An empty recorder.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        Self {
            limits,
            gathered: vec![],
            computed: vec![],
        }
    }
}

impl Observer for Recorder {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        call.each_task(|task, features| {
            if self.limits.entries > 0 {
                let entries = task.entries.len() as u64;
                self.limits.entries = self.limits.entries.saturating_sub(entries);
                self.gathered.push(Gathered {
                    task: task.clone(),
                    features,
                });
            }
        });
        Ok(())
    }

    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError> {
        let left = self.limits.elements.checked_sub(call.out.len() as u64);
        if let Some(left) = left {
            self.limits.elements = left;
            self.computed.push(Computed {
                op: call.op,
                a: call.a.to_vec(),
                b: call.b.to_vec(),
                out: call.out.to_vec(),
            });
        }
        Ok(())
    }

    /// The trace has no line of a splat unit.
    fn composited(&mut self, _: &SplatCall<'_>) -> Result<(), UnitError> {
        Err(
            "jobs of the splat unit cannot be recorded: use a configuration without the table [su]"
                .into(),
        )
    }

    /// Products are not recorded.
    fn multiplied(&mut self, _: &Product) {}
}
