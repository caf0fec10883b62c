//! Units that no formula is of, composed: a synthesised unit that differs in numbers alone, times
//! what formulas give for those numbers in a unit that they are of.

use potamoi_formats::config::{Config, ExpForm};
use serde::Serialize;
use serde_json::Value;

use super::{Estimate, Fit, Spread, Work};
use crate::UnitKind;
use crate::grid::{Family, differing, is_same_unit};

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

/// Figures of a unit: what a ratio is of.
#[derive(Debug, Clone, Copy)]
struct Figures {
    area: f64,
    period: f64,
    rest: f64,
    work: f64,
    leakage: f64,
}

impl Figures {
    /// Of a unit at rest and busy.
    fn of([rest, busy]: &[Estimate; 2]) -> Self {
        Self {
            area: rest.area_um2,
            period: rest.period_ps,
            rest: rest.with_glitches_pj,
            work: busy.with_glitches_pj - rest.with_glitches_pj,
            leakage: rest.leakage_nw,
        }
    }

    fn over(&self, other: &Self) -> Ratio {
        Ratio {
            area: self.area / other.area,
            period: self.period / other.period,
            rest: self.rest / other.rest,
            work: self.work / other.work,
            leakage: self.leakage / other.leakage,
        }
    }

    /// With a part, from a unit with it and one without it, which have one lane for each `lanes` here.
    fn and(&self, with: &Self, without: &Self, lanes: f64) -> Self {
        Self {
            area: self.area + lanes * (with.area - without.area),
            period: self.period * with.period / without.period,
            rest: self.rest + lanes * (with.rest - without.rest),
            work: self.work + lanes * (with.work - without.work),
            leakage: self.leakage + lanes * (with.leakage - without.leakage),
        }
    }
}

/// Fields that together are the shape of an exponential.
const SHAPE: [&str; 6] = [
    ITERATIONS,
    PIPELINED,
    "vu.exp.form",
    "vu.exp.tail",
    "vu.exp.pieces",
    "vu.exp.base",
];
const ITERATIONS: &str = "vu.exp.iterations";
const PIPELINED: &str = "vu.exp.pipelined";
/// Fields of vector units that formulas take, whatever the exponential.
const NUMBERS: [&str; 2] = ["vu.lanes", "vu.exp.output_bits"];

/// Fields in which a vector unit differs from the paper's beyond `plain` ones, part by part: the
/// shape of the exponential together, each other setting by itself.
fn parts(config: &Config, plain: &[&str]) -> Vec<Vec<String>> {
    let own = differing(config, &Config::paper(), UnitKind::Vector);
    let own = own.into_iter().filter(|field| !NUMBERS.contains(&&**field));
    let (mut shape, others): (Vec<_>, Vec<_>) = own.partition(|f| SHAPE.contains(&&**f));
    if shape.iter().all(|field| plain.contains(&&**field)) {
        shape.clear();
    }
    // The pipeline is of the unit that it adds to.
    shape.retain(|field| field != PIPELINED || !plain.contains(&PIPELINED));
    let parts = others.into_iter().map(|field| vec![field]);
    parts.chain((!shape.is_empty()).then_some(shape)).collect()
}

/// Relative errors of units composed by parts, at synthesised combinations of parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompositionErrors {
    /// Area.
    pub area: Spread,
    /// Longest path.
    pub period: Spread,
    /// Energy of a busy cycle, with glitches.
    pub energy: Spread,
}

/// Fields of an exponential's shape that formulas take. Straight pieces have no iterations and are
/// pipelined always.
fn plain_fields(config: &Config) -> &'static [&'static str] {
    match config.vu.exp.form {
        ExpForm::Piecewise => &[],
        _ => &[ITERATIONS, PIPELINED],
    }
}

