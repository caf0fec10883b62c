//! Every input of the exponential through the Verilated unit.

use std::fmt::Write as _;

use potamoi_cycles::Stalls;
use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput};
use potamoi_formats::fixed::Format;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::exact_exponential::{ExactExponential, ExpError};
use potamoi_reference::widths::{budget, straightness, truncation};
use potamoi_rtl::{VectorBatch, VectorRun, VectorUnit};
use potamoi_units::vector_unit::error_bound;
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;

/// Width of an exhaustively swept input, in bits.
const INPUT_BITS: u32 = 16;

/// Results of the exponential on the Verilated unit for every input.
pub struct ExponentialSweep {
    /// Errors and clocks.
    pub report: ExponentialReport,
    /// Results by input code.
    results: Vec<i32>,
    /// Cycles from accepting an input's vector to its results, by input code.
    cycles: Vec<u64>,
}

impl ExponentialSweep {
    /// Sweeps all inputs of U3.13 through the vector unit of a configuration.
    ///
    /// # Errors
    /// A configuration whose exponential is not the splats' one of U3.13; Verilog that cannot be
    /// built or run.
    pub fn run(config: &Config) -> Result<Self, ExploreError> {
        check(config)?;
        let exp = &config.vu.exp;
        let unit = VectorUnit::build(config)?;
        let codes: Vec<i32> = (0..1 << INPUT_BITS).collect();
        let zeros = vec![0; codes.len()];
        let batch = VectorBatch {
            op: VectorOp::new(OpCode::Exp),
            a: &codes,
            b: &zeros,
        };
        let run = unit.run(&[batch], &Stalls::NONE, 0)?;
        let reference = ExactExponential::in_base(exp.input, exp.base)
            .map_err(|e| ExploreError::Inconclusive(e.to_string()))?;
        let error = reference.measure(exp.output_bits, |u| {
            run.results.get(u as usize).copied().unwrap_or_default()
        });
        let lanes = config.vu.lanes as usize;
        let latency = |code: usize| {
            run.vectors
                .get(code / lanes)
                .map_or(0, |(from, to)| to - from)
        };
        Ok(Self {
            report: ExponentialReport::new(config, codes.len(), &error, &run)?,
            cycles: (0..codes.len()).map(latency).collect(),
            results: run.results,
        })
    }

    /// Every input with its result and cycles as CSV: `u_code,y_code,cycles`.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from("u_code,y_code,cycles\n");
        for (u, (y, cycles)) in self.results.iter().zip(&self.cycles).enumerate() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{u},{y},{cycles}");
        }
        text
    }
}

/// Errors and clocks of a configuration's exponential. Errors are in ulp of the result,
/// `2^-output_bits`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ExponentialReport {
    /// Hash of the configuration, 12 hexadecimal digits.
    pub configuration: String,
    /// Number of inputs, all of the format.
    pub inputs: usize,
    /// "restoring", "piecewise" or "radix-4".
    pub form: ExpForm,
    /// Base of the exponential.
    pub base: ExpBase,
    /// Piece table of the piecewise form.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pieces: Option<PieceTable>,
    /// Whether it stops once its bits are complete.
    pub early_out: bool,
    /// Iterations; with early termination the largest number.
    pub iterations: u32,
    /// Whether the final rest is multiplied in.
    pub tail: bool,
    /// Fraction bits of the accumulator.
    pub accumulator_bits: u32,
    /// Fraction bits of the constants.
    pub constant_bits: u32,
    /// Initial accumulator value, in its last place.
    pub offset: i32,
    /// Fraction bits of the result.
    pub output_bits: u32,
    /// Largest error magnitude.
    pub max_ulp: f64,
    /// Mean error magnitude.
    pub mean_ulp: f64,
    /// Root of the mean squared error.
    pub rms_ulp: f64,
    /// Mean error (bias).
    pub bias_ulp: f64,
    /// Input code with the largest error.
    pub worst_code: i32,
    /// Number of results that are not the nearest code.
    pub misrounded: u32,
    /// Whether results never rise with the input.
    pub monotone: bool,
    /// Bound of the truncation error: stopping after n iterations, or linear pieces.
    pub truncation_ulp: f64,
    /// Bound of the sum of all rounding errors.
    pub budget_ulp: f64,
    /// Error bound by analysis of the netlist.
    pub netlist_ulp: Option<f64>,
    /// Part of that bound that is due to dropped bits.
    pub netlist_dropped_ulp: Option<f64>,
    /// Cycles from accepting a vector to its results.
    pub latency_cycles: u64,
    /// Cycles from one vector to the next.
    pub interval_cycles: f64,
    /// Lanes of the unit, with one exponential each.
    pub lanes: u32,
    /// Throughput in the steady state, over all lanes.
    pub exponentials_per_cycle: f64,
}

