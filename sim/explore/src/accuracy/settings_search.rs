//! Search over all settings, and the configuration of its result.

use super::bench::Bench;
use super::knobs::{Change, Knob, Reproduce, Setting};
use super::local_search::{Choice, Goal, Paths, search_by_ways_alone};
use super::pareto_front::CostQuality;
use super::price::Price;
use super::sweep::{SearchResult, Sweep};
use crate::{ExploreError, Progress};

/// A knob and one of its settings.
type Turned<'a> = (&'a Knob, &'a Setting);

/// A search over the settings of knobs.
pub struct Search<'a> {
    /// The scene on which settings are tried.
    pub bench: &'a Bench,
    /// Knobs that may be turned.
    pub knobs: &'a [Knob],
    /// Measurements of each setting alone.
    pub sweep: &'a Sweep,
    /// Goal to reach.
    pub goal: Goal,
    /// Cost to minimise; settings with unknown cost are skipped.
    pub price: Price,
}

/// Result of a search.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Reported measurements.
    pub found: SearchResult,
    /// Settings, to be applied together.
    pub settings: Vec<Setting>,
    /// The machine as TOML: the configuration, and changes outside it in `[render]` and `[path]`.
    pub text: String,
}

impl Search<'_> {
    /// Runs the search. `reach` gets the text of every choice on the way that meets the goal and is
    /// preferred to those before, as in [`Candidate::text`].
    ///
    /// # Errors
    /// The goal is out of reach, the cost of the default is not known, or `reach` fails.
    pub fn find<E: From<ExploreError>>(
        &self,
        progress: &dyn Progress,
        mut reach: impl FnMut(&str) -> Result<(), E>,
    ) -> Result<Candidate, E> {
        let counts: Vec<usize> = self.knobs.iter().map(|knob| knob.settings.len()).collect();
        let mut tried = 0;
        let place = |choice: &Choice, paths: Paths| -> Result<_, E> {
            let own = self.turned(choice);
            if let Some(known) = self.measured(&own) {
                return Ok(known);
            }
            tried += 1;
            let names = labels(&own).join(", ");
            progress.now(&format!("searching: {tried} tried, {names}"));
            // Two variants of a path are one too many; what cannot be is passed over.
            let paths_turned = own
                .iter()
                .filter(|(_, s)| matches!(s.change, Change::Path(_)));
            if paths_turned.count() > 1 {
                return Ok(None);
            }
            Ok((self.bench.place(&settings(&own), paths, self.price))
                .ok()
                .flatten())
        };
        let told = |choice: &Choice| reach(&self.text(&self.turned(choice))?);
        let found = search_by_ways_alone(self.goal, &counts, place, told)?;
        let Some((choice, at, is_met)) = found else {
            return Err(self.unknown().into());
        };
        if !is_met {
            return Err(ExploreError::Inconclusive(format!(
                "no settings reach it: the nearest have {:.2} dB at {}",
                at.quality,
                self.price.words(at.cost)
            ))
            .into());
        }
        let own = self.turned(&choice);
        let names = labels(&own);
        let point = (self.bench).point("found", &names.join(", "), &settings(&own))?;
        Ok(Candidate {
            text: self.text(&own)?,
            settings: own.iter().map(|(_, setting)| (*setting).clone()).collect(),
            found: SearchResult {
                settings: names,
                point,
                tried,
            },
        })
    }

    /// Settings of a choice, without defaults.
    fn turned(&self, choice: &[Option<usize>]) -> Vec<Turned<'_>> {
        let pairs = self.knobs.iter().zip(choice);
        pairs
            .filter_map(|(knob, at)| Some((knob, &knob.settings[(*at)?])))
            .collect()
    }

    /// Measured place of the default or of a single setting; the inner `None`: invalid.
    fn measured(&self, own: &[Turned<'_>]) -> Option<Option<CostQuality>> {
        match own {
            [] => Some(self.sweep.default_point().priced(self.price)),
            [(knob, setting)] => {
                let mut points = self.sweep.points.iter();
                let point =
                    points.find(|point| point.knob == knob.name && point.setting == setting.label);
                Some(point.and_then(|point| point.priced(self.price)))
            }
            _ => None,
        }
    }

    /// Error for an unknown cost of the default.
    fn unknown(&self) -> ExploreError {
        ExploreError::Inconclusive(match self.price {
            Price::Time => "the default cannot be measured".to_owned(),
            Price::Energy | Price::Area => {
                "energy and area of the default are not known: potamoi synth --json finds them, and \
                 --synth takes them"
                    .to_owned()
            }
        })
    }

    /// Configuration of the settings, with changes outside it in the sections of a machine's file.
    fn text(&self, own: &[Turned<'_>]) -> Result<String, ExploreError> {
        let (config, _) = self.bench.apply(&settings(own))?;
        let (mut render, mut without, mut path) = (vec![], vec![], vec![]);
        for (_, setting) in own {
            match setting.change.reproduce() {
                Some(Reproduce::Render(lines)) => render.extend(lines),
                Some(Reproduce::Without(effect)) => without.push(format!("{effect:?}")),
                Some(Reproduce::Path(lines)) => path.extend(lines),
                None => {}
            }
        }
        if !without.is_empty() {
            render.push(format!("without = [{}]", without.join(", ")));
        }
        let made = config.to_toml();
        let mut text = made.map_err(|e| ExploreError::Refused(e.to_string()))?;
        for (name, lines) in [("render", render), ("path", path)] {
            if !lines.is_empty() {
                text.push_str(&format!("\n[{name}]\n{}\n", lines.join("\n")));
            }
        }
        Ok(text)
    }
}

fn settings<'a>(own: &[Turned<'a>]) -> Vec<&'a Setting> {
    own.iter().map(|(_, setting)| *setting).collect()
}

fn labels(own: &[Turned<'_>]) -> Vec<String> {
    let label = |(knob, setting): &Turned<'_>| format!("{} {}", knob.name, setting.label);
    own.iter().map(label).collect()
}
