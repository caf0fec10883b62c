//! Where the figures of a configuration's unit come from.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{Fit, Ratio};
use potamoi_synth::{Synthesised, UnitKind};

/// Synthesised units and formulas.
pub(super) struct Known<'a> {
    /// Formulas fitted to syntheses.
    pub(super) fit: &'a Fit,
    /// Synthesised units, of any configuration; the first that has a unit counts.
    pub(super) reports: &'a [Synthesised],
    /// Units whose own synthesis does not count, see [`super::Parameters::estimated`].
    pub(super) estimated: &'a [UnitKind],
}

/// Source of a unit's figures, the best that is known.
pub(super) enum UnitSource<'a> {
    /// Its own synthesis.
    Synthesised(&'a Synthesised),
    /// Formulas, or a synthesis beside them.
    Formulas,
    /// A synthesised unit that differs in numbers alone, or the paper's, which differs in parts that
    /// were synthesised, and the ratio.
    Composed(Base<'a>, Ratio),
    /// None, and why.
    Unknown(String),
}

/// The unit that another is composed of.
pub(super) enum Base<'a> {
    /// With a report of its own.
    Reported(&'a Synthesised),
    /// Beside the formulas.
    Beside(Box<Config>),
}

impl<'a> Known<'a> {
    /// The best source of a unit: its own synthesis, formulas, a synthesised unit and formulas for
    /// the numbers in which it differs, or the paper's unit and the parts in which it differs.
    pub(super) fn source(&self, config: &Config, unit: UnitKind) -> UnitSource<'a> {
        let mut own = self.reports.iter().filter(|own| own.has(config, unit));
        if let (Some(own), false) = (own.next(), self.estimated.contains(&unit)) {
            return UnitSource::Synthesised(own);
        }
        let at_rest = potamoi_synth::fit::Work {
            busy: 0.0,
            channels: config.gu.banks.into(),
        };
        let why = match self.fit.estimate(config, unit, at_rest) {
            Ok(_) => return UnitSource::Formulas,
            Err(why) => why,
        };
        let ratio = |known: &Config| self.fit.ratio(config, known, unit);
        let reported = self.reports.iter();
        let mut reported = reported.filter_map(|own| Some((own, ratio(&own.config)?)));
        if let Some((own, ratio)) = reported.next() {
            return UnitSource::Composed(Base::Reported(own), ratio);
        }
        let mut beside = self.fit.forms(unit);
        let beside = beside.find_map(|own| Some((ratio(&own)?, own)));
        match beside {
            Some((ratio, own)) => UnitSource::Composed(Base::Beside(Box::new(own)), ratio),
            None => match self.fit.by_parts(config, unit) {
                Some(ratio) => UnitSource::Composed(Base::Beside(Box::new(Config::paper())), ratio),
                None => UnitSource::Unknown(why.to_string()),
            },
        }
    }
}
