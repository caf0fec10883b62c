//! Shading in the hardware's formats: opacity and colour from gathered features.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::config::{Config, VuSamples};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use crate::error::MarchError;
use crate::work::Work;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::{Product, Units};

/// Factors of all elements from here on go first.
const LARGE_FACTOR: u32 = 1 << 24;

/// The shading stage that follows gathering, for batches of samples.
pub trait Head: Sync {
    /// Feature codes a sample.
    fn channels(&self) -> usize;

    /// Fraction bits of opacities. Opacities are below 1.
    fn alpha_bits(&self) -> u32;

    /// Fraction bits of colours.
    fn colour_bits(&self) -> u32;

    /// Thresholds of opacity codes and of weight codes (20 fraction bits): samples up to them are
    /// skipped. 0 skips only empty samples.
    fn least(&self) -> [i32; 2] {
        [0, 0]
    }

    /// Codes a sample that the colour stage reads: by default its features.
    fn kept(&self) -> usize {
        self.channels()
    }

    /// Codes a direction.
    fn direction_codes(&self) -> usize;

    /// Vector operations of the opacity and colour stages; compositing adds its multiplications.
    fn operations(&self) -> Vec<OpCode>;

    /// Appends the codes of a unit direction in world coordinates.
    fn encode(&self, direction: DVec3, out: &mut Vec<i16>);

    /// Opacities of the samples, in order.
    ///
    /// # Errors
    /// A unit fails.
    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError>;

    /// Colours of the samples, three codes of at least 0 each, from the kept codes and the codes of the
    /// direction of each. The kept codes are given away, so that they need no memory beside later layers.
    ///
    /// # Errors
    /// A unit fails.
    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError>;
}

/// The results of the opacity stage.
pub struct Opacities<'f> {
    /// Opacity codes with [`Head::alpha_bits`] fraction bits, one a sample.
    pub alpha: Vec<i32>,
    /// [`Head::kept`] codes a sample.
    pub kept: Cow<'f, [i16]>,
}

/// Wraps a head to compute opacities without colours, so that rays stop at the same samples.
pub struct OpacityAlone<'h>(pub &'h dyn Head);

/// Wraps a head and sets all but the first codes of a direction to 0.
pub struct TruncatedDirections<'h> {
    /// The wrapped head.
    pub head: &'h dyn Head,
    /// Number of codes kept, from the first on.
    pub kept: usize,
}

impl Head for TruncatedDirections<'_> {
    fn channels(&self) -> usize {
        self.head.channels()
    }

    fn alpha_bits(&self) -> u32 {
        self.head.alpha_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.head.colour_bits()
    }

    fn least(&self) -> [i32; 2] {
        self.head.least()
    }

    fn kept(&self) -> usize {
        self.head.kept()
    }

    fn direction_codes(&self) -> usize {
        self.head.direction_codes()
    }

    fn operations(&self) -> Vec<OpCode> {
        self.head.operations()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let codes = self.head.direction_codes();
        if self.kept == 0 {
            out.resize(out.len() + codes, 0);
            return;
        }
        let from = out.len();
        self.head.encode(direction, out);
        out[from + self.kept.min(codes)..].fill(0);
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        self.head.opacities(features, lanes)
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        self.head.colours(kept, directions, lanes)
    }
}

impl Head for OpacityAlone<'_> {
    fn channels(&self) -> usize {
        self.0.channels()
    }

    fn alpha_bits(&self) -> u32 {
        self.0.alpha_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.0.colour_bits()
    }

    fn least(&self) -> [i32; 2] {
        self.0.least()
    }

    fn kept(&self) -> usize {
        1
    }

    fn operations(&self) -> Vec<OpCode> {
        self.0.operations()
    }

    fn direction_codes(&self) -> usize {
        0
    }

    fn encode(&self, _: DVec3, _: &mut Vec<i16>) {}

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let alpha = self.0.opacities(features, lanes)?.alpha;
        let kept = vec![0; alpha.len()].into();
        Ok(Opacities { alpha, kept })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        _: &[i16],
        _: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        Ok(vec![0; 3 * kept.len()])
    }
}

