//! Comparison of bank organisations: cycles of each for the same gathers, and the memory bandwidth
//! that bounds them all.

use potamoi_formats::config::{
    Config, EntryKind, ExtraPorts, Modes, Organisation, RitPath, Sums, rules,
};
use potamoi_formats::rit::Vertices;
use potamoi_reference::observer::{GatherCall, Observer, SplatCall, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use crate::GatherCycles;
use crate::bank_rounds::waiting;
use crate::gather_work::{GatherWork, runs};

/// Bandwidth of the paper's memory in bytes a second: LPDDR3-1600, four channels of 32 bits.
pub(crate) const DRAM_BYTES_PER_SECOND: f64 = 25.6e9;

/// One organisation, with its counts so far.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Layout {
    /// The configuration's organisation.
    pub organisation: Organisation,
    /// Kind of its structured RIT entries.
    pub entry: EntryKind,
    /// Why the organisation cannot gather this; its counts stop there.
    pub refused: Option<String>,
    /// Banks `B`.
    pub banks: u32,
    /// Ports `M` of the ray index table; where channel-major, of the banks too.
    pub ports: u32,
    /// How more than two ports read a bank.
    pub extra_ports: ExtraPorts,
    /// Lanes `R`; feature-major organisation only.
    pub lanes: Option<u32>,
    /// Cycles from the first to the last issue, summed over runs (closed form, streams always
    /// ready).
    pub cycles: u64,
    /// Busy cycles, in which a vertex was issued.
    pub busy: u64,
    /// Stall cycles without a loaded MVoxel.
    pub stall_mft: u64,
    /// Stall cycles without an entry.
    pub stall_rit: u64,
    /// Stall cycles for banks.
    pub stall_bank: u64,
    /// Reads of concurrent lanes.
    pub reads: u64,
    /// Reads that wait for another row of their bank; 0 where banks cannot conflict.
    pub conflicts: u64,
    /// Reads that would wait if lanes could not share a read of the same row.
    pub conflicts_unshared: u64,
    /// Bytes of MVoxels loaded.
    pub mvoxel_bytes: u64,
    /// Bytes of ray index tables read from memory, repeated reads included.
    pub rit_bytes: u64,
    #[serde(skip)]
    config: Config,
}

impl Layout {
    fn of(config: Config) -> Self {
        let gu = &config.gu;
        Self {
            organisation: gu.organisation,
            entry: config.rit.entry,
            refused: None,
            banks: gu.banks,
            ports: gu.ports,
            extra_ports: gu.extra_ports,
            lanes: (gu.organisation == Organisation::FeatureMajor).then_some(gu.lanes),
            cycles: 0,
            busy: 0,
            stall_mft: 0,
            stall_rit: 0,
            stall_bank: 0,
            reads: 0,
            conflicts: 0,
            conflicts_unshared: 0,
            mvoxel_bytes: 0,
            rit_bytes: 0,
            config,
        }
    }

    /// The organisations to compare for a configuration: the paper's, with the configuration's
    /// ports and banks, also with compact entries; parity with both kinds of entry; for one port of
    /// 16 banks the feature-major one with 16 and 64 lanes, whose capacity and peak bandwidth equal
    /// that port's; and four ports with copies of the banks and with split banks. Those that the
    /// rules refuse are listed with the reason.
    #[must_use]
    pub fn all(config: &Config) -> Vec<Self> {
        let fit = |mut config: Config| {
            config.gu.fifo_depth = config.gu.fifo_depth.map(|depth| depth.max(8));
            config.gu.segments = 64;
            config.rit.stream_bits = None;
            let breaches = rules::check(&config);
            let refused = (!breaches.is_empty()).then(|| breaches.to_string());
            Self {
                refused,
                ..Self::of(config)
            }
        };
        // Plain units, with the paper's entries.
        let plain = || {
            let mut config = config.clone();
            config.rit.entry = EntryKind::Paper;
            config.gu.sums = Sums::Rounded;
            config.gu.records_a_row = 1;
            config.gu.pipelined = false;
            config.gu.extra_ports = ExtraPorts::Copies;
            config
        };
        let with = |organisation, banks, ports, lanes| {
            let mut config = plain();
            config.gu.organisation = organisation;
            (config.gu.banks, config.gu.ports, config.gu.lanes) = (banks, ports, lanes);
            fit(config)
        };
        let gu = &config.gu;
        let by = |organisation, entry| {
            let mut config = plain();
            config.rit.entry = entry;
            if organisation == Organisation::Parity {
                config.gu.modes = Modes::Structured;
                config.gu.vertices = vec![Vertices::Eight];
            }
            config.gu.organisation = organisation;
            fit(config)
        };
        let four = |extra| {
            let mut config = plain();
            config.gu.organisation = Organisation::ChannelMajor;
            (config.gu.ports, config.gu.extra_ports) = (4, extra);
            config.rit.entries = config.rit.entries.next_multiple_of(4);
            fit(config)
        };
        vec![
            with(Organisation::ChannelMajor, gu.banks, gu.ports, gu.lanes),
            by(Organisation::ChannelMajor, EntryKind::Compact),
            by(Organisation::Parity, EntryKind::Paper),
            by(Organisation::Parity, EntryKind::Compact),
            with(Organisation::ChannelMajor, 16, 1, gu.lanes),
            with(Organisation::FeatureMajor, 16, 2, 16),
            // So many ports that lanes are filled as fast as they are gathered.
            with(Organisation::FeatureMajor, 16, 4, 64),
            four(ExtraPorts::Copies),
            four(ExtraPorts::Split),
        ]
    }

    /// Conflict rate: conflicts over reads.
    #[must_use]
    pub fn conflict_rate(&self) -> f64 {
        self.conflicts as f64 / self.reads.max(1) as f64
    }

