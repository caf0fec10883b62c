//! Compositing samples in the hardware's formats, through the vector unit.
//!
//! | step | operation | result |
//! |---|---|---|
//! | alpha | that of the head | U0.F, exactly 0 in empty space |
//! | T' | T times 2^F - alpha, shift F, half up; to fewer bits if the frame has fewer | U1.20 |
//! | colour | that of the head, for visible samples | its own format |
//! | product | T - T' times the colour, half even | 20 to 24 fraction bits |
//!
//! Products are summed exactly. The weights T - T' and the final transmittance add up to exactly
//! 1, except for weights that a head leaves out.
//!
//! Early ray termination: a ray stops where the exact product T (2^F - alpha), before rounding, is
//! below the threshold, 1e-3 by default.

use glam::DVec3;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use crate::error::MarchError;
use crate::setup::Setup;
use crate::shading::{Head, Lanes, Opacities};
use crate::span::Span;
use crate::transmittance::TRANSMITTANCE;
use crate::work::Work;
use potamoi_reference::Units;

const CLEAR: i32 = 1 << TRANSMITTANCE.frac_bits();

/// Compositing state of the rays of a group.
pub struct Compositor<'h> {
    head: &'h dyn Head,
    colour: ColourScale,
    /// A ray stops where T (2^F - alpha), with 20 + F fraction bits, is below this threshold.
    stop: Option<i64>,
    /// Fraction bits that the transmittance does not use.
    spare: u32,
    /// [`Head::direction_codes`] codes a ray.
    directions: Vec<i16>,
    /// Transmittance a ray, U1.20.
    pub(crate) transmittance: Vec<i32>,
    /// Colour sums a ray, [`ColourScale::pixel_bits`] fraction bits.
    pub(crate) sums: Vec<[i64; 3]>,
    /// Samples of each ray up to where it stopped; `u32::MAX` for rays that have not stopped.
    pub(crate) stops: Vec<u32>,
    /// Samples of each ray in earlier batches.
    passed: Vec<u32>,
}

/// A visible sample.
struct VisibleSample {
    ray: u32,
    entry: u32,
    weight: i32,
}

impl<'h> Compositor<'h> {
    /// Starts rays with the given unit directions (world coordinates).
    pub(crate) fn new(head: &'h dyn Head, setup: &Setup<'_>, towards: &[DVec3]) -> Self {
        let bits = (TRANSMITTANCE.frac_bits() + head.alpha_bits()) as i32;
        let rays = towards.len();
        let mut directions = Vec::with_capacity(rays * head.direction_codes());
        for towards in towards {
            head.encode(*towards, &mut directions);
        }
        Self {
            head,
            colour: ColourScale::of(head.colour_bits()),
            stop: setup
                .stop
                .map(|stop| (stop * 2f64.powi(bits)).ceil() as i64),
            spare: TRANSMITTANCE
                .frac_bits()
                .saturating_sub(setup.transmittance_bits),
            directions,
            transmittance: vec![CLEAR; rays],
            sums: vec![[0; 3]; rays],
            stops: vec![u32::MAX; rays],
            passed: vec![0; rays],
        }
    }

    /// Fraction bits of the sums.
    pub fn pixel_bits(&self) -> u32 {
        self.colour.pixel_bits()
    }

    /// Whether a ray has not stopped.
    pub fn is_alive(&self, ray: u32) -> bool {
        self.stops[ray as usize] == u32::MAX
    }

