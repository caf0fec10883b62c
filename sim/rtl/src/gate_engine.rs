//! Runs a unit's gate-level netlist in the gate simulator, with the same comparison as every other
//! engine.

use potamoi_cycles::{Exponents, GatherWork, Plan, Stalls};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT};
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_gates::{Simulator, Watch};
use potamoi_reference::GatherTask;
use potamoi_reference::splat_unit::{SplatEntry, SplatSettings};

use super::compare::flags;
use super::engine::{Engine, Job, pass_on};
use super::gather_check::GatherCheck;
use super::gather_drive::{Drive, GatherTotals};
use super::model::RtlError;
use super::splats::{self, SplatRun};
use super::vector_check::VectorCheck;
use super::vector_drive::{self, VectorBatch, VectorTotals, Vectors};

/// A simulated netlist with named ports. Its observer sees the cycles after reset.
pub struct GateEngine<W> {
    /// The gate simulator.
    pub simulator: Simulator<W>,
}

impl<W: Watch> Engine for GateEngine<W> {
    type Port = usize;

    fn port(&self, name: &str) -> Result<usize, RtlError> {
        let ports = &self.simulator.flat.ports;
        let found = ports.iter().position(|p| p.name == name);
        found.ok_or_else(|| RtlError::Usage(format!("the netlist has no port {name}")))
    }

    fn words(&self, port: usize) -> usize {
        self.simulator.flat.ports[port].nets.len().div_ceil(32)
    }

    fn set(&mut self, port: usize, value: u64) -> Result<(), RtlError> {
        self.set_words(port, &[value as u32, (value >> 32) as u32])
    }

    fn get(&self, port: usize) -> Result<u64, RtlError> {
        let mut words = vec![0; self.words(port).max(2)];
        self.get_words(port, &mut words)?;
        Ok(u64::from(words[0]) | u64::from(words[1]) << 32)
    }

    fn set_words(&mut self, port: usize, value: &[u32]) -> Result<(), RtlError> {
        let flat = self.simulator.flat.clone();
        let bits = value.iter().flat_map(|w| (0..32).map(move |i| w >> i & 1));
        for (net, bit) in flat.ports[port].nets.iter().zip(bits) {
            self.simulator.set(*net, bit == 1);
        }
        Ok(())
    }

    fn get_words(&self, port: usize, value: &mut [u32]) -> Result<(), RtlError> {
        value.fill(0);
        for (i, net) in self.simulator.flat.ports[port].nets.iter().enumerate() {
            value[i / 32] |= u32::from(self.simulator.value(*net)) << (i % 32);
        }
        Ok(())
    }

    fn settle(&mut self) -> Result<(), RtlError> {
        Ok(self.simulator.settle()?)
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        Ok(self.simulator.edge()?)
    }

    fn reset(&mut self) -> Result<(), RtlError> {
        let reset = self.port("rst_n")?;
        self.set(reset, 0)?;
        for _ in 0..3 {
            self.settle()?;
            self.edge()?;
        }
        self.simulator.is_watched = true;
        self.set(reset, 1)
    }
}

/// A netlist whose observer sees nothing before the work begins.
struct FromWork<'e, W> {
    inner: &'e mut GateEngine<W>,
}

impl<W: Watch> Engine for FromWork<'_, W> {
    pass_on!(usize);

    fn work_begins(&mut self) {
        self.inner.simulator.is_watched = true;
    }

    fn settle(&mut self) -> Result<(), RtlError> {
        self.inner.settle()
    }

    fn edge(&mut self) -> Result<(), RtlError> {
        self.inner.edge()
    }

    fn reset(&mut self) -> Result<(), RtlError> {
        self.inner.reset()?;
        self.inner.simulator.is_watched = false;
        Ok(())
    }
}

impl<W: Watch> GateEngine<W> {
    /// Runs tasks through a gathering unit from reset with streams always ready. Compares every
    /// cycle with the stepwise cycle model and every beat with `features`, as
    /// [`GatherUnit::check`](super::GatherUnit::check) does.
    ///
    /// # Errors
    /// [`RtlError::Mismatch`] at the first difference, or a unit that hangs.
    pub fn gather<T: Copy + Into<i32>>(
        &mut self,
        config: &Config,
        tasks: &[GatherTask],
        features: &[T],
    ) -> Result<GatherTotals, RtlError> {
        let work = GatherWork::new(config, tasks)?;
        work.run().check(config)?;
        let progress = &mut |_| {};
        let drive = Drive {
            config,
            work: &work,
            plan: Plan::new(0, &Stalls::NONE)?,
            drain: 0,
            watch: &mut GatherCheck::new(config, &work, features, progress)?,
        };
        let totals = drive.run(self)?;
        flags(GATHERING_UNIT, totals.errors, 0, totals.cycles)?;
        Ok(totals)
    }

    /// Computes in a vector unit from reset with streams always ready. Compares every cycle with
    /// the stepwise cycle model and every result with `results`.
    ///
    /// # Errors
    /// As [`GateEngine::gather`].
    pub fn compute(
        &mut self,
        config: &Config,
        batches: &[VectorBatch<'_>],
        results: &[i32],
    ) -> Result<VectorTotals, RtlError> {
        let lanes = config.vu.lanes as usize;
        let vectors = Vectors::new(batches, lanes, &Exponents::of(config))?;
        let progress = &mut |_| {};
        let drive = vector_drive::Drive {
            vectors: &vectors,
            plan: Plan::new(0, &Stalls::NONE)?,
            drain: 0,
            watch: &mut VectorCheck::new(config, &vectors, results, progress)?,
        };
        let totals = drive.run(self)?;
        flags(VECTOR_UNIT, totals.errors, 0, totals.cycles)?;
        Ok(totals)
    }

    /// Composites a job in a splat unit from reset with streams always ready. Compares every cycle with
    /// the stepwise cycle model. The observer sees the cycles from the first record on: neither the
    /// pass that clears the pixels nor the words of the limits, which come once.
    ///
    /// # Errors
    /// As [`GateEngine::gather`].
    pub fn composite(
        &mut self,
        config: &Config,
        (entries, settings): (&[SplatEntry], &SplatSettings),
        last_slot: u16,
    ) -> Result<SplatRun, RtlError> {
        let su = config.su.as_ref();
        let su = su.ok_or_else(|| RtlError::Usage(NO_SPLAT_UNIT.to_owned()))?;
        let jobs = [entries];
        let drive = splats::Drive::ready((config, su), &jobs, last_slot, settings)?;
        drive.run(&mut FromWork { inner: self })
    }

    /// Idle cycles that continue from the current state; of the inputs in `valid`, those that exist
    /// are 0.
    ///
    /// # Errors
    /// A memory that cannot be interpreted.
    pub fn rest(&mut self, valid: &[&str], cycles: u64) -> Result<(), RtlError> {
        for name in valid {
            if let Ok(port) = self.port(name) {
                self.set(port, 0)?;
            }
        }
        for _ in 0..cycles {
            self.edge()?;
            self.settle()?;
        }
        Ok(())
    }
}
