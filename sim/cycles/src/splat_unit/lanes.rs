//! Exponentials: pairs are packed into vectors for the lanes.

use std::collections::VecDeque;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::units::OpCode;

use super::Pair;
use crate::vector_unit::{VectorInputs, VectorModel, VectorTiming};
use crate::work::WorkError;

/// Clocks from a pair to its vector, which is sent.
pub(super) const CYCLES: usize = 2;

/// Pairs of a vector; lanes without one at its end.
pub(super) type Vector = Vec<Option<Pair>>;

/// Registers.
pub(super) struct Lanes {
    lanes: usize,
    room: usize,
    unit: VectorModel,
    filled: Vector,
    in_flight: VecDeque<Vector>,
    /// Vectors that were sent.
    sent: u64,
}

impl Lanes {
    /// # Errors
    /// A configuration that breaks its rules.
    pub(super) fn new(config: &Config, su: &SuConfig) -> Result<Self, WorkError> {
        if config.vu.exp.early_out {
            let text = "vu.exp.early_out is true: expected false with a splat unit, whose cycle model does not \
                 know when an exponential ends early";
            return Err(WorkError::Config(text.to_owned()));
        }
        let own = config.splat_lanes(su);
        Ok(Self {
            lanes: su.lanes as usize,
            room: VectorTiming::new(&own)?.room as usize,
            unit: VectorModel::new(&own)?,
            filled: vec![],
            in_flight: VecDeque::new(),
            sent: 0,
        })
    }

    /// The vector of results that is offered.
    pub(super) fn offered(&self) -> Option<Vector> {
        let vector = self.in_flight.front().filter(|_| self.unit.offers());
        vector.cloned()
    }

    /// Lanes of all vectors that were sent, those without a pair among them.
    pub(super) const fn slots(&self) -> u64 {
        self.sent * self.lanes as u64
    }

    pub(super) fn is_busy(&self) -> bool {
        !self.filled.is_empty() || !self.in_flight.is_empty()
    }

    /// Whether the filled vector is offered to the lanes.
    fn sends(&self) -> bool {
        self.filled.len() == self.lanes && self.in_flight.len() < self.room
    }

    /// Whether a pair is taken at the clock edge.
    pub(super) fn is_ready(&self) -> bool {
        self.filled.len() < self.lanes || self.sends() && self.unit.ready()
    }

    /// One clock edge.
    pub(super) fn step(&mut self, pair: Option<Pair>, flush: bool, pops: bool) {
        let sends = self.sends();
        let pads = flush && !self.filled.is_empty() && self.filled.len() < self.lanes;
        let outputs = self.unit.step(&VectorInputs {
            op: sends.then(|| OpCode::Exp.code()),
            exponent: 0,
            ready: pops,
        });
        if pops {
            self.in_flight.pop_front();
        }
        if sends && outputs.ready {
            let vector = std::mem::take(&mut self.filled);
            self.in_flight.push_back(vector);
            self.sent += 1;
        }
        if pads || pair.is_some() {
            self.filled.push(pair);
        }
    }
}
