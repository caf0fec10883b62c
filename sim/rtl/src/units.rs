//! The generated hardware as the golden renderers' [`Units`].

use std::collections::BTreeMap;

use potamoi_cycles::{Stalls, runs};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT, Sums};
use potamoi_formats::units::VectorOp;
use potamoi_reference::gathering_unit::Reducer;
use potamoi_reference::splat_unit::{Composited, SplatJob, SplatUnitCounts};
use potamoi_reference::{GatherTask, Product, UnitCounts, UnitError, Units};

use super::compare::vector_flags;
use super::engine::EngineKind;
use super::gather::GatherUnit;
use super::model::RtlError;
use super::splats::SplatUnit;
use super::vector::VectorUnit;
use super::vector_drive::VectorBatch;

/// Cycles of the units with streams always ready, each call from reset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct RtlCycles {
    /// Gathering unit.
    pub gather: u64,
    /// Vector unit.
    pub vector: u64,
    /// Splat unit, from the first record to the last pixel of each job: pixels are clear and limits are written.
    pub splat: u64,
}

/// The units on an engine, each built at its first call.
pub struct RtlUnits {
    config: Config,
    engine: EngineKind,
    gather: Option<GatherUnit>,
    vector: Option<VectorUnit>,
    splat: Option<SplatUnit>,
    counts: UnitCounts,
    cycles: RtlCycles,
    flags: u64,
}

impl RtlUnits {
    /// The units of `config`, Verilated.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self::on(EngineKind::Verilator, config)
    }

    /// The units of `config` on an engine.
    #[must_use]
    pub fn on(engine: EngineKind, config: &Config) -> Self {
        Self {
            config: config.clone(),
            engine,
            gather: None,
            vector: None,
            splat: None,
            counts: UnitCounts::default(),
            cycles: RtlCycles::default(),
            flags: 0,
        }
    }

    /// Replaces the vector unit's netlist, for example by a faulty one.
    ///
    /// # Errors
    /// A missing or failing tool.
    pub fn with_vector_unit(
        mut self,
        module: &std::sync::Arc<potamoi_netlist::Module>,
    ) -> Result<Self, RtlError> {
        let unit = VectorUnit::of_module(self.engine, &self.config, module)?;
        self.vector = Some(unit);
        Ok(self)
    }

    /// Builds gathering unit and vector unit now, and the splat unit of a configuration with one.
    ///
    /// # Errors
    /// A missing or failing tool.
    pub fn instantiate(&mut self) -> Result<(), RtlError> {
        if self.gather.is_none() {
            self.gather = Some(GatherUnit::on(self.engine, &self.config)?);
        }
        if self.vector.is_none() {
            self.vector = Some(VectorUnit::on(self.engine, &self.config)?);
        }
        if let Some(su) = self.config.su.as_ref().filter(|_| self.splat.is_none()) {
            self.splat = Some(SplatUnit::on(self.engine, &self.config, su)?);
        }
        Ok(())
    }

    /// Whether the gathering unit, the vector unit and the splat unit were built.
    #[must_use]
    pub const fn instantiated(&self) -> [bool; 3] {
        [
            self.gather.is_some(),
            self.vector.is_some(),
            self.splat.is_some(),
        ]
    }

    /// Feature vectors and elements that the units returned.
    #[must_use]
    pub fn counts(&self) -> &UnitCounts {
        &self.counts
    }

    /// Cycles so far.
    #[must_use]
    pub fn cycles(&self) -> RtlCycles {
        self.cycles
    }

    /// The sticky flags that the gathering unit raised.
    #[must_use]
    pub fn gather_flags(&self) -> u64 {
        self.flags
    }

    /// Appends codes of the feature stream: features or unrounded sums.
    fn gathered(&mut self, tasks: &[GatherTask], out: &mut Vec<i32>) -> Result<(), RtlError> {
        let unit = match &mut self.gather {
            Some(unit) => unit,
            none => none.insert(GatherUnit::on(self.engine, &self.config)?),
        };
        for tasks in runs(tasks) {
            let run = unit.run(tasks, &Stalls::NONE, 0)?;
            self.counts.gathers += tasks.len() as u64;
            self.counts.feature_vectors += (run.features.len() / tasks[0].channels) as u64;
            self.cycles.gather += run.totals.cycles;
            self.flags |= run.totals.errors;
            out.extend(run.features);
        }
        Ok(())
    }

    fn computed(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), RtlError> {
        let unit = match &mut self.vector {
            Some(unit) => unit,
            none => none.insert(VectorUnit::on(self.engine, &self.config)?),
        };
        let run = unit.run(&[VectorBatch { op, a, b }], &Stalls::NONE, 0)?;
        if run.results.len() != out.len() || run.totals.errors != 0 {
            let raised: Vec<_> = vector_flags(run.totals.errors).collect();
            return Err(RtlError::Usage(format!(
                "{:?}: {} results for {} places, stat_errors = {:#b} {}",
                op.code,
                run.results.len(),
                out.len(),
                run.totals.errors,
                raised.join(", ")
            )));
        }
        out.copy_from_slice(&run.results);
        self.cycles.vector += run.totals.cycles;
        *elements(&mut self.counts.elements, op) += run.results.len() as u64;
        Ok(())
    }
}

impl RtlUnits {
    fn composited(&mut self, job: &SplatJob<'_>) -> Result<Composited, RtlError> {
        let usage = |text: &str| RtlError::Usage(text.to_owned());
        let su = self
            .config
            .su
            .as_ref()
            .ok_or_else(|| usage(NO_SPLAT_UNIT))?;
        let unit = match &mut self.splat {
            Some(unit) => unit,
            none => none.insert(SplatUnit::on(self.engine, &self.config, su)?),
        };
        let last = u16::try_from(job.tiles.saturating_sub(1)).unwrap_or(u16::MAX);
        let mut run = unit.check(&[job.entries], last, &job.settings, &Stalls::NONE, 0)?;
        let counters = run.counters;
        let counts = SplatUnitCounts {
            square_sums: counters.square_sums,
            exponentials: counters.exponentials,
            within_exact_limit: counters.drawn + counters.stopped,
            drawn: counters.drawn,
            stopped: counters.stopped,
        };
        self.cycles.splat += run.cycles;
        self.counts.splat_jobs += 1;
        self.counts.splats += counts;
        let pixels = run.jobs.pop().unwrap_or_default();
        self.counts.splat_pixels += pixels.len() as u64;
        Ok(Composited { pixels, counts })
    }
}

fn elements(map: &mut BTreeMap<potamoi_formats::units::OpCode, u64>, op: VectorOp) -> &mut u64 {
    map.entry(op.code).or_default()
}

impl Units for RtlUnits {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        let mut codes = vec![];
        self.gathered(tasks, &mut codes)?;
        match self.config.gu.sums {
            Sums::Rounded => features.extend(codes.into_iter().map(|code| code as i16)),
            Sums::Exact => {
                let reducer = Reducer::new(&self.config);
                features.extend(codes.into_iter().map(|sum| reducer.round(sum.into())));
            }
        }
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        match self.config.gu.sums {
            Sums::Exact => Ok(self.gathered(tasks, sums)?),
            Sums::Rounded => Err("gu.sums is \"rounded\": expected \"exact\"".into()),
        }
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        Ok(self.computed(op, a, b, out)?)
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        Ok(self.composited(job)?)
    }

    /// Computed in Rust: no unit does it.
    fn multiplied(&mut self, _product: Product) {}
}
