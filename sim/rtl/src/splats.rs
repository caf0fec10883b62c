//! Drives the splat unit on any engine.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_cycles::splat_unit::{SplatBeat, SplatCounters, SplatModel};
use potamoi_cycles::{Plan, Stalls};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_netlist::Module;
use potamoi_reference::splat_unit::{SplatEntry, SplatPixel, SplatSettings, TILE_PIXELS};
use potamoi_units::splat_unit::splat_unit;

use super::engine::{Engine, EngineKind, Job};
use super::mismatch::Mismatch;
use super::model::RtlError;
use super::runner::Runner;
use super::splat_beats::{data_of, limit_words, user_of};
use super::wave_dump::{AFTER, Window};

/// Cycles without a handshake after which the unit counts as hanging, beside those in which it clears the
/// pixels of its tiles.
const PATIENCE: u64 = 100_000;

/// A splat unit, ready to run.
pub struct SplatUnit {
    runner: Runner,
    config: Config,
    su: SuConfig,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SplatRun {
    /// Pixels of every job, tile by tile and row by row.
    pub jobs: Vec<Vec<SplatPixel>>,
    /// Cycles from the first record to the last pixel.
    pub cycles: u64,
    /// Counters of the unit.
    pub counters: SplatCounters,
}

impl SplatUnit {
    /// The unit of a configuration on an engine.
    ///
    /// # Errors
    /// A missing or failing tool.
    pub fn on(engine: EngineKind, config: &Config, su: &SuConfig) -> Result<Self, RtlError> {
        Self::of_module(engine, config, su, &splat_unit(config, su)?)
    }

    /// A unit from another netlist with the same ports, such as a faulty one.
    ///
    /// # Errors
    /// As [`SplatUnit::on`].
    pub fn of_module(
        engine: EngineKind,
        config: &Config,
        su: &SuConfig,
        module: &Arc<Module>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            runner: Runner::new(engine, module)?,
            config: config.clone(),
            su: su.clone(),
        })
    }

    /// A unit from other Verilog files with the same ports, such as its gate-level netlist.
    ///
    /// # Errors
    /// As [`SplatUnit::on`]; the interpreter runs none.
    pub fn of_files(
        engine: EngineKind,
        config: &Config,
        su: &SuConfig,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            runner: Runner::of_files(engine, &splat_unit(config, su)?, files)?,
            config: config.clone(),
            su: su.clone(),
        })
    }

    /// Composites jobs, one after the other, of tiles 0 to `last_slot`, from reset, and holds every
    /// cycle to the cycle model: handshakes, pixels, `idle` and counters.
    ///
    /// # Errors
    /// [`RtlError::Mismatch`] at the first difference from the model; a unit that raises a flag or
    /// hangs.
    pub fn check(
        &self,
        jobs: &[&[SplatEntry]],
        last_slot: u16,
        settings: &SplatSettings,
        stalls: &Stalls,
        seed: u64,
    ) -> Result<SplatRun, RtlError> {
        let drive = Drive {
            config: &self.config,
            su: &self.su,
            jobs,
            last_slot,
            settings,
            plan: Plan::new(seed, stalls)?,
            after: 0,
        };
        self.runner.run(seed, drive)
    }

    /// Repeats a run that differs in `cycle`, and dumps the window around it. Returns the time of the
    /// cycle in the file.
    ///
    /// # Errors
    /// The file cannot be written, or the run does not differ.
    pub fn excerpt(
        &self,
        (jobs, last_slot, settings): (&[&[SplatEntry]], u16, &SplatSettings),
        (stalls, seed): (&Stalls, u64),
        cycle: u64,
        path: &Path,
    ) -> Result<u64, RtlError> {
        let drive = Drive {
            config: &self.config,
            su: &self.su,
            jobs,
            last_slot,
            settings,
            plan: Plan::new(seed, stalls)?,
            after: AFTER,
        };
        let window = Window::around(cycle, path);
        let time = window.time();
        match self.runner.run_dumped(seed, window, drive) {
            Err(RtlError::Mismatch(_)) => Ok(time),
            Err(other) => Err(other),
            Ok(_) => Err(RtlError::Usage("the run did not differ again".to_owned())),
        }
    }
}

/// One run on any engine.
pub(super) struct Drive<'a> {
    config: &'a Config,
    su: &'a SuConfig,
    jobs: &'a [&'a [SplatEntry]],
    last_slot: u16,
    settings: &'a SplatSettings,
    plan: Plan,
    /// Cycles that the run goes on after a difference, for a dump.
    after: u64,
}

impl<'a> Drive<'a> {
    /// A run with streams that are always ready.
    ///
    /// # Errors
    /// Never: such streams have a plan.
    pub(super) fn ready(
        (config, su): (&'a Config, &'a SuConfig),
        jobs: &'a [&'a [SplatEntry]],
        last_slot: u16,
        settings: &'a SplatSettings,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            config,
            su,
            jobs,
            last_slot,
            settings,
            plan: Plan::new(0, &Stalls::NONE)?,
            after: 0,
        })
    }
}