    /// Composites the features of a batch, with at most one span a ray.
    pub fn run(
        &mut self,
        features: Vec<i16>,
        spans: &[Span],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<(), MarchError> {
        let mut lanes = Lanes { units, work };
        let Opacities { mut alpha, kept } = self.head.opacities(&features, &mut lanes)?;
        let [least, _] = self.head.least();
        for alpha in &mut alpha {
            if *alpha <= least {
                *alpha = 0;
            }
        }
        let seen = self.chain(&alpha, spans, units, work)?;
        let width = self.head.kept();
        let mut visible = Vec::with_capacity(seen.len() * width);
        for sample in &seen {
            visible.extend_from_slice(&kept[sample.entry as usize * width..][..width]);
        }
        drop(kept);
        // A batch of TensoRF has more features than all that follows.
        drop(features);
        self.add(visible, &seen, units, work)
    }

    /// Advances all rays in step through their spans: all first samples, all second samples, and
    /// so on.
    fn chain(
        &mut self,
        alpha: &[i32],
        spans: &[Span],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<Vec<VisibleSample>, MarchError> {
        let bits = self.head.alpha_bits();
        let [_, least] = self.head.least();
        let op = VectorOp {
            code: OpCode::Multiply,
            shift: (bits + self.spare) as u8,
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
            let mut next = Lanes { units, work }.compute(op, &a, &b)?;
            next.iter_mut().for_each(|left| *left <<= self.spare);
            for (i, span) in live.iter().enumerate() {
                let ray = span.ray as usize;
                let weight = a[i] - next[i];
                if weight > least {
                    seen.push(VisibleSample {
                        ray: span.ray,
                        entry: span.start + at,
                        weight,
                    });
                } else if b[i] == 1 << bits {
                    work.outcomes.transparent += 1;
                } else {
                    work.outcomes.without_weight += 1;
                }
                self.transmittance[ray] = next[i];
                let exact = i64::from(a[i]) * i64::from(b[i]);
                if self.stop.is_some_and(|stop| exact < stop) {
                    self.stops[ray] = self.passed[ray] + at + 1;
                    work.stopped += 1;
                }
            }
            at += 1;
            let behind = |s: &&Span| s.len > at && !self.is_alive(s.ray);
            let behind = live.iter().filter(behind);
            work.outcomes.behind += behind.map(|s| u64::from(s.len - at)).sum::<u64>();
            live.retain(|s| s.len > at && self.is_alive(s.ray));
        }
        for span in spans {
            self.passed[span.ray as usize] += span.len;
        }
        work.outcomes.composited += seen.len() as u64;
        Ok(seen)
    }

    /// Adds the colours of visible samples, from their kept codes, to the pixels.
    fn add(
        &mut self,
        kept: Vec<i16>,
        seen: &[VisibleSample],
        units: &mut dyn Units,
        work: &mut Work,
    ) -> Result<(), MarchError> {
        let codes = self.head.direction_codes();
        let mut towards = Vec::with_capacity(seen.len() * codes);
        for s in seen {
            towards.extend_from_slice(&self.directions[s.ray as usize * codes..][..codes]);
        }
        let mut lanes = Lanes { units, work };
        let colour = self.head.colours(kept, &towards, &mut lanes)?;
        let weight: Vec<i32> = seen.iter().flat_map(|s| [s.weight; 3]).collect();
        let op = VectorOp {
            code: OpCode::Multiply,
            shift: self.colour.shift() as u8,
            rounding: Rounding::HalfEven,
        };
        let products = lanes.compute(op, &weight, &colour)?;
        for (s, product) in seen.iter().zip(products.as_chunks::<3>().0) {
            for (sum, p) in self.sums[s.ray as usize].iter_mut().zip(product) {
                *sum += i64::from(*p);
            }
        }
        Ok(())
    }
}

/// Fraction bits of colours from the head to the pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColourScale {
    frac_bits: u32,
}

impl ColourScale {
    /// The scale of colours with `frac_bits` fraction bits.
    #[must_use]
    pub const fn of(frac_bits: u32) -> Self {
        Self { frac_bits }
    }

    /// Bits dropped from weight times colour: the product of 20 and 18 bits must fit 31, and 24
    /// fraction bits are enough.
    pub fn shift(self) -> u32 {
        (self.frac_bits + TRANSMITTANCE.frac_bits())
            .saturating_sub(24)
            .max(7)
    }

    /// Fraction bits of a pixel's colour: 13 to 24, 20 or more for colours with
    /// at least 7 fraction bits.
    pub fn pixel_bits(self) -> u32 {
        self.frac_bits + TRANSMITTANCE.frac_bits() - self.shift()
    }
}

/// Fraction bits of a pixel's sums for colours of `colour_bits` fraction bits.
pub fn pixel_bits(colour_bits: u32) -> u32 {
    ColourScale::of(colour_bits).pixel_bits()
}
