//! Feature computation in the hardware's formats: what makes opacity and colour
//! of gathered features.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};

use super::composite::Work;
use super::error::VoxelError;
use super::formats::{DIRECTION_BITS, Formats, STEP_BITS, TRANSMITTANCE};
use super::grid::Layout;
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
    ) -> Result<Opacities<'f>, VoxelError>;

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
    ) -> Result<Vec<i32>, VoxelError>;
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
    ) -> Result<Opacities<'f>, VoxelError> {
        self.head.opacities(features, lanes)
    }

    fn colours(
        &self,
        kept: &[i16],
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, VoxelError> {
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
    ) -> Result<Opacities<'f>, VoxelError> {
        let alpha = self.0.opacities(features, lanes)?.alpha;
        let kept = vec![0; alpha.len()].into();
        Ok(Opacities { alpha, kept })
    }

    fn colours(&self, kept: &[i16], _: &[i16], _: &mut Lanes<'_>) -> Result<Vec<i32>, VoxelError> {
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
    pub fn compute(&mut self, op: VectorOp, a: &[i32], b: &[i32]) -> Result<Vec<i32>, VoxelError> {
        let mut out = vec![0; a.len()];
        if !a.is_empty() {
            self.units
                .vector(op, a, b, &mut out)
                .map_err(VoxelError::Unit)?;
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
    ) -> Result<Vec<i32>, VoxelError> {
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
    ) -> Result<Vec<i32>, VoxelError> {
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

/// Density and colours that are stored as they are, or linear in the viewing
/// direction.
///
/// | step | operation | result |
/// |---|---|---|
/// | density | ReLU | its own format |
/// | s | multiply by the step, floor | U4.G, G = `one_minus_frac_bits` |
/// | alpha | 1 - exp(-s) | U0.F, exactly 0 at 0 |
/// | colour | ReLU of each channel | its own format |
///
/// Colours that are linear in the viewing direction take one exact sum of four
/// 16-bit products a channel, rounded half-even: work of the MAC array.
#[derive(Debug, Clone, Copy)]
pub struct Stored {
    pub(crate) layout: Layout,
    pub(crate) formats: Formats,
    /// In voxel edges, as [`Formats::step_code`].
    pub(crate) step: i32,
    /// Whether colours that are linear in the direction are seen from it.
    pub directions: bool,
    pub(crate) transmittance_bits: u32,
}

impl Head for Stored {
    fn channels(&self) -> usize {
        self.layout.channels()
    }

    fn alpha_bits(&self) -> u32 {
        self.formats.alpha.frac_bits()
    }

    fn colour_bits(&self) -> u32 {
        self.formats.colour.frac_bits()
    }

    fn transmittance_bits(&self) -> u32 {
        self.transmittance_bits
    }

    fn direction_codes(&self) -> usize {
        3
    }

    fn operations(&self) -> Vec<OpCode> {
        vec![OpCode::Relu, OpCode::Multiply, OpCode::OneMinusExp]
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<i16>) {
        let one = f64::from(1u32 << DIRECTION_BITS);
        out.extend((direction * one).to_array().map(|v| v.round() as i16));
    }

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, VoxelError> {
        let channels = self.channels();
        let density = features.chunks_exact(channels).map(|f| i32::from(f[0]));
        let density: Vec<i32> = density.collect();
        let shift = self.formats.depth_shift() as u8;
        Ok(Opacities {
            alpha: lanes.opacities(&density, self.step, shift)?,
            kept: Cow::Borrowed(features),
        })
    }

    fn colours(
        &self,
        kept: &[i16],
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, VoxelError> {
        let samples = kept.chunks_exact(self.channels());
        let mut colour = Vec::with_capacity(3 * samples.len());
        match self.layout {
            Layout::Constant => {
                for f in samples {
                    colour.extend(f[1..].iter().map(|c| i32::from(*c)));
                }
            }
            Layout::Linear => {
                if self.directions {
                    for (f, d) in samples.zip(directions.as_chunks::<3>().0) {
                        colour.extend(f[1..].as_chunks::<4>().0.iter().map(|c| towards(*c, *d)));
                    }
                } else {
                    let constants = |f: &[i16]| [1, 5, 9].map(|i| i32::from(f[i]));
                    colour.extend(samples.flat_map(constants));
                }
                // The array takes them in any case: what is modelled is the layout's.
                let sums = Product {
                    rows: colour.len() as u64,
                    depth: 4,
                    columns: 1,
                };
                lanes.multiply(sums, 0);
            }
        }
        lanes.compute_with(VectorOp::new(OpCode::Relu), &colour, 0)
    }
}

/// `c0 + c1 x + c2 y + c3 z`, exact, then rounded to the coefficients' format.
fn towards(c: [i16; 4], d: [i16; 3]) -> i32 {
    let sum = (i64::from(c[0]) << DIRECTION_BITS)
        + (1..4)
            .map(|i| i64::from(c[i]) * i64::from(d[i - 1]))
            .sum::<i64>();
    // Below 2^18: four codes of 16 bits times at most 1.
    round_shift(i128::from(sum), DIRECTION_BITS, Rounding::HalfEven) as i32
}

const _: () = assert!(STEP_BITS < 28, "a step of 8 voxels must fit 31 bits");
