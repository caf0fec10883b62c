//! Organisations of the banks side by side: the same gathers, the cycles of
//! each, and the bandwidth that bounds them all.

use potamoi_formats::config::{
    Config, EntryKind, ExtraPorts, Modes, Organisation, RitPath, Sums, rules,
};
use potamoi_formats::rit::Vertices;
use potamoi_reference::observer::{GatherCall, Observer, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};
use rayon::prelude::*;
use serde::Serialize;

use crate::GatherCycles;
use crate::gather_work::{GatherWork, runs};
use crate::rounds::waiting;

/// Bytes a second of the paper's memory: LPDDR3-1600, four channels of 32 bits.
pub const DRAM_BYTES_PER_SECOND: f64 = 25.6e9;

/// One organisation, and what it takes for the gathers so far.
#[derive(Debug, Clone, Serialize)]
pub struct Layout {
    /// The configuration's organisation.
    pub organisation: Organisation,
    /// What a structured RIT entry says.
    pub entry: EntryKind,
    /// Why the organisation cannot gather this; what it counts stops there.
    pub refused: Option<String>,
    /// Banks `B`.
    pub banks: u32,
    /// Ports `M` of the ray index table; of the banks too, where channel-major.
    pub ports: u32,
    /// How more than two ports read a bank.
    pub extra_ports: ExtraPorts,
    /// Lanes `R`, of the feature-major organisation.
    pub lanes: Option<u32>,
    /// From the first to the last issue, sum over runs (cycle model, closed
    /// form, streams always ready).
    pub cycles: u64,
    /// Cycles in which a vertex was issued.
    pub busy: u64,
    /// Stalls for want of MVoxels, of entries, and for banks.
    pub stall_mft: u64,
    /// See `stall_mft`.
    pub stall_rit: u64,
    /// See `stall_mft`.
    pub stall_bank: u64,
    /// Reads of lanes side by side, and those that wait for another row of
    /// their bank; none where banks cannot conflict.
    pub reads: u64,
    /// See `reads`.
    pub conflicts: u64,
    /// Reads that would wait if lanes that want the same row did not share it.
    pub conflicts_unshared: u64,
    /// Bytes of MVoxels that are loaded.
    pub mvoxel_bytes: u64,
    /// Bytes of ray index tables that are read from memory, again where they are.
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

    /// The comparison for a configuration: the paper's organisation with the
    /// ports and banks of the configuration, also with compact entries; parity with
    /// both kinds of entry; and with one port of 16 banks the paper's again beside
    /// the feature-major one with 16 and 64 lanes, which have the capacity and the
    /// peak bandwidth of that port; and four ports with copies of the banks and with
    /// parts. What the rules refuse is there with the reason.
    #[must_use]
    pub fn all(config: &Config) -> Vec<Self> {
        let fit = |mut config: Config| {
            config.gu.fifo_depth = config.gu.fifo_depth.max(8);
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

    /// Conflicts over reads.
    #[must_use]
    pub fn conflict_rate(&self) -> f64 {
        self.conflicts as f64 / self.reads.max(1) as f64
    }

    /// The same if lanes that want the same row did not share it.
    #[must_use]
    pub fn unshared_rate(&self) -> f64 {
        self.conflicts_unshared as f64 / self.reads.max(1) as f64
    }

    /// The share of cycles that is lost at banks.
    #[must_use]
    pub fn lost(&self) -> f64 {
        self.stall_bank as f64 / self.cycles.max(1) as f64
    }

    /// Cycles that reading MVoxels and ray index tables takes at the memory's rate.
    #[must_use]
    pub fn bandwidth_cycles(&self) -> u64 {
        let seconds = (self.mvoxel_bytes + self.rit_bytes) as f64 / DRAM_BYTES_PER_SECOND;
        (seconds * f64::from(self.config.clock_mhz) * 1e6).ceil() as u64
    }

    /// From here on a unit that gives unrounded sums, as parts of cells need.
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

/// Counts every gather for several organisations.
pub struct Layouts {
    /// The organisations.
    pub layouts: Vec<Layout>,
    /// Entries gathered.
    pub samples: u64,
}

impl Layouts {
    /// Nothing is counted yet.
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
    /// What gives no unrounded sums is left out as soon as some are asked for, with the reason.
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        if call.codes.is_none() {
            self.layouts.iter_mut().for_each(Layout::demand_sums);
        }
        self.count(call.tasks);
        Ok(())
    }

    /// All organisations have one vector unit.
    fn computed(&mut self, _: &VectorCall<'_>) -> Result<(), UnitError> {
        Ok(())
    }

    /// Nor do they differ in the MAC array.
    fn multiplied(&mut self, _: &Product) {}
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_reference::Twins;
    use potamoi_reference::observer::Observed;
    use potamoi_scene::Scene;

    use super::*;

    /// Parts of samples are counted too; what cannot sum them is left out with the reason.
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
        let mut twins = Twins::new(&config);
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
