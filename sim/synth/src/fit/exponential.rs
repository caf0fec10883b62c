//! Figures of an exponential by itself: as it was synthesised, or from its nearest synthesised relative.

use potamoi_formats::config::Config;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Estimate, Fit, Ratio, ScaledEstimate, Work};
use crate::grid::{GridPoint, is_exponential, is_same_unit};
use crate::{SynthError, UnitKind, scaling};

/// Every clock computes.
const BUSY: Work = Work {
    busy: 1.0,
    channels: 0,
};

/// Where figures come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Origin {
    /// This block was synthesised.
    Synthesised,
    /// A block that differs in numbers alone was, and formulas give the ratio.
    Ratio {
        /// Settings of that block, on one line.
        to: String,
    },
}

/// Figures of an exponential by itself, in which every clock computes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExponentialFigures {
    /// Where they come from.
    pub origin: Origin,
    /// Node of the cells in nanometres.
    pub from_nm: u32,
    /// Area of the cells at that node, in square micrometres.
    pub area_um2_from: f64,
    /// Figures at another node.
    pub scaled: ScaledEstimate,
}

impl Fit {
    /// Figures of the exponential of a configuration by itself: a vector unit of one lane and the
    /// operation exp alone, which `config` has to be. `None` where neither it nor a block that differs
    /// in numbers alone was synthesised, or where no factors to the node are known.
    ///
    /// # Errors
    /// None for the syntheses that come with the program.
    pub fn exponential(
        &self,
        config: &Config,
        node_nm: u32,
    ) -> Result<Option<ExponentialFigures>, SynthError> {
        let node = self.grid().library.node_nm;
        let scaled = node.and_then(|nm| Some((nm, scaling::logic(nm, node_nm)?)));
        let (Some((from_nm, factors)), true) = (scaled, is_exponential(config)) else {
            return Ok(None);
        };
        let Some((origin, estimate)) = self.alone(config, |_| true)? else {
            return Ok(None);
        };
        Ok(Some(ExponentialFigures {
            origin,
            from_nm,
            area_um2_from: estimate.area_um2,
            scaled: estimate.scaled(&factors),
        }))
    }

    /// At the node of the syntheses, from the points that are `known`.
    fn alone(
        &self,
        config: &Config,
        known: impl Fn(&GridPoint) -> bool,
    ) -> Result<Option<(Origin, Estimate)>, SynthError> {
        let unit = UnitKind::Vector;
        let mut nearest: Option<(Ratio, &GridPoint)> = None;
        for point in self.exponentials.iter().filter(|point| known(point)) {
            let own = point.config()?;
            if is_same_unit(&own, config, unit) {
                return Ok(Some((Origin::Synthesised, Estimate::of(point, BUSY))));
            }
            let Some(ratio) = self.ratio(config, &own, unit) else {
                continue;
            };
            let off = |ratio: &Ratio| ratio.area.ln().abs();
            if nearest.is_none_or(|(best, _)| off(&ratio) < off(&best)) {
                nearest = Some((ratio, point));
            }
        }
        Ok(nearest.map(|(ratio, point)| {
            let origin = Origin::Ratio {
                to: settings(&point.config),
            };
            (origin, times(&Estimate::of(point, BUSY), &ratio))
        }))
    }
}

/// Figures times a ratio, without modules.
fn times(known: &Estimate, ratio: &Ratio) -> Estimate {
    let clock_pj = ratio.rest * known.clock_pj;
    let busy = |pj: f64| clock_pj + ratio.work * (pj - known.clock_pj);
    Estimate {
        area_um2: ratio.area * known.area_um2,
        period_ps: ratio.period * known.period_ps,
        clock_pj,
        zero_delay_pj: busy(known.zero_delay_pj),
        with_glitches_pj: busy(known.with_glitches_pj),
        leakage_nw: ratio.leakage * known.leakage_nw,
        modules: vec![],
        ..known.clone()
    }
}

/// The settings of the exponential in a point's text, on one line.
fn settings(text: &str) -> String {
    let own = text.split("[vu.exp]\n").nth(1).unwrap_or(text);
    own.trim_end().replace('\n', ", ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    fn config(exp: &str) -> Config {
        let text = format!("[vu]\nlanes = 1\nops = [\"exp\"]\n[vu.exp]\n{exp}");
        Config::from_toml(&text, "test").unwrap()
    }

    fn of(exp: &str) -> Option<ExponentialFigures> {
        let fit = Fit::checked_in().unwrap();
        fit.exponential(&config(exp), 12).unwrap()
    }

    /// The constants of the iterations, which lanes share, are more than half of a block by itself, so that
    /// straight pieces are the smaller block.
    #[test]
    fn plain_forms_are_synthesised_and_in_order() {
        let [restoring, radix_4, pieces] = [
            "",
            "form = \"radix-4\"\niterations = 8",
            "form = \"piecewise\"\npipelined = true",
        ]
        .map(|exp| of(exp).unwrap());
        for own in [&restoring, &radix_4, &pieces] {
            assert_eq!(own.origin, Origin::Synthesised);
            assert!(own.scaled.area_um2 > own.area_um2_from, "{own:?}");
        }
        assert!(pieces.area_um2_from < restoring.area_um2_from);
        assert!(restoring.area_um2_from < radix_4.area_um2_from);
        assert!(pieces.scaled.with_glitches_pj < restoring.scaled.with_glitches_pj);
    }

    #[test]
    fn other_numbers_are_a_ratio_and_other_shapes_unknown() {
        let eleven = of("iterations = 11").unwrap();
        let Origin::Ratio { to } = &eleven.origin else {
            panic!("{eleven:?}");
        };
        assert!(to.starts_with("iterations = 1"), "{to}");
        let narrow = of("output_bits = 12").unwrap();
        assert!(narrow.scaled.area_um2 < of("").unwrap().scaled.area_um2);
        assert_eq!(of("iterations_per_clock = 2"), None);
        let fit = Fit::checked_in().unwrap();
        let lanes = Config::paper();
        assert_eq!(fit.exponential(&lanes, 12).unwrap(), None);
        assert_eq!(fit.exponential(&config(""), 13).unwrap(), None);
    }

    /// Each block that others differ from in numbers alone, from the nearest of the others. The formulas
    /// have no tail, whose multiplier is the narrower the more iterations come before it.
    #[test]
    fn ratios_are_near_synthesis() {
        let fit = Fit::checked_in().unwrap();
        let (mut worst, mut count) = ([[0.0f64; 3]; 2], 0);
        for point in &fit.exponentials {
            let config = point.config().unwrap();
            let found = fit.alone(&config, |other| other.config != point.config);
            let Some((_, found)) = found.unwrap() else {
                continue;
            };
            let own = Estimate::of(point, BUSY);
            let errors = [
                found.area_um2 / own.area_um2,
                found.period_ps / own.period_ps,
                found.with_glitches_pj / own.with_glitches_pj,
            ]
            .map(|ratio| (ratio - 1.0).abs());
            eprintln!("{}: {errors:.3?}", settings(&point.config));
            let worst = &mut worst[usize::from(config.vu.exp.tail)];
            *worst = [0, 1, 2].map(|i| worst[i].max(errors[i]));
            count += 1;
        }
        eprintln!("{count} blocks, without and with a tail: {worst:.3?}");
        assert!(count >= 8, "{count}");
        let most = [[0.11, 0.08, 0.09], [0.33, 0.09, 0.32]];
        for (error, most) in worst.as_flattened().iter().zip(most.as_flattened()) {
            assert!(error < most, "{worst:?}");
        }
    }
}
