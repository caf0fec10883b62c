//! Feature computation in the hardware's formats: what makes opacity and colour
//! of gathered features.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::units::{OpCode, VectorOp};

use crate::error::MarchError;
use crate::transmittance::TRANSMITTANCE;
use crate::work::Work;
use potamoi_reference::{Product, Units};

/// What follows gathering, for samples in batches.
pub trait Head: Sync {
    /// Feature codes of a sample.
    fn channels(&self) -> usize;

    /// Fraction bits of opacities, which are below 1.
    fn alpha_bits(&self) -> u32;

    /// Fraction bits of colours.
    fn colour_bits(&self) -> u32;

    /// Opacity codes, and weight codes with 20 fraction bits, up to which a
    /// sample is left out: 0 where only nothing is.
    fn least(&self) -> [i32; 2] {
        [0, 0]
    }

    /// Fraction bits of transmittances that are carried, 20 at most.
    fn transmittance_bits(&self) -> u32 {
        TRANSMITTANCE.frac_bits()
    }

    /// Codes of a sample that colours are made of: its features, unless opacity
    /// leaves something else.
    fn kept(&self) -> usize {
        self.channels()
    }

    /// Codes that stand for a direction.
    fn direction_codes(&self) -> usize;

    /// Operations of the vector unit that opacities and colours take; compositing multiplies
    /// besides.
    fn operations(&self) -> Vec<OpCode>;

    /// Appends the codes of a unit direction in the world.
    fn encode(&self, direction: DVec3, out: &mut Vec<i16>);

    /// The opacity of each sample.
    ///
    /// # Errors
    /// A unit that fails.
    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError>;

    /// Three colour codes, 0 and up, of each sample, whose kept codes and whose
    /// directions' codes follow one another.
    ///
    /// # Errors
    /// A unit that fails.
    fn colours(
        &self,
        kept: &[i16],
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError>;
}

/// What a head makes of features first.
pub struct Opacities<'f> {
    /// Codes of [`Head::alpha_bits`] fraction bits, one a sample.
    pub alpha: Vec<i32>,
    /// [`Head::kept`] codes a sample.
    pub kept: Cow<'f, [i16]>,
}

/// What another head makes of features, without colours: rays stop where they
/// would.
pub struct OpacityAlone<'h>(pub &'h dyn Head);

/// What another head makes of a part of a direction's codes, the others being 0.
pub struct Facing<'h> {
    /// The other head.
    pub head: &'h dyn Head,
    /// Codes that are kept, from the first on.
    pub kept: usize,
}

impl Head for Facing<'_> {
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

    fn transmittance_bits(&self) -> u32 {
        self.head.transmittance_bits()
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
        kept: &[i16],
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

    fn transmittance_bits(&self) -> u32 {
        self.0.transmittance_bits()
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

    fn colours(&self, kept: &[i16], _: &[i16], _: &mut Lanes<'_>) -> Result<Vec<i32>, MarchError> {
        Ok(vec![0; 3 * kept.len()])
    }
}

/// The vector unit, and the count of what it was given.
pub struct Lanes<'u> {
    /// The units.
    pub units: &'u mut dyn Units,
    /// What they were given so far.
    pub work: &'u mut Work,
}

impl Lanes<'_> {
    /// One operation, element by element.
    ///
    /// # Errors
    /// A unit that fails.
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

    /// One operation with the same second operand throughout.
    ///
    /// # Errors
    /// A unit that fails.
    pub fn compute_with(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: i32,
    ) -> Result<Vec<i32>, MarchError> {
        self.compute(op, a, &vec![b; a.len()])
    }

    /// `1 - exp(-s)` of densities, 0 where they are negative; s is density times step less its last
    /// `shift` bits, cut off.
    ///
    /// # Errors
    /// A unit that fails.
    pub fn opacities(
        &mut self,
        density: &[i32],
        step: i32,
        shift: u8,
    ) -> Result<Vec<i32>, MarchError> {
        let positive = self.compute_with(VectorOp::new(OpCode::Relu), density, 0)?;
        let to_depth = VectorOp {
            code: OpCode::Multiply,
            shift,
            rounding: Rounding::Floor,
        };
        let depth = self.compute_with(to_depth, &positive, step)?;
        self.compute_with(VectorOp::new(OpCode::OneMinusExp), &depth, 0)
    }

    /// Counts work of the MAC array: a product, and sums of it that were held at an
    /// end of their format.
    pub fn multiply(&mut self, product: Product, held: u64) {
        if product.operations() > 0 {
            self.units.multiplied(product);
            self.work.products += product.operations();
        }
        self.work.held += held;
    }

    /// Counts sines and cosines of features, which a table next to the MAC
    /// array gives.
    pub fn count_waves(&mut self, waves: u64) {
        self.work.waves += waves;
    }
}
