//! Fixed-point formats of voxel grids and of the arithmetic on samples.

use potamoi_formats::config::{Config, Modes, presets_that};
use potamoi_formats::fixed::{Format, Rounding};
use potamoi_formats::units::OpCode;

use super::grid::Grid;
use potamoi_march::ColourScale;
use potamoi_march::MarchError;

/// Fraction bits of the step.
pub(super) const STEP_BITS: u32 = 24;
/// Fraction bits of a viewing direction.
pub(super) const DIRECTION_BITS: u32 = 14;
/// The formats for a grid and a configuration. All scales are powers of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Formats {
    /// Density codes: optical depth per voxel edge.
    pub density: Format,
    /// Colour coefficient codes.
    pub colour: Format,
    /// Weight fraction bits `W`.
    pub weight_bits: u32,
    /// Optical depth of a sample, the input of `1 - exp(-s)`.
    pub depth: Format,
    /// Opacity of a sample.
    pub alpha: Format,
}

impl Formats {
    /// The finest formats that hold every value of the grid. A refusal of the configuration names the presets
    /// that render grids of as many channels.
    ///
    /// # Errors
    /// The grid's values need more integer bits than the formats have, or the configuration's
    /// units lack an operation.
    pub fn new(grid: &Grid, config: &Config) -> Result<Self, MarchError> {
        let channels = grid.layout().channels();
        if let Some(refused) = Refusal::of(channels, config) {
            let can = presets_that(|preset| Refusal::of(channels, preset).is_none());
            return Err(MarchError::Config {
                field: refused.field,
                value: refused.value,
                expected: format!("{}{can}", refused.expected),
            });
        }
        let exp = &config.vu.exp;
        let largest = |density: bool| {
            let values = grid.features().chunks_exact(channels);
            let picked = values.flat_map(|v| if density { &v[..1] } else { &v[1..] });
            picked.fold(0f32, |m, v| m.max(v.abs()))
        };
        let bits = config.gu.feature_bits;
        // Larger values leave too few fraction bits: 3 of 16 for densities,
        // which are opaque from 16 on, and 7 for colours.
        let density = fit(largest(true), bits, 12);
        let colour = fit(largest(false), bits, 8);
        let (Some(density), Some(colour)) = (density, colour) else {
            return Err(MarchError::Grid {
                field: "features",
                value: format!(
                    "up to {} (density) and {} (colour)",
                    largest(true),
                    largest(false)
                ),
                expected: format!(
                    "densities below 4096 and colours below 256 in {bits}-bit features"
                ),
            });
        };
        Ok(Self {
            density,
            colour,
            weight_bits: config.gu.weight_bits,
            depth: Format::unsigned(4, exp.one_minus_frac_bits),
            alpha: Format::unsigned(0, exp.output_bits),
        })
    }

    /// Number of fraction bits dropped from density times step.
    #[must_use]
    pub(crate) fn depth_shift(&self) -> u32 {
        // At most 24 fraction bits of depth: rules of the configuration.
        (self.density.frac_bits() + STEP_BITS).saturating_sub(self.depth.frac_bits())
    }

    /// Fraction bits of a pixel's colour: 13 to 24, 20 or more for colours with
    /// at least 7 fraction bits.
    #[must_use]
    pub fn pixel_bits(&self) -> u32 {
        ColourScale::of(self.colour.frac_bits()).pixel_bits()
    }

    /// The step, in voxels, as a code with 24 fraction bits.
    #[must_use]
    pub(crate) fn step_code(step: f64) -> i32 {
        (step * f64::from(1u32 << STEP_BITS)).round() as i32
    }
}

/// What a configuration lacks for grids.
struct Refusal {
    field: &'static str,
    value: String,
    expected: String,
}

impl Refusal {
    /// What `config` lacks for a grid of so many channels.
    fn of(channels: usize, config: &Config) -> Option<Self> {
        let needs = |field, value: String, expected: String| {
            Some(Self {
                field,
                value,
                expected,
            })
        };
        for op in [OpCode::Relu, OpCode::Multiply, OpCode::OneMinusExp] {
            if !config.vu.ops.contains(&op) {
                let expected = format!("\"{}\" among the operations", op.name());
                return needs("vu.ops", OpCode::list(&config.vu.ops), expected);
            }
        }
        let eight = potamoi_formats::rit::Vertices::Eight;
        if !config.supported_vertices().contains(&eight) {
            if config.gu.modes == Modes::Unstructured {
                let expected = "entries of vertices: \"both\" or \"structured\"".to_owned();
                return needs("gu.modes", "unstructured".to_owned(), expected);
            }
            let counts: Vec<_> = config.gu.vertices.iter().map(|v| v.count()).collect();
            let expected = "8 among them".to_owned();
            return needs("gu.vertices", format!("{counts:?}"), expected);
        }
        let output_bits = config.vu.exp.output_bits;
        if !(8..=24).contains(&output_bits) {
            let expected = "8 to 24 bits of opacity".to_owned();
            return needs("vu.exp.output_bits", output_bits.to_string(), expected);
        }
        let segments = config.segments(channels);
        if segments > config.gu.segments as usize {
            let expected = format!("{segments} segments for {channels} channels");
            return needs("gu.segments", config.gu.segments.to_string(), expected);
        }
        None
    }
}

/// The finest signed format of `bits` bits that holds the rounded `largest`.
fn fit(largest: f32, bits: u32, most_int_bits: u32) -> Option<Format> {
    (0..=most_int_bits.min(bits - 1))
        .map(|int| Format::signed(int, bits - 1 - int))
        .find(|format| {
            let scaled = f64::from(largest) * 2f64.powi(format.frac_bits() as i32);
            scaled.round_ties_even() <= Format::max(*format) as f64
        })
}

/// The code of a value, which is finite and fits by the choice of format.
pub(crate) fn code(format: Format, value: f32) -> i16 {
    let code = format.quantise(f64::from(value), Rounding::HalfEven);
    code.unwrap_or_default() as i16
}
