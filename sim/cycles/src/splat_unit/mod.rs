//! Stepwise model of the splat unit, one clock cycle a call (rules of
//! `docs/reference/splat-unit.md`). What a pair of pixel and record computes comes from the reference
//! unit; when it is computed, and what is live then, from here.
//!
//! Parts follow the data: [`front`] (forms and rows), [`walk`] (pixels of rows), [`lanes`]
//! (exponentials), [`tiles`] (transmittance, colour, and the pass that gives pixels).

mod closed_form;
mod front;
mod lanes;
mod tiles;
mod walk;

use std::rc::Rc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::{
    ReferenceSplatUnit, SplatEntry, SplatJob, SplatPairs, SplatPart, SplatPixel, SplatSettings,
};

pub use self::closed_form::SplatSums;
use self::front::Front;
use self::lanes::Lanes;
use self::tiles::Tiles;
use self::walk::Walk;
use super::work::WorkError;

/// A beat of the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplatBeat<'a> {
    /// A record in a tile, and whether it ends the job.
    Record(&'a SplatEntry, bool),
    /// A word of the limits, or nothing; whether it ends the job.
    Other(bool),
}

/// Outputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatOutputs {
    /// `s_axis_spl_tready`.
    pub ready: bool,
    /// The pixel on the output, and whether it is the last one.
    pub pixel: Option<(SplatPixel, bool)>,
    /// `idle`.
    pub idle: bool,
    /// Counters of the cycles before.
    pub counters: SplatCounters,
    /// Bit 2 of `stat_errors`: a record in a tile after the last one was dropped.
    pub has_dropped: bool,
}

/// Counters of the unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct SplatCounters {
    /// Cycles in which it was not idle.
    pub busy: u64,
    /// Records in tiles whose pixels are given.
    pub records: u64,
    /// Pairs of pixel and record whose power was computed.
    pub square_sums: u64,
    /// Of those, the pairs that the cut kept.
    pub exponentials: u64,
    /// Pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pairs that ended a pixel.
    pub stopped: u64,
}

/// A record on its way.
#[derive(Debug)]
struct Entry {
    slot: usize,
    colour: [u16; 3],
    pairs: SplatPairs,
}

/// A pair of pixel and record.
#[derive(Debug, Clone)]
struct Pair {
    entry: Rc<Entry>,
    row: usize,
    column: usize,
}

impl Pair {
    fn alpha(&self) -> Option<u32> {
        self.entry.pairs.alphas[self.row][self.column]
    }
}

/// The splat unit between two clock edges.
pub struct SplatModel {
    twin: Rc<ReferenceSplatUnit>,
    left_out: Option<SplatPart>,
    front: Front,
    walk: Walk,
    lanes: Lanes,
    tiles: Tiles,
    ending: bool,
    is_open: bool,
    last_slot: usize,
    has_dropped: bool,
    counters: SplatCounters,
}

/// Cycles and counters of a job.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct SplatJobRun {
    /// Cycles from the first beat to the last pixel, with streams that never pause.
    pub cycles: u64,
    /// Counters of the job.
    pub counters: SplatCounters,
    /// Lanes of the exponential's vectors, those without a pair among them.
    pub lane_slots: u64,
}

impl std::ops::AddAssign for SplatJobRun {
    fn add_assign(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.lane_slots += other.lane_slots;
        let (own, other) = (&mut self.counters, other.counters);
        own.busy += other.busy;
        own.records += other.records;
        own.square_sums += other.square_sums;
        own.exponentials += other.exponentials;
        own.drawn += other.drawn;
        own.stopped += other.stopped;
    }
}

/// The cycle in which the last of several units side by side is done, which take jobs of these cycles in
/// order, each the unit that is free first.
#[must_use]
pub fn last_end(jobs: impl Iterator<Item = u64>, units: u32) -> u64 {
    let mut ends = vec![0; units.max(1) as usize];
    for cycles in jobs {
        if let Some(first) = ends.iter_mut().min() {
            *first += cycles;
        }
    }
    ends.into_iter().max().unwrap_or(0)
}

/// Runs jobs on the cycle model, each on a unit whose pixels are clear and whose limits are written: both
/// happen once after a reset.
#[derive(Debug)]
pub struct SplatRunner {
    config: Config,
    su: SuConfig,
    left_out: Option<SplatPart>,
    /// Of the settings of the last job.
    twin: Option<Rc<ReferenceSplatUnit>>,
}

impl SplatRunner {
    /// The splat unit of a configuration; `None` if it has none.
    #[must_use]
    pub fn new(config: &Config) -> Option<Self> {
        Some(Self {
            config: config.clone(),
            su: config.su.clone()?,
            left_out: None,
            twin: None,
        })
    }

    /// The same of a unit from which a part is left out: the rest has the same stages.
    #[must_use]
    pub fn without(self, part: SplatPart) -> Self {
        Self {
            left_out: Some(part),
            ..self
        }
    }

