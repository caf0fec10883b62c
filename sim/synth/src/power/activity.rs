//! Switching activity: a share of a scene's work, with its golden results.

use std::collections::BTreeMap;

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::observer::{GatherCall, Observer, SplatCall, VectorCall};
use potamoi_reference::splat_unit::{ReferenceSplatUnit, SplatEntry, SplatJob, SplatSettings};
use potamoi_reference::{GatherTask, Product, UnitError};

/// MVoxels in a share: those with the most entries.
const MVOXELS: usize = 4;
/// Issue cycles of an MVoxel in a share: about as many as its rows take to load.
const ISSUES: usize = 512;
/// Runs of neighbouring elements in a share, and vectors of each.
const RUNS: usize = 4;
const VECTORS: usize = 16;
/// Records of a share of the splat unit's work.
const RECORDS: usize = 64;
/// Largest number of stored elements of an operation.
const ELEMENTS: usize = 1 << 20;

/// A share of a scene's work for the gathering unit.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct GatherWindow {
    pub(super) tasks: Vec<GatherTask>,
    /// Features or sums, in task and entry order, all channels of an entry together.
    pub(super) features: Vec<i32>,
}

/// A share of a scene's exponentials.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct VectorWindow {
    pub(super) op: Option<VectorOp>,
    /// Operands and results of each run.
    pub(super) runs: Vec<[Vec<i32>; 3]>,
}

/// A share of a scene's jobs for the splat unit: records in the tiles of a ray group.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SplatWindow {
    pub(super) settings: SplatSettings,
    /// Tiles of the job.
    pub(super) tiles: usize,
    pub(super) entries: Vec<SplatEntry>,
    /// Pairs that draw or stop a pixel.
    pub(super) counted: u64,
}

/// Tasks of one kind.
#[derive(Default)]
struct Gathered {
    /// Entries of all tasks.
    entries: u64,
    /// The largest tasks with their features.
    kept: Vec<(GatherTask, Vec<i32>)>,
}

/// Observer that samples a share of the units' work.
pub struct Sampler {
    config: Config,
    /// By vertices and channels.
    gathered: BTreeMap<(Vertices, usize), Gathered>,
    computed: BTreeMap<OpCode, (VectorOp, [Vec<i32>; 3])>,
    /// Begin of the longest job.
    composited: Option<(usize, SplatWindow)>,
}

impl Sampler {
    /// A sampler for units of a configuration.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            gathered: BTreeMap::new(),
            computed: BTreeMap::new(),
            composited: None,
        }
    }

    /// The share of the most frequent kind of gathering; `None` without gathers.
    #[must_use]
    pub fn gather_window(&self) -> Option<GatherWindow> {
        let most = self.gathered.iter().max_by_key(|(_, own)| own.entries);
        let ((vertices, channels), Gathered { kept, .. }) = most?;
        let entries = ISSUES * self.config.gu.ports as usize;
        let entries = entries / self.config.issue_cycles(*vertices).max(1) as usize;
        let mut window = GatherWindow::default();
        for (task, features) in kept {
            let count = task.entries.len().min(entries.max(1));
            let mut task = task.clone();
            task.entries.truncate(count);
            window.tasks.push(task);
            window.features.extend(&features[..count * channels]);
        }
        Some(window)
    }

    /// The begin of the longest job of the splat unit; `None` without any.
    #[must_use]
    pub fn splat_window(&self) -> Option<SplatWindow> {
        let (_, window) = self.composited.as_ref()?;
        let mut twin = ReferenceSplatUnit::new(&self.config.vu.exp, 0, window.settings);
        let job = SplatJob {
            settings: window.settings,
            tiles: window.tiles,
            entries: &window.entries,
        };
        let counts = twin.run(&job).counts;
        Some(SplatWindow {
            counted: counts.drawn + counts.stopped,
            ..window.clone()
        })
    }

    /// The share of the most frequent exponential; `None` without any.
    #[must_use]
    pub fn vector_window(&self) -> Option<VectorWindow> {
        let most = self.computed.values().max_by_key(|(_, all)| all[0].len());
        let (op, all) = most?;
        let lanes = self.config.vu.lanes as usize;
        let vectors = all[0].len() / lanes;
        let each = VECTORS.min(vectors / RUNS);
        if each == 0 {
            return None;
        }
        let runs = (0..RUNS).map(|run| {
            let from = run * (vectors - each) / RUNS * lanes;
            let part = |all: &Vec<i32>| all[from..from + each * lanes].to_vec();
            [part(&all[0]), part(&all[1]), part(&all[2])]
        });
        Some(VectorWindow {
            op: Some(*op),
            runs: runs.collect(),
        })
    }

    fn keep(&mut self, task: &GatherTask, features: Vec<i32>) {
        let kind = (task.vertices, task.channels);
        let Gathered { entries, kept } = self.gathered.entry(kind).or_default();
        *entries += task.entries.len() as u64;
        let place = kept.partition_point(|(k, _)| k.entries.len() >= task.entries.len());
        if place < MVOXELS {
            kept.insert(place, (task.clone(), features));
            kept.truncate(MVOXELS);
        }
    }
}

