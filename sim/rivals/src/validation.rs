//! Published figures, computed again on the workload that is published for them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::constant::Origin;
use crate::estimate::{Estimate, EstimateError, Seconds, frame_of, on_gpu};
use crate::rival::{Figure, Rival, Source};
use crate::trace::Trace;

/// The factor within which a figure counts as reproduced.
pub const WITHIN: f64 = 2.0;

/// A figure computed again.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Check {
    /// What it is.
    pub what: String,
    /// Where it is published.
    pub source: String,
    /// The published value.
    pub published: f64,
    /// The computed value, from the least to the most.
    pub computed: [f64; 2],
    /// The computed over the published value.
    pub ratio: [f64; 2],
    /// Whether the figure stands in the rival's own publication.
    pub is_own: bool,
    /// What the check assumes, of counts and of the GPU beside it.
    pub assumed: Vec<String>,
}

impl Check {
    /// Whether both ends lie within twice and half of the published value.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.ratio
            .iter()
            .all(|own| (1.0 / WITHIN..=WITHIN).contains(own))
    }

    /// Whether it validates a rival: a figure of its own publication, on a workload without assumed counts.
    #[must_use]
    pub fn validates(&self) -> bool {
        self.is_within() && self.is_own && self.assumed.is_empty()
    }
}

/// Whether a rival is validated.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// By this figure.
    Validated(Check),
    /// For this reason not.
    Not(String),
}

impl Rival {
    /// Computes all figures of the rival's file again.
    ///
    /// # Errors
    /// A figure lacks counts that its rival takes.
    pub fn checks(&self) -> Result<Vec<Check>, EstimateError> {
        self.figures.iter().map(|own| self.check(own)).collect()
    }

    fn check(&self, figure: &Figure) -> Result<Check, EstimateError> {
        let counts = figure.counts.iter();
        let trace = Trace {
            scene: figure.what.clone(),
            class: figure.class,
            counts: counts
                .filter_map(|(name, own)| Some((name.clone(), own.value?)))
                .collect(),
        };
        let own = Estimate::of(self, &trace)?.frame;
        let computed = match &figure.beside {
            None => own.rates(),
            Some(gpu) => {
                let frame = frame_of(&gpu.device, &gpu.program, &gpu.counts, &trace)?;
                let gpu = on_gpu(&gpu.device, &frame)?;
                speed_ups(gpu, own)
            }
        };
        let published = figure.published.value.ok_or(EstimateError::Unknown)?;
        Ok(Check {
            what: figure.what.clone(),
            source: figure.published.origin.text().to_owned(),
            published,
            computed,
            ratio: computed.map(|own| own / published),
            is_own: figure.is_own,
            assumed: assumed(figure),
        })
    }

    /// Whether a figure of the rival's own publication is reproduced.
    ///
    /// # Errors
    /// As [`Rival::checks`].
    pub fn verdict(&self) -> Result<Verdict, EstimateError> {
        let checks = self.checks()?;
        if let Some(own) = checks.iter().find(|own| own.validates()) {
            return Ok(Verdict::Validated(own.clone()));
        }
        let reason = |own: &Check| {
            let [low, high] = own.ratio.map(|own| format!("{own:.2}"));
            let times = match low == high {
                true => low,
                false => format!("{low} to {high}"),
            };
            let but = if !own.is_within() {
                "beyond twice"
            } else if !own.is_own {
                "of another publication"
            } else {
                "on assumed counts"
            };
            format!("{}: {times} times, {but}", own.what)
        };
        let reasons: Vec<_> = checks.iter().map(reason).collect();
        Ok(Verdict::Not(match reasons.is_empty() {
            true => "no figure is published with its workload".to_owned(),
            false => reasons.join("; "),
        }))
    }
}

/// The least and the most that a GPU's time over a rival's may be.
fn speed_ups(gpu: Seconds, own: Seconds) -> [f64; 2] {
    [gpu.fewest / own.most, gpu.most / own.fewest]
}

fn assumed(figure: &Figure) -> Vec<String> {
    let gpu = figure.beside.iter().flat_map(|own| &own.counts);
    let constants = gpu.filter_map(|(name, source)| match source {
        Source::Constant(own) => Some((name, own)),
        Source::Count(_) => None,
    });
    let all = figure.counts.iter().chain(constants);
    let assumed = all.filter_map(|(name, own)| match &own.origin {
        Origin::Assumed(why) => Some(format!("{name}: {why}")),
        Origin::Source(_) | Origin::Unknown(_) => None,
    });
    assumed.collect()
}
