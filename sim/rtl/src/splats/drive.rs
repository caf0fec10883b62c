//! A run of the splat unit, held to the cycle model in every cycle.

use potamoi_cycles::splat_unit::SplatModel;
use potamoi_cycles::{Plan, Stalls};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::{SplatEntry, SplatPixel, SplatSettings, TILE_PIXELS};

use super::SplatRun;
use super::beats::{Beat, beats_of};
use super::seen::{Ports, Seen};
use crate::engine::{Engine, Job};
use crate::model::RtlError;
use crate::splat_beats::limit_words;

/// Cycles without a handshake after which the unit counts as hanging, beside those in which it clears the
/// pixels of its tiles.
const PATIENCE: u64 = 100_000;

/// One run on any engine.
pub(crate) struct Drive<'a> {
    pub(super) config: &'a Config,
    pub(super) su: &'a SuConfig,
    pub(super) jobs: &'a [&'a [SplatEntry]],
    pub(super) last_slot: u16,
    pub(super) settings: &'a SplatSettings,
    pub(super) plan: Plan,
    /// Cycles that the run goes on after a difference, for a dump.
    pub(super) after: u64,
}

impl<'a> Drive<'a> {
    /// A run with streams that are always ready.
    ///
    /// # Errors
    /// Never: such streams have a plan.
    pub(crate) fn ready(
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
        let mut ports = Ports::of(engine)?;
        self.configure(engine)?;
        engine.reset()?;
        let limits = limit_words(self.config, self.settings);
        let limits = limits.into_iter().map(Beat::Limit);
        let jobs = self.jobs.iter().flat_map(|job| beats_of(job));
        let beats: Vec<Beat<'_>> = limits.chain(jobs).collect();
        let last_slot = usize::from(self.last_slot);
        // The clocks of the reset clear no pixel; the model begins after them.
        let mut model = SplatModel::new(self.config, self.su, *self.settings, last_slot)?;
        let (mut next, mut offered, mut quiet, mut cycles) = (0, false, 0, 0);
        let (mut differs, mut begun) = (None, None);
        let mut jobs = vec![vec![]; self.jobs.len()];
        let mut done = 0;
        while done < self.jobs.len() {
            let willing = self.plan.step();
            offered = next < beats.len() && (offered || willing.rit);
            let beat = beats.get(next).copied().filter(|_| offered);
            if begun.is_none() && beat.is_some_and(|own| !matches!(own, Beat::Limit(_))) {
                begun = Some(cycles);
                engine.work_begins();
            }
            ports.offer(engine, self.su, beat, willing.sink)?;
            engine.settle()?;
            let found = ports.seen(engine)?;
            let wanted = Seen::from(model.step(beat.map(Beat::of_model), willing.sink));
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
        ports.offer(engine, self.su, None, false)?;
        engine.settle()?;
        let ended = ports.seen(engine)?;
        self.all_given(&jobs, ended.errors)?;
        let before = begun.unwrap_or(0);
        Ok(SplatRun {
            jobs,
            before,
            cycles: cycles - before,
            counters: ended.counters,
        })
    }
}

impl Drive<'_> {
    /// Whether no flag is up, and every job has all of its pixels.
    fn all_given(&self, jobs: &[Vec<SplatPixel>], errors: u64) -> Result<(), RtlError> {
        if errors != 0 {
            let text = format!("the splat unit raises the flags {errors:#b}");
            return Err(RtlError::Usage(text));
        }
        let pixels = (usize::from(self.last_slot) + 1) * TILE_PIXELS;
        if let Some(short) = jobs.iter().find(|job| job.len() != pixels) {
            let text = format!("the splat unit gave {} pixels of {pixels}", short.len());
            return Err(RtlError::Usage(text));
        }
        Ok(())
    }
}