impl Observer for Sampler {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        call.each_task(|task, features| self.keep(task, features));
        Ok(())
    }

    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError> {
        let VectorCall { op, a, b, out } = *call;
        if op.code.is_exponential() {
            let kept = self.computed.entry(op.code);
            let (_, all) = kept.or_insert_with(|| (op, Default::default()));
            let room = ELEMENTS.saturating_sub(all[0].len()).min(a.len());
            for (kept, part) in all.iter_mut().zip([a, b, out]) {
                kept.extend(&part[..room]);
            }
        }
        Ok(())
    }

    fn composited(&mut self, call: &SplatCall<'_>) -> Result<(), UnitError> {
        let (settings, tiles) = (call.job.settings, call.job.tiles);
        let length = call.job.entries.len();
        if self
            .composited
            .as_ref()
            .is_none_or(|(most, _)| length > *most)
        {
            let entries = call.job.entries.iter().take(RECORDS);
            let window = SplatWindow {
                settings,
                tiles,
                entries: entries.copied().collect(),
                counted: 0,
            };
            self.composited = Some((length, window));
        }
        Ok(())
    }

    /// Products use neither unit.
    fn multiplied(&mut self, _: &Product) {}
}

impl GatherWindow {
    /// RIT entries.
    #[must_use]
    pub fn entries(&self) -> u64 {
        self.tasks.iter().map(|t| t.entries.len() as u64).sum()
    }

    /// Whether the work is the same bank by bank in a unit with fewer banks.
    pub(super) fn can_be_sliced(&self, config: &Config) -> bool {
        let organisation = config.organisation().0;
        let is_shared = |t: &GatherTask| config.records_a_row(t.vertices, t.channels) > 1;
        matches!(
            organisation,
            Organisation::Auto | Organisation::ChannelMajor
        ) && !self.tasks.iter().any(is_shared)
    }

    /// Of so many banks, those with a channel in every segment.
    pub(super) fn banks_of_last_segment(&self, banks: usize) -> usize {
        let channels = self.tasks.first().map_or(0, |t| t.channels);
        match channels % banks {
            0 => banks,
            some => some,
        }
    }

    /// The work of some banks of a unit with `config.gu.banks`.
    pub(super) fn of_banks(&self, config: &Config, banks: &[usize]) -> Self {
        let all = config.gu.banks as usize;
        let mut found = Self::default();
        let mut features = &self.features[..];
        for task in &self.tasks {
            let channels = task.channels;
            let picked: Vec<usize> = (0..channels.div_ceil(all))
                .flat_map(|segment| banks.iter().map(move |bank| segment * all + bank))
                .collect();
            // Banks past the last channel hold 0.
            let pick = |codes: &[i16]| -> Vec<i16> {
                let code = |c: &usize| codes.get(*c).copied().unwrap_or(0);
                picked.iter().map(code).collect()
            };
            let rows = task.rows.chunks(channels).flat_map(pick).collect();
            let (own, rest) = features.split_at(task.entries.len() * channels);
            features = rest;
            for codes in own.chunks(channels) {
                let code = |c: &usize| codes.get(*c).copied().unwrap_or(0);
                found.features.extend(picked.iter().map(code));
            }
            found.tasks.push(GatherTask {
                rows,
                channels: picked.len(),
                ..task.clone()
            });
        }
        found
    }
}

impl VectorWindow {
    /// Exponentials.
    #[must_use]
    pub fn elements(&self) -> u64 {
        self.runs.iter().map(|run| run[0].len() as u64).sum()
    }

    /// The work of some lanes of a unit with `all` lanes.
    pub(super) fn of_lanes(&self, all: usize, lanes: &[usize]) -> Self {
        let pick = |values: &Vec<i32>| -> Vec<i32> {
            let vectors = values.chunks(all);
            vectors
                .flat_map(|vector| lanes.iter().filter_map(|lane| vector.get(*lane).copied()))
                .collect()
        };
        Self {
            op: self.op,
            runs: self
                .runs
                .iter()
                .map(|run| [pick(&run[0]), pick(&run[1]), pick(&run[2])])
                .collect(),
        }
    }
}
