//! Compositing samples in the hardware's formats, through the vector unit.
//!
//! | step | operation | result |
//! |---|---|---|
//! | density | ReLU | its own format |
//! | s | multiply by the step, floor | U4.G, G = `one_minus_frac_bits` |
//! | alpha | 1 - exp(-s) | U0.F, exactly 0 at 0 |
//! | T' | T times 2^F - alpha, shift F, half up | U1.20 |
//! | colour | ReLU of each channel | its own format |
//! | product | T - T' times the channel, half even | 20 to 24 fraction bits |
//!
//! Colours that are linear in the viewing direction take one exact sum of four
//! 16-bit products a channel, rounded half-even: work of the MAC array. Products
//! are summed exactly. The weights T - T' and what is left of T add up to
//! exactly 1.
//!
//! A ray stops where the exact product T (2^F - alpha) is below 1e-3, before it
//! is rounded.

use std::collections::BTreeMap;

use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};

use super::error::VoxelError;
use super::float::STOP_BELOW;
use super::formats::{DIRECTION_BITS, Formats, STEP_BITS, TRANSMITTANCE};
use super::grid::Layout;
use super::ray::Ray;
use super::schedule::Span;
use crate::units::Units;

const CLEAR: i32 = 1 << TRANSMITTANCE.frac_bits();

/// Counts of what the vector unit and the MAC array were given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Work {
    pub(crate) elements: BTreeMap<OpCode, u64>,
    pub(crate) direction_sums: u64,
    /// Samples that added to a pixel.
    pub(crate) composited: u64,
    pub(crate) stopped: u64,
}

/// The rays of a group while they are composited.
#[derive(Debug)]
pub(crate) struct Compositor {
    layout: Layout,
    formats: Formats,
    step: i32,
    /// A ray stops where T (2^F - alpha), 20 + F fraction bits, is below.
    stop: Option<i64>,
    directions: Vec<[i32; 3]>,
    /// U1.20.
    pub(crate) transmittance: Vec<i32>,
    /// [`Formats::pixel_bits`] fraction bits.
    pub(crate) colour: Vec<[i64; 3]>,
    stopped: Vec<bool>,
}

/// One sample that is seen.
struct Seen {
    ray: u32,
    entry: u32,
    weight: i32,
}

impl Compositor {
    pub(crate) fn new(
        layout: Layout,
        formats: &Formats,
        step: f64,
        terminate: bool,
        rays: &[Ray],
    ) -> Self {
        let one = f64::from(1u32 << DIRECTION_BITS);
        let bits = (TRANSMITTANCE.frac_bits() + formats.alpha.frac_bits()) as i32;
        Self {
            layout,
            formats: *formats,
            step: Formats::step_code(step),
            stop: terminate.then(|| (STOP_BELOW * 2f64.powi(bits)).ceil() as i64),
            directions: rays
                .iter()
                .map(|r| (r.direction * one).to_array().map(|v| v.round() as i32))
                .collect(),
            transmittance: vec![CLEAR; rays.len()],
            colour: vec![[0; 3]; rays.len()],
            stopped: vec![false; rays.len()],
        }
    }

    /// Whether a ray goes on.
    pub(crate) fn is_alive(&self, ray: u32) -> bool {
        !self.stopped[ray as usize]
    }