    /// Runs a job with streams that never pause.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn run(&mut self, job: &SplatJob<'_>) -> Result<SplatJobRun, WorkError> {
        let own = self.twin.take_if(|own| *own.settings() == job.settings);
        let exp = &self.config.vu.exp;
        let twin = own.unwrap_or_else(|| Rc::new(ReferenceSplatUnit::new(exp, 0, job.settings)));
        self.twin = Some(Rc::clone(&twin));
        let last_slot = job.tiles.saturating_sub(1);
        let mut model = SplatModel::with(twin, &self.config, &self.su, last_slot)?;
        model.left_out = self.left_out;
        model.tiles.skip_clearing();
        let count = job.entries.len().max(1);
        let (mut next, mut cycles) = (0, 0);
        loop {
            let is_last = next + 1 == count;
            let beat = (next < count).then(|| match job.entries.get(next) {
                Some(entry) => SplatBeat::Record(entry, is_last),
                None => SplatBeat::Other(is_last),
            });
            let outputs = model.step(beat, true);
            next += usize::from(beat.is_some() && outputs.ready);
            cycles += 1;
            if outputs.pixel.is_some_and(|(_, is_last)| is_last) {
                break;
            }
        }
        let counters = model.step(None, true).counters;
        Ok(SplatJobRun {
            cycles,
            counters,
            lane_slots: model.lanes.slots(),
        })
    }
}