    /// Conflict rate if lanes could not share a read of the same row.
    #[must_use]
    pub fn unshared_rate(&self) -> f64 {
        self.conflicts_unshared as f64 / self.reads.max(1) as f64
    }

    /// Share of cycles lost to bank conflicts.
    #[must_use]
    pub fn lost(&self) -> f64 {
        self.stall_bank as f64 / self.cycles.max(1) as f64
    }

    /// Cycles of `clock_ghz` of reading MVoxels and ray index tables at the memory's bandwidth.
    #[must_use]
    pub fn bandwidth_cycles(&self, clock_ghz: f64) -> u64 {
        let seconds = (self.mvoxel_bytes + self.rit_bytes) as f64 / DRAM_BYTES_PER_SECOND;
        (seconds * clock_ghz * 1e9).ceil() as u64
    }

    /// From here on requires unrounded sums, as parts of cells do.
    fn demand_sums(&mut self) {
        if self.config.gu.sums == Sums::Rounded && self.refused.is_none() {
            self.config.gu.sums = Sums::Exact;
            let breaches = rules::check(&self.config);
            self.refused = (!breaches.is_empty()).then(|| breaches.to_string());
        }
    }

    /// Adds tasks that follow one another from reset.
    fn add(&mut self, tasks: &[GatherTask]) {
        if self.refused.is_none() {
            self.refused = self.count(tasks).err().map(|error| error.to_string());
        }
    }

    fn count(&mut self, tasks: &[GatherTask]) -> Result<(), UnitError> {
        let work = GatherWork::new(&self.config, tasks)?;
        let cycles: GatherCycles = work.predicted(&self.config)?;
        self.cycles += cycles.issue_span();
        self.busy += cycles.busy;
        self.stall_mft += cycles.stall_mft;
        self.stall_rit += cycles.stall_rit;
        self.stall_bank += cycles.stall_bank;
        let run = work.run();
        for (task, mvoxel) in tasks.iter().zip(run.mvoxels) {
            if self.lanes.is_some() {
                let found = waiting(&self.config, task.vertices, &task.entries);
                self.reads += found.reads;
                self.conflicts += found.rows;
                self.conflicts_unshared += found.unshared;
            }
            let again = run.streamed_again(&self.config, *mvoxel);
            let passes = if again { u64::from(run.segments) } else { 1 };
            let entry = self.config.entry_bytes(task.vertices) as u64;
            self.mvoxel_bytes += 2 * task.rows.len() as u64;
            if self.config.rit.path == RitPath::Dram {
                self.rit_bytes += passes * u64::from(mvoxel.entries) * entry;
            }
        }
        Ok(())
    }
}

/// Observer that counts every gather for several organisations.
pub struct Layouts {
    /// The organisations compared.
    pub layouts: Vec<Layout>,
    /// Entries gathered.
    pub samples: u64,
}

impl Layouts {
    /// An observer without counts.
    #[must_use]
    pub const fn new(layouts: Vec<Layout>) -> Self {
        Self {
            layouts,
            samples: 0,
        }
    }

    fn count(&mut self, tasks: &[GatherTask]) {
        for tasks in runs(tasks) {
            self.samples += tasks.iter().map(|t| t.entries.len() as u64).sum::<u64>();
            self.layouts
                .par_iter_mut()
                .for_each(|layout| layout.add(tasks));
        }
    }
}

impl Observer for Layouts {
    /// Organisations without unrounded sums are left out, with the reason, once sums are needed.
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        if call.codes.is_none() {
            self.layouts.iter_mut().for_each(Layout::demand_sums);
        }
        self.count(call.tasks);
        Ok(())
    }

    /// All organisations have the same vector unit.
    fn computed(&mut self, _: &VectorCall<'_>) -> Result<(), UnitError> {
        Ok(())
    }

    /// All organisations have the same splat unit.
    fn composited(&mut self, _: &SplatCall<'_>) -> Result<(), UnitError> {
        Ok(())
    }

    /// All organisations have the same MAC array.
    fn multiplied(&mut self, _: &Product) {}
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_reference::ReferenceUnits;
    use potamoi_reference::observer::Observed;
    use potamoi_scene::Scene;

    use super::*;

    /// Parts of samples are counted too; organisations that cannot sum them are left out with the
    /// reason.
    #[test]
    fn parts_of_samples_are_compared() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("split.toml");
        let model = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n";
        std::fs::write(&path, format!("{model}[render]\nhalo = \"split\"\n")).unwrap();
        let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
        scene.set_size(Some(16), Some(16)).unwrap();
        let config = Config::from_toml("[gu]\nsums = \"exact\"\n", "test").unwrap();
        let mut layouts = Layouts::new(Layout::all(&config));
        let mut twins = ReferenceUnits::new(&config);
        let mut units = Observed::new(&mut twins, &config).by(&mut layouts);
        scene.render_fixed(&config, &mut units).unwrap();
        assert_eq!(layouts.samples, twins.counts().feature_vectors);
        assert!(layouts.samples > 100);
        let own = &layouts.layouts[0];
        assert_eq!(own.refused, None);
        assert!(own.busy >= layouts.samples * 8 / u64::from(own.ports * 8));
        let mut compared = 0;
        for layout in &layouts.layouts {
            let sums = layout.organisation == Organisation::ChannelMajor
                && layout.entry == EntryKind::Paper;
            match &layout.refused {
                None => assert!(sums && layout.cycles > 0),
                Some(reason) => assert!(!sums && reason.contains("gu.sums = "), "{reason}"),
            }
            compared += usize::from(sums);
        }
        assert!(compared >= 3, "{compared}");
    }
}