    /// Composites the features of a batch, in which a ray has one span at most.
    pub(crate) fn run(
        &mut self,
        features: &[i16],
        spans: &[Span],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<(), VoxelError> {
        let channels = self.layout.channels();
        let density: Vec<i32> = features
            .chunks_exact(channels)
            .map(|f| i32::from(f[0]))
            .collect();
        let alpha = self.alphas(&density, units, work)?;
        let seen = self.chain(&alpha, spans, units, work)?;
        self.add(features, &seen, units, work)
    }

    fn alphas(
        &self,
        density: &[i32],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<Vec<i32>, VoxelError> {
        let zero = vec![0; density.len()];
        let positive = compute(units, work, VectorOp::new(OpCode::Relu), density, &zero)?;
        let to_depth = VectorOp {
            code: OpCode::Multiply,
            shift: self.formats.depth_shift() as u8,
            rounding: Rounding::Floor,
        };
        let step = vec![self.step; density.len()];
        let depth = compute(units, work, to_depth, &positive, &step)?;
        compute(
            units,
            work,
            VectorOp::new(OpCode::OneMinusExp),
            &depth,
            &zero,
        )
    }

    /// Follows each ray through its span: all first samples, all second ones,
    /// and so on.
    fn chain(
        &mut self,
        alpha: &[i32],
        spans: &[Span],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<Vec<Seen>, VoxelError> {
        let bits = self.formats.alpha.frac_bits();
        let op = VectorOp {
            code: OpCode::Multiply,
            shift: bits as u8,
            rounding: Rounding::HalfUp,
        };
        let mut seen = Vec::new();
        let mut live: Vec<Span> = spans.to_vec();
        let mut at = 0;
        while !live.is_empty() {
            let a: Vec<i32> = live
                .iter()
                .map(|s| self.transmittance[s.ray as usize])
                .collect();
            let b: Vec<i32> = live
                .iter()
                .map(|s| (1 << bits) - alpha[(s.start + at) as usize])
                .collect();
            let next = compute(units, work, op, &a, &b)?;
            for (i, span) in live.iter().enumerate() {
                let ray = span.ray as usize;
                let weight = a[i] - next[i];
                if weight != 0 {
                    seen.push(Seen {
                        ray: span.ray,
                        entry: span.start + at,
                        weight,
                    });
                }
                self.transmittance[ray] = next[i];
                let exact = i64::from(a[i]) * i64::from(b[i]);
                if self.stop.is_some_and(|stop| exact < stop) {
                    self.stopped[ray] = true;
                    work.stopped += 1;
                }
            }
            at += 1;
            live.retain(|s| s.len > at && !self.stopped[s.ray as usize]);
        }
        work.composited += seen.len() as u64;
        Ok(seen)
    }

    fn add(
        &mut self,
        features: &[i16],
        seen: &[Seen],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<(), VoxelError> {
        let channels = self.layout.channels();
        let mut colour = Vec::with_capacity(3 * seen.len());
        for s in seen {
            let f = &features[s.entry as usize * channels..][1..channels];
            match self.layout {
                Layout::Constant => colour.extend(f.iter().map(|c| i32::from(*c))),
                Layout::Linear => {
                    let d = self.directions[s.ray as usize];
                    colour.extend(f.as_chunks::<4>().0.iter().map(|c| towards(*c, d)));
                    work.direction_sums += 3;
                }
            }
        }
        let zero = vec![0; colour.len()];
        let colour = compute(units, work, VectorOp::new(OpCode::Relu), &colour, &zero)?;
        let weight: Vec<i32> = seen.iter().flat_map(|s| [s.weight; 3]).collect();
        let op = VectorOp {
            code: OpCode::Multiply,
            shift: self.formats.colour_shift() as u8,
            rounding: Rounding::HalfEven,
        };
        let products = compute(units, work, op, &weight, &colour)?;
        for (s, product) in seen.iter().zip(products.as_chunks::<3>().0) {
            for (sum, p) in self.colour[s.ray as usize].iter_mut().zip(product) {
                *sum += i64::from(*p);
            }
        }
        Ok(())
    }
}

/// `c0 + c1 x + c2 y + c3 z`, exact, then rounded to the coefficients' format.
fn towards(c: [i16; 4], d: [i32; 3]) -> i32 {
    let sum = (i64::from(c[0]) << DIRECTION_BITS)
        + (1..4)
            .map(|i| i64::from(c[i]) * i64::from(d[i - 1]))
            .sum::<i64>();
    // Below 2^18: four codes of 16 bits times at most 1.
    round_shift(i128::from(sum), DIRECTION_BITS, Rounding::HalfEven) as i32
}

fn compute(
    units: &mut dyn Units,
    work: &mut Work,
    op: VectorOp,
    a: &[i32],
    b: &[i32],
) -> Result<Vec<i32>, VoxelError> {
    let mut out = vec![0; a.len()];
    if !a.is_empty() {
        units.vector(op, a, b, &mut out).map_err(VoxelError::Unit)?;
        *work.elements.entry(op.code).or_default() += a.len() as u64;
    }
    Ok(out)
}

const _: () = assert!(STEP_BITS < 28, "a step of 8 voxels must fit 31 bits");
