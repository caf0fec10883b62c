//! Units that keep what goes through them.

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::units::VectorOp;

use super::gather::Reducer;
use super::{GatherTask, Product, UnitError, Units};

/// A gathering task and what the unit gives of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// What was gathered.
    pub task: GatherTask,
    /// `channels` values for every entry: codes of 16 bits, or unrounded sums of a unit with
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
    /// Second operands, as many.
    pub b: Vec<i32>,
    /// Results, as many.
    pub out: Vec<i32>,
}

/// How much is kept. What is past a limit still goes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// RIT entries; the last task may exceed it.
    pub entries: u64,
    /// Elements of vector operations; operations are kept whole or not.
    pub elements: u64,
}

impl Limits {
    /// Everything.
    pub const NONE: Self = Self {
        entries: u64::MAX,
        elements: u64::MAX,
    };
}

/// Keeps the work and the results of other units.
pub struct Recorder<'u> {
    units: &'u mut dyn Units,
    sums: Sums,
    reducer: Reducer,
    limits: Limits,
    /// Tasks, in order.
    pub gathered: Vec<Gathered>,
    /// Operations, in order.
    pub computed: Vec<Computed>,
}

impl<'u> Recorder<'u> {
    /// A recorder of `units`, which are those of `config`.
    pub fn new(units: &'u mut dyn Units, config: &Config, limits: Limits) -> Self {
        Self {
            units,
            sums: config.gu.sums,
            reducer: Reducer::new(config),
            limits,
            gathered: vec![],
            computed: vec![],
        }
    }

    fn keep<T: Copy + Into<i32>>(&mut self, tasks: &[GatherTask], features: &[T]) {
        let mut at = 0;
        for task in tasks {
            if self.limits.entries == 0 {
                break;
            }
            let values = task.entries.len() * task.channels;
            let own = features.get(at..at + values).unwrap_or_default();
            self.gathered.push(Gathered {
                task: task.clone(),
                features: own.iter().map(|value| (*value).into()).collect(),
            });
            at += values;
            let entries = task.entries.len() as u64;
            self.limits.entries = self.limits.entries.saturating_sub(entries);
        }
    }
}

impl Units for Recorder<'_> {
    /// A unit of exact sums has no rounded ones: its sums are kept, and rounded here.
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        if self.sums == Sums::Exact {
            let mut sums = vec![];
            self.sums(tasks, &mut sums)?;
            let rounded = sums.into_iter().map(|sum| self.reducer.round(sum.into()));
            features.extend(rounded);
            return Ok(());
        }
        let begin = features.len();
        self.units.gather(tasks, features)?;
        self.keep(tasks, &features[begin..]);
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        let begin = sums.len();
        self.units.sums(tasks, sums)?;
        self.keep(tasks, &sums[begin..]);
        Ok(())
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.units.vector(op, a, b, out)?;
        let left = self.limits.elements.checked_sub(out.len() as u64);
        if let Some(left) = left {
            self.limits.elements = left;
            self.computed.push(Computed {
                op,
                a: a.to_vec(),
                b: b.to_vec(),
                out: out.to_vec(),
            });
        }
        Ok(())
    }

    fn multiplied(&mut self, product: Product) {
        self.units.multiplied(product);
    }
}