/// Whether a vector unit differs from the paper's in several parts.
fn is_combination(config: &Config) -> bool {
    let plain = plain_fields(config);
    let own = differing(config, &Config::paper(), UnitKind::Vector);
    let by_formulas = |field: &&String| {
        NUMBERS.contains(&&***field) || (plain.contains(&PIPELINED) && **field == PIPELINED)
    };
    own.iter().filter(by_formulas).count() + parts(config, plain).len() > 1
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
        Some(self.figures(&own, unit)?.over(&self.figures(&known, unit)?))
    }

    /// Figures of a configuration's unit by formulas, or as it was synthesised.
    fn figures(&self, config: &Config, unit: UnitKind) -> Option<Figures> {
        let channels = Config::paper().gu.banks.into();
        let at = |busy| self.estimate(config, unit, Work { busy, channels }).ok();
        Some(Figures::of(&[at(0.0)?, at(1.0)?]))
    }

    /// Figures of a configuration's vector unit over those of the paper's. Formulas give the unit with
    /// the same numbers and pipeline. Each part in which it differs besides (the shape of the
    /// exponential, and each other setting by itself) was synthesised in the paper's unit: it adds as
    /// much area, energy and leakage a lane as there, and lengthens the period by the same factor.
    /// `None` where a part was not synthesised, or for other units.
    #[must_use]
    pub fn by_parts(&self, config: &Config, unit: UnitKind) -> Option<Ratio> {
        if unit != UnitKind::Vector {
            return None;
        }
        let paper = Config::paper();
        let with = |fields: &[&str]| {
            let own = with_numbers(&paper, config, fields.iter().copied())?;
            self.figures(&own, unit)
        };
        let plain = plain_fields(config);
        let lanes = f64::from(config.vu.lanes) / f64::from(paper.vu.lanes);
        let mut all = with(&[&NUMBERS, plain].concat())?;
        for part in parts(config, plain) {
            let part: Vec<&str> = part.iter().map(String::as_str).collect();
            let shared = part.iter().copied().filter(|field| plain.contains(field));
            let shared: Vec<&str> = shared.collect();
            all = all.and(&with(&part)?, &with(&shared)?, lanes);
        }
        Some(all.over(&with(&[])?))
    }

    /// Errors of composition at the synthesised vector units that differ from the paper's in two
    /// parts or more, each composed without its own synthesis. They are of the data alone, and found
    /// once.
    #[must_use]
    pub fn composition_errors(&self) -> CompositionErrors {
        *self
            .composition_errors
            .get_or_init(|| self.composed_beside_synthesised())
    }

    fn composed_beside_synthesised(&self) -> CompositionErrors {
        let unit = UnitKind::Vector;
        let paper = Config::paper();
        let busy = Work {
            busy: 1.0,
            channels: 0,
        };
        let mut found = vec![];
        for point in self.forms.iter().filter(|p| p.family.unit() == unit) {
            let own = point.config().ok().filter(is_combination);
            let composed = own.and_then(|own| self.by_parts(&own, unit));
            let Some(ratio) = composed else { continue };
            let Ok(known) = self.estimate(&paper, unit, busy) else {
                continue;
            };
            let rest = known.clock_pj;
            let energy = ratio.rest * rest + ratio.work * (known.with_glitches_pj - rest);
            let own = Estimate::of(point, busy);
            found.push([
                ratio.area * known.area_um2 / own.area_um2,
                ratio.period * known.period_ps / own.period_ps,
                energy / own.with_glitches_pj,
            ]);
        }
        let spread = |i: usize| Spread::new(found.iter().map(|own| own[i] - 1.0));
        CompositionErrors {
            area: spread(0),
            period: spread(1),
            energy: spread(2),
        }
    }

    /// The longest period of a synthesised unit that no formula is of, in picoseconds.
    #[must_use]
    pub fn slowest_ps(&self, unit: UnitKind) -> Option<f64> {
        let own = self.forms.iter().filter(|p| p.family.unit() == unit);
        own.map(|point| point.period_ps).reduce(f64::max)
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
        // A setting that is not written is at its default.
        let number = from.pointer(&path).cloned().unwrap_or(Value::Null);
        match value.pointer_mut(&path) {
            Some(place) => *place = number,
            None => {
                let (of, name) = path.rsplit_once('/')?;
                value
                    .pointer_mut(of)?
                    .as_object_mut()?
                    .insert(name.to_owned(), number);
            }
        }
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

    /// Radix 4, four iterations a clock and a pipeline: each was synthesised alone, all together not.
    #[test]
    fn parts_that_were_synthesised_alone_are_a_unit() {
        let fit = Fit::checked_in().unwrap();
        let of = |exp: &str| {
            let config = config(&format!("[vu.exp]\n{exp}"));
            fit.by_parts(&config, UnitKind::Vector)
        };
        let shape = "form = \"radix-4\"\niterations = 4\ntail = true\n";
        let [alone, fast] = [shape, "iterations_per_clock = 4\n"].map(|exp| of(exp).unwrap());
        let both = of(&format!("{shape}iterations_per_clock = 4\n")).unwrap();
        assert!((both.period / (alone.period * fast.period) - 1.0).abs() < 1e-12);
        assert!((both.area - (alone.area + fast.area - 1.0)).abs() < 1e-12);
        assert!(fast.period > 1.4 && fast.area > 1.0, "{fast:?}");
        assert!((of("").unwrap().area - 1.0).abs() < 1e-12);
        assert!(of("form = \"radix-4\"\niterations = 7\n").is_none());
        assert_eq!(fit.by_parts(&Config::paper(), UnitKind::Gathering), None);
        assert!(fit.slowest_ps(UnitKind::Vector).unwrap() > 2000.0);
    }

    /// The five combinations, and the errors that docs/explanation/cost.md and trust.md state.
    #[test]
    fn combinations_are_near_their_synthesis() {
        let fit = Fit::checked_in().unwrap();
        let errors = fit.composition_errors();
        let [area, period, energy] = [errors.area, errors.period, errors.energy].map(|of| {
            assert_eq!(of.points, 5);
            format!("{:.1} %", 100.0 * of.worst)
        });
        for (page, said) in [
            (
                include_str!("../../../../docs/explanation/cost.md"),
                format!(
                    "{area} of the area, {period} of the period and {energy} of the energy of a busy cycle"
                ),
            ),
            (
                include_str!("../../../../docs/explanation/trust.md"),
                format!("area {area}, period {period}, energy of a busy cycle {energy} at worst"),
            ),
        ] {
            let words: Vec<_> = page.split_whitespace().collect();
            assert!(words.join(" ").contains(&said), "{said}");
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
