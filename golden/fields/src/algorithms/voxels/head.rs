//! Shading of a voxel grid: stored density, and colours that are constant or linear in the
//! direction.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_march::{Head, Lanes, MarchError, Opacities, Transparent};
use potamoi_reference::Product;

use super::formats::{DIRECTION_BITS, Formats, STEP_BITS};
use super::grid::Layout;

/// The feature computation of stored densities and colours.
///
/// | step | operation | result |
/// |---|---|---|
/// | density | ReLU | its own format |
/// | s | multiply by the step, floor | U4.G, G = `one_minus_frac_bits` |
/// | alpha | 1 - exp(-s) | U0.F, exactly 0 at 0 |
/// | colour | ReLU of each channel | its own format |
///
/// A colour that is linear in the viewing direction takes one exact sum of four 16-bit products a
/// channel, rounded half-even, in the MAC array.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stored {
    pub(super) layout: Layout,
    pub(super) formats: Formats,
    /// Step in voxel edges, as [`Formats::step_code`].
    pub(super) step: i32,
    pub(super) transparent: Transparent,
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
    ) -> Result<Opacities<'f>, MarchError> {
        let channels = self.channels();
        let density = features.chunks_exact(channels).map(|f| i32::from(f[0]));
        let density: Vec<i32> = density.collect();
        let shift = self.formats.depth_shift() as u8;
        Ok(Opacities {
            alpha: lanes.opacities(&density, self.step, shift, self.transparent)?,
            kept: Cow::Borrowed(features),
        })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        directions: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let samples = kept.chunks_exact(self.channels());
        let mut colour = Vec::with_capacity(3 * samples.len());
        match self.layout {
            Layout::Constant => {
                for f in samples {
                    colour.extend(f[1..].iter().map(|c| i32::from(*c)));
                }
            }
            Layout::Linear => {
                for (f, d) in samples.zip(directions.as_chunks::<3>().0) {
                    colour.extend(f[1..].as_chunks::<4>().0.iter().map(|c| towards(*c, *d)));
                }
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
