//! Times of a rival's stages on a trace.

use potamoi_gpu::programs::{CountError, Counts, program};
use potamoi_gpu::{Device, DeviceError, Frame, Overlap as OfKernels};
use schemars::JsonSchema;
use serde::Serialize;

use crate::constant::Constant;
use crate::rival::{Demand, Overlap, Rival, Source, Term};
use crate::trace::Trace;

/// Why a rival has no time on a trace.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    /// It renders another class of algorithms.
    #[error("made for {renders}, not {class}")]
    Class {
        /// The classes that it renders.
        renders: String,
        /// The trace's class.
        class: &'static str,
    },
    /// A count is missing.
    #[error("the trace lacks the count `{0}`")]
    Missing(String),
    /// No stage has a time: their constants are unknown.
    #[error("the constants of all its stages are unknown")]
    Unknown,
    /// A device is refused.
    #[error(transparent)]
    Device(#[from] Box<DeviceError>),
    /// Counts of a program are refused.
    #[error(transparent)]
    Counts(#[from] Box<CountError>),
}

/// Seconds from the fewest to the most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Seconds {
    /// Where work may be skipped, and demands of a GPU's kernel overlap.
    pub fewest: f64,
    /// Where nothing is skipped, and no demands of a GPU's kernel overlap.
    pub most: f64,
}

impl Seconds {
    /// Frames a second, the lower first.
    #[must_use]
    pub fn rates(self) -> [f64; 2] {
        [1.0 / self.most, 1.0 / self.fewest]
    }
}

/// A rival on a trace.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// Seconds of a frame.
    pub frame: Seconds,
    /// Seconds of each stage by name; `None` where a constant is unknown.
    pub stages: Vec<(String, Option<Seconds>)>,
    /// The longest stage at the most seconds.
    pub bottleneck: String,
    /// Millijoules of the accelerator, power times time, from the fewest to the most; `None` where the power is
    /// unknown.
    pub mj: Option<[f64; 2]>,
}

impl Estimate {
    /// Evaluates a rival on a trace.
    ///
    /// # Errors
    /// The rival renders another class, or the trace lacks a count that it takes.
    pub fn of(rival: &Rival, trace: &Trace) -> Result<Self, EstimateError> {
        if !rival.classes.contains(&trace.class) {
            let names: Vec<_> = rival.classes.iter().map(|own| own.name()).collect();
            return Err(EstimateError::Class {
                renders: names.join(" and "),
                class: trace.class.name(),
            });
        }
        let mut stages = vec![];
        for stage in &rival.stages {
            let time = of_stage(&stage.demand, rival.clock_ghz.value, trace)?;
            stages.push((stage.name.clone(), time));
        }
        let known = || stages.iter().filter_map(|(_, own)| *own);
        let of = |pick: fn(Seconds) -> f64| match rival.overlap {
            Overlap::Longest => known().map(pick).fold(0.0, f64::max),
            Overlap::Sum => known().map(pick).sum(),
        };
        let frame = Seconds {
            fewest: of(|own| own.fewest),
            most: of(|own| own.most),
        };
        let most = |own: &Option<Seconds>| own.map_or(0.0, |own| own.most);
        let longest = stages
            .iter()
            .max_by(|a, b| most(&a.1).total_cmp(&most(&b.1)));
        let bottleneck = longest.map(|(name, _)| name.clone());
        if frame.fewest <= 0.0 {
            return Err(EstimateError::Unknown);
        }
        let power = rival.power_w.value;
        Ok(Self {
            frame,
            bottleneck: bottleneck.unwrap_or_default(),
            stages,
            mj: power.map(|watts| [frame.fewest, frame.most].map(|own| 1e3 * watts * own)),
        })
    }
}

/// The time of a stage; `None` where a constant is unknown.
fn of_stage(
    demand: &Demand,
    clock_ghz: Option<f64>,
    trace: &Trace,
) -> Result<Option<Seconds>, EstimateError> {
    match demand {
        Demand::Units { work, units, rate } => {
            let rate = product(&[units, rate]).zip(clock_ghz);
            over(work, rate.map(|(rate, ghz)| rate * ghz * 1e9), trace)
        }
        Demand::Bytes { work, bandwidth } => {
            over(work, bandwidth.value.map(|own| own * 1e9), trace)
        }
        Demand::Gpu {
            device,
            program,
            kernels,
            counts,
        } => {
            let mut frame = frame_of(device, program, counts, trace)?;
            frame
                .kernels
                .retain(|own| kernels.iter().any(|name| name == own.name));
            Ok(Some(on_gpu(device, &frame)?))
        }
    }
}

fn product(of: &[&Constant]) -> Option<f64> {
    of.iter().map(|own| own.value).product()
}

/// Work over a rate.
fn over(work: &[Term], rate: Option<f64>, trace: &Trace) -> Result<Option<Seconds>, EstimateError> {
    let (mut fewest, mut most) = (Some(0.0), Some(0.0));
    for term in work {
        let all = count(trace, &term.count)?;
        let least = term.least.as_ref().and_then(|name| trace.counts.get(name));
        let add = |sum: Option<f64>, own: f64| Some(sum? + own * term.times.value?);
        fewest = add(fewest, least.copied().unwrap_or(all));
        most = add(most, all);
    }
    let seconds = |work: Option<f64>| Some(work? / rate?);
    let both = seconds(fewest).zip(seconds(most));
    Ok(both.map(|(fewest, most)| Seconds { fewest, most }))
}

fn count(trace: &Trace, name: &str) -> Result<f64, EstimateError> {
    let found = trace.counts.get(name).copied();
    found.ok_or_else(|| EstimateError::Missing(name.to_owned()))
}

/// A program's frame at a trace's counts.
pub(crate) fn frame_of(
    device: &str,
    named: &str,
    counts: &[(String, Source)],
    trace: &Trace,
) -> Result<Frame, EstimateError> {
    let device = Device::builtin(device).map_err(Box::new)?;
    let mut all = Counts::new();
    for (name, source) in counts {
        let value = match source {
            Source::Count(own) => count(trace, own)?,
            Source::Constant(own) => own.value.ok_or(EstimateError::Unknown)?,
        };
        all.insert(name.clone(), value);
    }
    let program = program(named).map_err(Box::new)?;
    Ok(program.frame(&all, &device).map_err(Box::new)?)
}

/// A frame's time at both bounds of its kernels.
pub(crate) fn on_gpu(device: &str, frame: &Frame) -> Result<Seconds, EstimateError> {
    let device = Device::builtin(device).map_err(Box::new)?;
    let at = |overlap| frame.time(&device, overlap, None).seconds;
    Ok(Seconds {
        fewest: at(OfKernels::Whole),
        most: at(OfKernels::None),
    })
}
