//! Units that keep what goes through them.

use potamoi_formats::units::VectorOp;

use super::{GatherTask, Product, UnitError, Units};

/// A gathering task and its features.
#[derive(Debug, Clone, PartialEq)]
pub struct Gathered {
    /// What was gathered.
    pub task: GatherTask,
    /// `channels` codes for every entry.
    pub features: Vec<i16>,
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
    limits: Limits,
    /// Tasks, in order.
    pub gathered: Vec<Gathered>,
    /// Operations, in order.
    pub computed: Vec<Computed>,
}

impl<'u> Recorder<'u> {
    /// A recorder of `units`.
    pub fn new(units: &'u mut dyn Units, limits: Limits) -> Self {
        Self {
            units,
            limits,
            gathered: vec![],
            computed: vec![],
        }
    }
}

impl Units for Recorder<'_> {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let mut at = features.len();
        self.units.gather(tasks, features)?;
        for task in tasks {
            if self.limits.entries == 0 {
                break;
            }
            let codes = task.entries.len() * task.channels;
            let own = features.get(at..at + codes).unwrap_or_default();
            self.gathered.push(Gathered {
                task: task.clone(),
                features: own.to_vec(),
            });
            at += codes;
            let entries = task.entries.len() as u64;
            self.limits.entries = self.limits.entries.saturating_sub(entries);
        }
        Ok(())
    }

    /// Sums go through; they are not kept.
    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.units.sums(tasks, sums)
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