/// Optical depths whose opacity is 0 and need not be computed: up to a code of `one_minus_frac_bits`, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transparent(Option<i32>);

impl Transparent {
    /// All opacities are computed.
    pub const NONE: Self = Self(None);

    /// Those that a configuration leaves out, where opacities up to `least` are taken for 0.
    #[must_use]
    pub fn of(config: &Config, least: i32) -> Self {
        let exp = || ReferenceExponential::new(&config.vu.exp);
        match config.vu.samples {
            VuSamples::All => Self::NONE,
            VuSamples::ThatMayCount => Self(Some(exp().largest_depth(least))),
        }
    }

    fn has(self, depth: i32) -> bool {
        self.0.is_some_and(|largest| depth <= largest)
    }
}

/// Access to the vector unit, with counts of its work.
pub struct Lanes<'u> {
    /// The units.
    pub units: &'u mut dyn Units,
    /// Work so far.
    pub work: &'u mut Work,
}

impl Lanes<'_> {
    /// Computes one operation, element by element.
    ///
    /// # Errors
    /// A unit fails.
    pub fn compute(&mut self, op: VectorOp, a: &[i32], b: &[i32]) -> Result<Vec<i32>, MarchError> {
        let mut out = vec![0; a.len()];
        if !a.is_empty() {
            self.units
                .vector(op, a, b, &mut out)
                .map_err(MarchError::Unit)?;
            *self.work.elements.entry(op.code).or_default() += a.len() as u64;
        }
        Ok(out)
    }

    /// Computes one operation with the same second operand for every element.
    ///
    /// # Errors
    /// A unit fails.
    pub fn compute_with(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: i32,
    ) -> Result<Vec<i32>, MarchError> {
        let all = vec![b; a.len()];
        // A product is the same either way round, and lanes may have the narrower factor second.
        let swapped = op.code == OpCode::Multiply && b.unsigned_abs() >= LARGE_FACTOR;
        let [first, second] = if swapped { [&*all, a] } else { [a, &*all] };
        self.compute(op, first, second)
    }

    /// `1 - exp(-s)` of optical depths, 0 or more; those that are known to be transparent are not sent to the
    /// unit.
    ///
    /// # Errors
    /// A unit fails.
    pub fn one_minus_exp(
        &mut self,
        depth: &[i32],
        transparent: Transparent,
    ) -> Result<Vec<i32>, MarchError> {
        let counts = |depth: &i32| !transparent.has(*depth);
        let sent: Vec<i32> = depth.iter().copied().filter(counts).collect();
        let mut computed = self
            .compute_with(VectorOp::new(OpCode::OneMinusExp), &sent, 0)?
            .into_iter();
        let next = |depth| match counts(depth) {
            true => computed.next().unwrap_or_default(),
            false => 0,
        };
        Ok(depth.iter().map(next).collect())
    }

    /// `1 - exp(-s)` of densities, 0 for negative ones; s is density times step without its last
    /// `shift` bits, truncated.
    ///
    /// # Errors
    /// A unit fails.
    pub fn opacities(
        &mut self,
        density: &[i32],
        step: i32,
        shift: u8,
        transparent: Transparent,
    ) -> Result<Vec<i32>, MarchError> {
        let positive = self.compute_with(VectorOp::new(OpCode::Relu), density, 0)?;
        let to_depth = VectorOp {
            code: OpCode::Multiply,
            shift,
            rounding: Rounding::Floor,
        };
        let depth = self.compute_with(to_depth, &positive, step)?;
        self.one_minus_exp(&depth, transparent)
    }

    /// Counts a product of the MAC array and `held` saturated sums of it.
    pub fn multiply(&mut self, product: Product, held: u64) {
        if product.operations() > 0 {
            self.units.multiplied(product);
            self.work.products += product.operations();
        }
        self.work.held += held;
    }

    /// Counts sines and cosines of encoded features, computed by a table next to the MAC array.
    pub fn count_waves(&mut self, waves: u64) {
        self.work.waves += waves;
    }
}