impl SplatModel {
    /// The unit after reset. `last_slot` is the last tile whose pixels it gives.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(
        config: &Config,
        su: &SuConfig,
        settings: SplatSettings,
        last_slot: usize,
    ) -> Result<Self, WorkError> {
        let twin = ReferenceSplatUnit::new(&config.vu.exp, 0, settings);
        Self::with(Rc::new(twin), config, su, last_slot)
    }

    fn with(
        twin: Rc<ReferenceSplatUnit>,
        config: &Config,
        su: &SuConfig,
        last_slot: usize,
    ) -> Result<Self, WorkError> {
        let (tiles, settings) = (su.tiles as usize, *twin.settings());
        Ok(Self {
            twin,
            left_out: None,
            front: Front::default(),
            walk: Walk::default(),
            lanes: Lanes::new(config, su)?,
            tiles: Tiles::new(tiles, su.lanes as usize, settings, last_slot),
            ending: false,
            is_open: false,
            last_slot,
            has_dropped: false,
            counters: SplatCounters::default(),
        })
    }

    /// A cycle with `cfg_clear` high and nothing offered.
    pub fn clear(&mut self) {
        self.step(None, false);
        self.counters = SplatCounters::default();
        self.has_dropped = false;
    }

    /// One clock cycle with a beat that is offered, or none, and a sink that takes a pixel, or not.
    pub fn step(&mut self, offered: Option<SplatBeat<'_>>, sink: bool) -> SplatOutputs {
        let draining = self.tiles.is_draining();
        let ready = !self.ending && !draining && self.front.is_ready();
        let is_idle = !self.is_open;
        let outputs = SplatOutputs {
            ready,
            pixel: self.tiles.pixel(),
            idle: is_idle,
            counters: self.counters,
            has_dropped: self.has_dropped,
        };
        let before = self.front.is_busy() || self.walk.is_busy();
        let flush = self.ending && !before;
        let drain = flush && !self.lanes.is_busy() && !self.tiles.is_busy();
        self.counters.busy += u64::from(!is_idle);

        // What moves, from the last part to the first.
        let vector = self.lanes.offered();
        let live = self.tiles.live();
        let pops = self.tiles.step(vector, drain, sink, &mut self.counters);
        let kept = self.walk.kept();
        let takes_power = self.lanes.is_ready();
        self.counters.exponentials += u64::from(kept.is_some() && takes_power);
        self.lanes.step(kept.filter(|_| takes_power), flush, pops);
        let walked = self.walk.step(takes_power, self.front.row());
        self.counters.square_sums += u64::from(walked.summed);
        let entry = match offered.filter(|_| ready) {
            Some(SplatBeat::Record(entry, _)) if usize::from(entry.slot) > self.last_slot => {
                self.has_dropped = true;
                None
            }
            Some(SplatBeat::Record(entry, _)) => {
                self.counters.records += 1;
                Some(self.entry(entry))
            }
            _ => None,
        };
        self.front
            .step(entry, &live, walked.takes_row, walked.released);
        let accepted = offered.filter(|_| ready);
        let ends = |beat| matches!(beat, SplatBeat::Record(_, true) | SplatBeat::Other(true));
        self.ending = accepted.is_some_and(ends) || self.ending && !drain;
        let last_given = sink && outputs.pixel.is_some_and(|(_, is_last)| is_last);
        self.is_open = accepted.is_some() || self.is_open && !last_given;
        outputs
    }

    fn entry(&self, own: &SplatEntry) -> Rc<Entry> {
        let none = SplatPairs {
            rows: 0,
            spans: [0; 16],
            alphas: [[None; 16]; 16],
        };
        Rc::new(Entry {
            slot: usize::from(own.slot),
            colour: own.record.colour,
            pairs: self.twin.pairs_without(own, self.left_out).unwrap_or(none),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::config::SplatOpacity;
    use potamoi_formats::record::SplatRecord;
    use potamoi_reference::splat_unit::Thresholds;

    use super::*;

    const SETTINGS: SplatSettings = SplatSettings {
        thresholds: Thresholds {
            alpha_cap: 64_881,
            alpha_min: 258,
            stop: 6_871_948,
            spare: 0,
        },
        is_centred: true,
        opacity: SplatOpacity::Multiplied,
    };

    /// A record of a few pixels in the first tile.
    fn entry(i: i32) -> SplatEntry {
        SplatEntry {
            slot: 0,
            tile: [0, 0],
            last: [15, 12],
            record: SplatRecord {
                mean: [((3 * i) % 16) << 12, ((5 * i) % 13) << 12],
                factor: [1 << 29, (i % 9 - 4) << 25, 1 << 28],
                opacity: 4_000 * (1 + i as u16 % 16),
                colour: [4096; 3],
                rank: 0,
            },
        }
    }

    /// What a part saves is work alone: the pairs that draw or stop a pixel are the same without it.
    #[test]
    fn a_unit_without_a_part_draws_the_same_pairs_in_more_cycles() {
        let config = Config::preset("lean-splats").unwrap();
        let entries: Vec<SplatEntry> = (0..40).map(entry).collect();
        let job = SplatJob {
            settings: SETTINGS,
            tiles: 1,
            entries: &entries,
        };
        let runner = || SplatRunner::new(&config).unwrap();
        let whole = runner().run(&job).unwrap();
        let [spans, cut] = [SplatPart::Spans, SplatPart::Cut]
            .map(|part| runner().without(part).run(&job).unwrap());
        let drawn = |run: &SplatJobRun| [run.counters.drawn, run.counters.stopped];
        assert!(whole.counters.drawn > 0, "{whole:?}");
        assert_eq!([drawn(&spans), drawn(&cut)], [drawn(&whole); 2]);
        let own = whole.counters;
        assert!(spans.counters.square_sums > own.square_sums, "{spans:?}");
        assert!(own.exponentials < own.square_sums, "{own:?}");
        assert!(cut.counters.exponentials > own.exponentials, "{cut:?}");
        assert!(spans.cycles > whole.cycles && cut.cycles >= whole.cycles);
    }

    /// The formula is exact for one pair on one lane, and never above the model.
    #[test]
    fn the_formula_is_a_lower_bound_and_exact_for_one_pair() {
        let mut pipelined = Config::preset("lean-splats").unwrap();
        let mut iterative = pipelined.clone();
        iterative.vu.exp.pipelined = false;
        iterative.su.as_mut().unwrap().pipelined = false;
        let mut in_power = pipelined.clone();
        in_power.su.as_mut().unwrap().opacity = SplatOpacity::InPower;
        pipelined.su.as_mut().unwrap().lanes = 1;
        let mut wide = iterative.clone();
        wide.su.as_mut().unwrap().lanes = 12;
        let of = |config: &Config, entries: &[SplatEntry], tiles| {
            let settings = SplatSettings {
                opacity: config.su.as_ref().unwrap().opacity,
                ..SETTINGS
            };
            let job = SplatJob {
                settings,
                tiles,
                entries,
            };
            let run = SplatRunner::new(config).unwrap().run(&job).unwrap();
            let sums = SplatSums {
                jobs: 1,
                records: run.counters.records,
                square_sums: run.counters.square_sums,
                exponentials: run.counters.exponentials,
                pixels: 256 * tiles as u64,
            };
            (run, sums.cycles(config).unwrap())
        };
        // A faint record at the centre of a pixel reaches no other.
        let mut one = entry(0);
        one.record.mean = [9 << 11, 9 << 11];
        one.record.factor = [15 << 27, 0, 15 << 27];
        one.record.opacity = 300;
        let entries: Vec<SplatEntry> = (0..60).map(entry).collect();
        for config in [&pipelined, &iterative, &in_power] {
            if config.su.as_ref().unwrap().opacity == SplatOpacity::InPower {
                // -ln(300 / 65536), U3.13.
                one.record.opacity = 44_125;
            }
            let (run, formula) = of(config, &[one], 1);
            assert_eq!(run.counters.exponentials, 1, "{run:?}");
            assert_eq!(formula, run.cycles, "{:?}", config.su);
        }
        for config in [&pipelined, &iterative, &in_power, &wide] {
            let (run, formula) = of(config, &entries, 1);
            let share = formula as f64 / run.cycles as f64;
            assert!(
                (0.5..=1.0).contains(&share),
                "{share}: {run:?} {:?}",
                config.su
            );
        }
    }

    #[test]
    fn the_unit_that_is_free_first_takes_the_next_job() {
        let jobs = [5, 3, 1, 4, 2];
        assert_eq!(last_end(jobs.into_iter(), 1), 15);
        // 5 and 2 beside 3, 1 and 4.
        assert_eq!(last_end(jobs.into_iter(), 2), 8);
        assert_eq!(last_end(jobs.into_iter(), 9), 5);
        assert_eq!(last_end([].into_iter(), 3), 0);
    }
}