/// Parameters of the piecewise form.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PieceTable {
    /// Number of pieces.
    pub pieces: u32,
    /// Size of the table in bits.
    pub table_bits: u32,
    /// Partial-product bits of the slope's multiplier.
    pub slope_product_bits: u32,
    /// Partial-product bits of the multiplier by log2 e.
    pub scale_product_bits: u32,
}

impl ExponentialReport {
    fn new(
        config: &Config,
        inputs: usize,
        error: &ExpError,
        run: &VectorRun,
    ) -> Result<Self, ExploreError> {
        let (exp, lanes) = (&config.vu.exp, config.vu.lanes);
        let (engine, netlist) = (exp.engine(), error_bound(config, OpCode::Exp)?);
        let (first, last) = (run.vectors.first(), run.vectors.last());
        let span = last.zip(first).map_or(0, |(last, first)| last.0 - first.0);
        let interval = span as f64 / (run.vectors.len().max(2) - 1) as f64;
        // With an early out it is an average.
        let interval = (interval * 1e3).round() / 1e3;
        Ok(Self {
            configuration: config.hash(),
            inputs,
            form: exp.form,
            base: exp.base,
            pieces: PieceTable::of(exp),
            early_out: exp.early_out,
            iterations: exp.iterations,
            tail: exp.tail,
            accumulator_bits: engine.accumulator_bits,
            constant_bits: engine.constant_bits,
            offset: engine.offset,
            output_bits: exp.output_bits,
            max_ulp: error.max_ulp,
            mean_ulp: error.mean,
            rms_ulp: error.rms,
            bias_ulp: error.bias,
            worst_code: error.worst_code,
            misrounded: error.misrounded,
            monotone: error.monotone,
            truncation_ulp: approximation(exp),
            budget_ulp: budget(exp),
            netlist_ulp: netlist.map(|bound| bound.ulp),
            netlist_dropped_ulp: netlist.map(|bound| bound.dropped),
            latency_cycles: first.map_or(0, |(from, to)| to - from),
            interval_cycles: interval,
            lanes,
            exponentials_per_cycle: f64::from(lanes) / interval.max(1.0),
        })
    }
}

impl PieceTable {
    fn of(exp: &ExpConfig) -> Option<Self> {
        let (widths, engine) = (exp.piece_widths(), exp.engine());
        (exp.form == ExpForm::Piecewise).then(|| Self {
            pieces: exp.pieces,
            table_bits: widths.table_bits(&engine),
            slope_product_bits: widths.slope_product_bits(&engine),
            scale_product_bits: widths.scale_product_bits(exp.input.width()),
        })
    }
}

/// Error of the approximation: truncation, or linear pieces.
fn approximation(exp: &ExpConfig) -> f64 {
    match exp.form {
        ExpForm::Piecewise => straightness(exp.pieces, exp.output_bits),
        _ => truncation(exp.resolved_bits(), exp.tail, exp.output_bits),
    }
}

/// Checks that the sweep covers exp(-u) in the format of splats.
fn check(config: &Config) -> Result<(), ExploreError> {
    let exp = &config.vu.exp;
    let refuse = |field: &str, value: String, expected: &str| {
        Err(ExploreError::Refused(format!(
            "`{field}` is {value}: expected {expected}"
        )))
    };
    if !config.vu.ops.contains(&OpCode::Exp) {
        return refuse("vu.ops", OpCode::list(&config.vu.ops), "\"exp\" among them");
    }
    if exp.form == ExpForm::Literal {
        let form = "literal".to_owned();
        return refuse("vu.exp.form", form, "a form that is right below 0");
    }
    if exp.output != ExpOutput::Alpha {
        let output = format!("{:?}", exp.output);
        return refuse("vu.exp.output", output, "the alpha configuration");
    }
    if exp.input != Format::unsigned(3, 13) {
        return refuse(
            "vu.exp.input",
            exp.input.to_string(),
            "U3.13, whose inputs the table lists",
        );
    }
    Ok(())
}