impl Drive<'_> {
    /// Settings, and streams at rest.
    fn configure<E: Engine>(&self, engine: &mut E) -> Result<(), RtlError> {
        let thresholds = &self.settings.thresholds;
        for (name, value) in [
            ("cfg_alpha_cap", u64::from(thresholds.alpha_cap)),
            ("cfg_alpha_min", u64::from(thresholds.alpha_min)),
            ("cfg_stop_below", thresholds.stop),
            ("cfg_centred", u64::from(self.settings.is_centred)),
            ("cfg_last_slot", u64::from(self.last_slot)),
            ("cfg_clear", 0),
            ("s_axis_spl_tvalid", 0),
            ("m_axis_pix_tready", 0),
        ] {
            let port = engine.port(name)?;
            engine.set(port, value)?;
        }
        Ok(())
    }
}

impl Job for Drive<'_> {
    type Output = SplatRun;

    fn run<E: Engine>(mut self, engine: &mut E) -> Result<SplatRun, RtlError> {
        let input = ["tvalid", "tready", "tdata", "tkeep", "tlast", "tuser"];
        let input = input.map(|name| engine.port(&format!("s_axis_spl_{name}")));
        let [valid, ready, data, keep, last, user] = input;
        let (valid, ready, data, keep, last, user) = (valid?, ready?, data?, keep?, last?, user?);
        let output = ["tvalid", "tready", "tdata", "tlast"];
        let output = output.map(|name| engine.port(&format!("m_axis_pix_{name}")));
        let [given, sink, pixel, end] = output;
        let (given, sink, pixel, end) = (given?, sink?, pixel?, end?);
        self.configure(engine)?;
        engine.reset()?;
        let limits = limit_words(self.config, self.settings);
        let limits = limits.into_iter().map(Beat::Limit);
        let jobs = self.jobs.iter().flat_map(|job| beats_of(job));
        let beats: Vec<Beat<'_>> = limits.chain(jobs).collect();
        let last_slot = usize::from(self.last_slot);
        let mut model = SplatModel::new(self.config, self.su, *self.settings, last_slot)?;
        // The clocks of the reset clear no pixel; the model begins after them.
        let mut next = 0;
        let (mut offered, mut quiet, mut cycles) = (false, 0, 0);
        let (mut differs, mut has_begun) = (None, false);
        let mut jobs = vec![vec![]; self.jobs.len()];
        let mut done = 0;
        let mut words = vec![0; engine.words(pixel)];
        let stats = STATS.map(|name| engine.port(&format!("stat_{name}")));
        let idle = engine.port("idle")?;
        while done < self.jobs.len() {
            let willing = self.plan.step();
            offered = next < beats.len() && (offered || willing.rit);
            engine.set(valid, u64::from(offered))?;
            let beat = beats.get(next).filter(|_| offered);
            if let Some(beat) = beat {
                if !has_begun && !matches!(beat, Beat::Limit(_)) {
                    has_begun = true;
                    engine.work_begins();
                }
                let (words, kept, ends) = beat.words();
                engine.set_words(data, &words)?;
                engine.set(keep, (1u64 << kept) - 1)?;
                engine.set(last, u64::from(ends))?;
                let entry = beat.entry();
                engine.set(user, entry.map_or(0, |own| user_of(self.su, own)))?;
            }
            engine.set(sink, u64::from(willing.sink))?;
            engine.settle()?;
            let found = Seen {
                ready: engine.get(ready)? == 1,
                idle: engine.get(idle)? == 1,
                pixel: match engine.get(given)? {
                    0 => None,
                    _ => {
                        engine.get_words(pixel, &mut words)?;
                        Some((pixel_of(&words), engine.get(end)? == 1))
                    }
                },
                counters: counters_of(engine, &stats)?,
            };
            let wanted = model.step(beat.map(|beat| beat.of_model()), willing.sink);
            let wanted = Seen {
                ready: wanted.ready,
                idle: wanted.idle,
                pixel: wanted.pixel,
                counters: wanted.counters,
            };
            if found != wanted && differs.is_none() {
                let place = format!("beat {next} of {}, pixels of job {done}", beats.len());
                differs = Some(found.differing(&wanted, cycles, place));
            }
            if let Some(mismatch) = differs.take_if(|_| self.after == 0) {
                return Err(RtlError::Mismatch(Box::new(mismatch)));
            }
            self.after -= u64::from(differs.is_some());
            quiet += 1;
            if offered && found.ready {
                next += 1;
                (offered, quiet) = (false, 0);
            }
            if let Some((pixel, ends)) = found.pixel.filter(|_| willing.sink) {
                jobs[done].push(pixel);
                done += usize::from(ends);
                quiet = 0;
            }
            if quiet > PATIENCE + u64::from(self.su.tiles) * TILE_PIXELS as u64 {
                let text = format!("the splat unit hangs at beat {next} of {}", beats.len());
                return Err(RtlError::Usage(text));
            }
            engine.edge()?;
            cycles += 1;
        }
        if let Some(mismatch) = differs {
            return Err(RtlError::Mismatch(Box::new(mismatch)));
        }
        engine.set(sink, 0)?;
        engine.settle()?;
        let counters = counters_of(engine, &stats)?;
        let errors = engine.get(engine.port("stat_errors")?)?;
        if errors != 0 {
            let text = format!("the splat unit raises the flags {errors:#b}");
            return Err(RtlError::Usage(text));
        }
        let pixels = (usize::from(self.last_slot) + 1) * TILE_PIXELS;
        if let Some(short) = jobs.iter().find(|job| job.len() != pixels) {
            let text = format!("the splat unit gave {} pixels of {pixels}", short.len());
            return Err(RtlError::Usage(text));
        }
        Ok(SplatRun {
            jobs,
            cycles,
            counters,
        })
    }
}

