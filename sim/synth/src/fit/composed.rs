//! Units that no formula is of, composed: a synthesised unit that differs in numbers alone, times
//! what formulas give for those numbers in a unit that they are of.

use potamoi_formats::config::Config;
use serde::Serialize;
use serde_json::Value;

use super::{Fit, Work};
use crate::UnitKind;
use crate::grid::{Family, is_same_unit};

/// Figures of a unit over those of another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// Area.
    pub area: f64,
    /// Longest path.
    pub period: f64,
    /// Energy of an idle cycle.
    pub rest: f64,
    /// Energy of a busy cycle above an idle one, with glitches.
    pub work: f64,
    /// Leakage.
    pub leakage: f64,
}

impl Fit {
    /// Figures of a configuration's unit over those of `known`, where they differ in numbers of
    /// their family alone: banks, ports, widths, lanes. Formulas give the ratio for the paper's unit
    /// with the same numbers. `None` where they differ in more.
    #[must_use]
    pub fn ratio(&self, own: &Config, known: &Config, unit: UnitKind) -> Option<Ratio> {
        let family = Family::plain(own, unit)?;
        let numbers = family.numbers();
        let moved = with_numbers(own, known, numbers.clone())?;
        if !is_same_unit(&moved, known, unit) {
            return None;
        }
        let plain = |of: &Config| {
            let mut plain = Config::paper();
            plain.gu.pipelined = of.gu.pipelined;
            plain.vu.exp.pipelined = of.vu.exp.pipelined;
            with_numbers(&plain, of, numbers.clone())
        };
        let [own, known] = [plain(own)?, plain(known)?];
        let channels = Config::paper().gu.banks.into();
        let at = |of: &Config, busy| self.estimate(of, unit, Work { busy, channels }).ok();
        let [rest, rest_known] = [at(&own, 0.0)?, at(&known, 0.0)?];
        let [busy, busy_known] = [at(&own, 1.0)?, at(&known, 1.0)?];
        let work = |busy: f64, rest: f64| busy - rest;
        Some(Ratio {
            area: rest.area_um2 / rest_known.area_um2,
            period: rest.period_ps / rest_known.period_ps,
            rest: rest.with_glitches_pj / rest_known.with_glitches_pj,
            work: work(busy.with_glitches_pj, rest.with_glitches_pj)
                / work(busy_known.with_glitches_pj, rest_known.with_glitches_pj),
            leakage: rest.leakage_nw / rest_known.leakage_nw,
        })
    }

    /// Configurations of the synthesised units that no formula is of.
    pub fn forms(&self, unit: UnitKind) -> impl Iterator<Item = Config> {
        let own = self.forms.iter().filter(move |p| p.family.unit() == unit);
        own.filter_map(|point| point.config().ok())
    }
}

/// `config` with the numbers of `from` in these fields.
fn with_numbers<'f>(
    config: &Config,
    from: &Config,
    fields: impl Iterator<Item = &'f str>,
) -> Option<Config> {
    let mut value = serde_json::to_value(config).ok()?;
    let from = serde_json::to_value(from).ok()?;
    for field in fields {
        let path = format!("/{}", field.replace('.', "/"));
        let number: Value = from.pointer(&path)?.clone();
        *value.pointer_mut(&path)? = number;
    }
    serde_json::from_value(value).ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn config(text: &str) -> Config {
        Config::from_toml(text, "test").unwrap()
    }

    /// Within a family the ratio is that of its own formulas; another exponential keeps it, since
    /// the formulas are of the plain one.
    #[test]
    fn numbers_scale_as_in_the_unit_that_formulas_are_of() {
        let fit = Fit::checked_in().unwrap();
        let unit = UnitKind::Vector;
        let ratio = |exp: &str| {
            let [own, known] =
                [12, 24].map(|lanes| config(&format!("[vu]\nlanes = {lanes}\n{exp}")));
            fit.ratio(&own, &known, unit).unwrap()
        };
        let plain = ratio("");
        let at = |text| {
            let work = Work {
                busy: 0.0,
                channels: 0,
            };
            fit.estimate(&config(text), unit, work).unwrap().area_um2
        };
        let expected = at("[vu]\nlanes = 12\n") / at("");
        assert!((plain.area - expected).abs() < 1e-12, "{plain:?}");
        assert!((0.4..0.7).contains(&plain.area) && (0.4..0.7).contains(&plain.work));
        let pieces = "[vu.exp]\nform = \"piecewise\"\npieces = 64\npipelined = false\n";
        if Config::from_toml(pieces, "t").is_ok() {
            assert_eq!(ratio(pieces), plain);
        }
    }

    #[test]
    fn units_that_differ_in_more_than_numbers_have_no_ratio() {
        let fit = Fit::checked_in().unwrap();
        let [tail, plain] = ["[vu]\nlanes = 12\n[vu.exp]\ntail = true\n", ""].map(config);
        assert_eq!(fit.ratio(&tail, &plain, UnitKind::Vector), None);
        let compact = config("[rit]\nentry = \"compact\"\n");
        assert_eq!(fit.ratio(&compact, &plain, UnitKind::Gathering), None);
        assert_eq!(fit.ratio(&plain, &plain, UnitKind::ArrayMac), None);
        let same = fit.ratio(&plain, &plain, UnitKind::Gathering).unwrap();
        assert_eq!([same.area, same.period, same.rest, same.work], [1.0; 4]);
    }
}