/// Counters, as [`SplatCounters`] has them.
const STATS: [&str; 6] = [
    "busy",
    "records",
    "square_sums",
    "exponentials",
    "drawn",
    "stopped",
];

/// What the ports show in a cycle.
#[derive(Debug, PartialEq, Eq)]
struct Seen {
    ready: bool,
    idle: bool,
    pixel: Option<(SplatPixel, bool)>,
    counters: SplatCounters,
}

impl Seen {
    /// What differs, the most telling first.
    fn differing(&self, wanted: &Self, cycle: u64, place: String) -> Mismatch {
        let all = [
            (
                "m_axis_pix",
                [self, wanted].map(|own| format!("{:?}", own.pixel)),
            ),
            (
                "s_axis_spl_tready",
                [self, wanted].map(|own| own.ready.to_string()),
            ),
            (
                "stat_*",
                [self, wanted].map(|own| format!("{:?}", own.counters)),
            ),
            ("idle", [self, wanted].map(|own| own.idle.to_string())),
        ];
        let differs = |(_, [found, expected]): &(_, [String; 2])| found != expected;
        let (signal, [found, expected]) = all.into_iter().find(differs).unwrap_or_default();
        Mismatch {
            module: SPLAT_UNIT,
            cycle,
            signal: signal.to_owned(),
            expected,
            found,
            place,
        }
    }
}

fn counters_of<E: Engine>(
    engine: &E,
    ports: &[Result<E::Port, RtlError>; 6],
) -> Result<SplatCounters, RtlError> {
    let mut values = [0; 6];
    for (value, port) in values.iter_mut().zip(ports) {
        let port = port
            .as_ref()
            .map_err(|error| RtlError::Usage(error.to_string()))?;
        *value = engine.get(*port)?;
    }
    let [busy, records, square_sums, exponentials, drawn, stopped] = values;
    Ok(SplatCounters {
        busy,
        records,
        square_sums,
        exponentials,
        drawn,
        stopped,
    })
}

/// A beat of the input.
#[derive(Clone, Copy)]
enum Beat<'a> {
    /// A word of the limits.
    Limit(u32),
    /// A record, and whether it ends the job.
    Record(&'a SplatEntry, bool),
    /// The end of a job without records.
    End,
}

impl<'a> Beat<'a> {
    fn entry(self) -> Option<&'a SplatEntry> {
        match self {
            Self::Record(entry, _) => Some(entry),
            Self::Limit(_) | Self::End => None,
        }
    }

    fn of_model(self) -> SplatBeat<'a> {
        match self {
            Self::Record(entry, ends) => SplatBeat::Record(entry, ends),
            Self::Limit(_) => SplatBeat::Other(false),
            Self::End => SplatBeat::Other(true),
        }
    }

    /// Data, number of bytes that are kept, and whether the job ends.
    fn words(self) -> (Vec<u32>, u32, bool) {
        match self {
            Self::Limit(word) => (vec![word, 0, 0, 0, 0, 0, 0, 0], 4, false),
            Self::End => (vec![0; 8], 0, true),
            Self::Record(entry, ends) => (data_of(entry), 32, ends),
        }
    }
}

/// Beats of a job.
fn beats_of(job: &[SplatEntry]) -> Vec<Beat<'_>> {
    let count = job.len();
    let records = job.iter().enumerate();
    let mut beats: Vec<_> = records
        .map(|(i, own)| Beat::Record(own, i + 1 == count))
        .collect();
    if beats.is_empty() {
        beats.push(Beat::End);
    }
    beats
}

fn pixel_of(words: &[u32]) -> SplatPixel {
    let bits = |low: usize, width: usize| {
        (0..width).fold(0u64, |value, i| {
            let bit = words[(low + i) / 32] >> ((low + i) % 32) & 1;
            value | u64::from(bit) << i
        })
    };
    SplatPixel {
        transmittance: bits(0, 24) as u32,
        colour: [0, 1, 2].map(|channel| bits(24 + 40 * channel, 40)),
    }
}
