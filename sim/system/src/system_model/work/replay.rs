//! Replay of a frame's memory accesses on the memory model, beside the rates of sequential and
//! random accesses.

use std::collections::{HashMap, VecDeque};

use potamoi_base::mask::Mask;
use potamoi_formats::config::{Config, RitPath};
use potamoi_reference::observer::{GatherCall, Observed, Observer, SplatCall, VectorCall};
use potamoi_reference::{GatherTask, Product, ReferenceUnits, UnitError};
use potamoi_scene::{Scene, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::dram::Access;
use super::super::memory::{Memory, Rate};
use super::path::{PathError, PathOptions};
use super::path_cameras::seen_by;
use super::path_events::PathEvents;
use super::pixel_runs::PixelRuns;

/// Longest sequence in bursts; later ones are left out.
const MOST: usize = 200_000;
/// Address of RIT entries, after all MVoxels.
const TABLE: u64 = 1 << 30;
/// Bytes of a feature code.
const CODE: u64 = 2;

/// A sequence of accesses, by pattern rates and as replayed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Replayed {
    /// Bytes requested.
    pub bytes: u64,
    /// Nanoseconds and picojoules a byte by the rates of sequential and random accesses.
    pub at_rates: Rate,
    /// Nanoseconds and picojoules a byte as replayed.
    pub replayed: Rate,
    /// Bytes moved for each byte requested: bursts are whole, and a request for a burst in flight
    /// moves none.
    pub moved: f64,
}

/// Access sequences of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Replay {
    /// Misses of the GPU's cache in pixel-centric order; `None` without misses.
    pub missed: Option<Replayed>,
    /// Loads of the gathering unit: rows of MVoxels and their entries. `None` for models whose rows
    /// are fetched one by one, as tasks do not tell their addresses.
    pub loaded: Option<Replayed>,
}

/// Access sequences of a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PathReplay {
    /// Those of its first full frame.
    pub full: Replay,
    /// Those of the first frame that warping leaves incomplete, for its remaining pixels; `None`
    /// without such a frame.
    pub rest: Option<Replay>,
}

/// Loads of the gathering unit for the two frames that stand for a path, whatever the memory and the
/// GPU are: what is rendered once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PathLoads {
    full: Option<Requested>,
    rest: Option<Option<Requested>>,
}

/// Requested bytes, and the bursts of the first of them by number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Requested {
    bytes: u64,
    /// Bytes of a burst.
    burst: u64,
    bursts: Vec<u64>,
}

/// The first frame of a path that warping leaves incomplete, and its remaining pixels.
fn incomplete(events: &PathEvents) -> Option<(usize, &PixelRuns)> {
    let mut targets = events.path.targets.iter().zip(&events.targets);
    let number = targets.position(|(target, _)| target.work.is_some())?;
    Some((number, &events.targets[number]))
}

impl PathLoads {
    /// Loads of a path's first frame, and of its first incomplete one, in bursts of so many bytes.
    ///
    /// # Errors
    /// A scene, a path or a configuration that does not fit.
    pub(super) fn of(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        (events, burst): (&PathEvents, u64),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let of = |number: usize, only: Option<&Mask>| {
            Requested::of(&seen_by(scene, &path[number]), config, burst, only)
        };
        let rest = match incomplete(events) {
            Some((number, pixels)) => {
                let camera = &path[number];
                let mask = pixels.mask([camera.width, camera.height]);
                Some(of(number, Some(&mask))?)
            }
            None => None,
        };
        Ok(Self {
            full: of(0, None)?,
            rest,
        })
    }
}

impl Requested {
    /// Loads of what the scene's camera sees; `None` for models whose rows are fetched one by one.
    fn of(
        scene: &Scene,
        config: &Config,
        burst: u64,
        only: Option<&Mask>,
    ) -> Result<Option<Self>, SceneError> {
        let mut loads = Loads::new(config, burst);
        let mut twins = ReferenceUnits::new(config);
        let mut units = Observed::new(&mut twins, config).by(&mut loads);
        let rendered = match only {
            None => scene.render_fixed(config, &mut units)?,
            Some(mask) => scene.render_fixed_masked(config, mask, &mut units)?,
        };
        let is_streamed = rendered.counts.scattered_bytes == 0;
        Ok((is_streamed && loads.bytes > 0).then_some(Self {
            bytes: loads.bytes,
            burst: loads.burst,
            bursts: loads.bursts,
        }))
    }

    fn replayed(&self, memory: &Memory) -> Replayed {
        let accesses = self.bursts.iter().map(|own| read(own * self.burst));
        let accesses: Vec<Access> = accesses.collect();
        Replayed::new(memory, &accesses, self.bytes, memory.streamed())
    }
}

impl PathReplay {
    /// Replays a path; the two frames stand for all.
    ///
    /// # Errors
    /// A scene or a path that does not fit.
    pub(super) fn of(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        memory: &Memory,
        (events, loads): (&PathEvents, &PathLoads),
    ) -> Result<Self, PathError> {
        let path = scene.path(options.fps, options.frames)?;
        let of = |number: usize, only: Option<&Mask>, loads: Option<&Requested>| {
            let seen = seen_by(scene, &path[number]);
            let missed = seen.accesses(config, options.cache, only)?.first_misses;
            Ok::<_, SceneError>(Replay {
                missed: misses(&missed, memory),
                loaded: loads.map(|loads| loads.replayed(memory)),
            })
        };
        let rest = match incomplete(events) {
            Some((number, pixels)) => {
                let camera = &path[number];
                let mask = pixels.mask([camera.width, camera.height]);
                let loads = loads.rest.as_ref().and_then(Option::as_ref);
                Some(of(number, Some(&mask), loads)?)
            }
            None => None,
        };
        Ok(Self {
            full: of(0, None, loads.full.as_ref())?,
            rest,
        })
    }
}

impl Replay {
    /// Replays what the scene's camera sees, or a mask's pixels of it, through the reference units.
    /// `cache` is the size of the GPU's cache in bytes.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn of(
        scene: &Scene,
        config: &Config,
        cache: u32,
        memory: &Memory,
        only: Option<&Mask>,
    ) -> Result<Self, SceneError> {
        let missed = scene.accesses(config, cache, only)?.first_misses;
        let loads = Requested::of(scene, config, memory.burst_bytes(), only)?;
        Ok(Self {
            missed: misses(&missed, memory),
            loaded: loads.map(|loads| loads.replayed(memory)),
        })
    }
}

const fn read(address: u64) -> Access {
    Access {
        address,
        is_write: false,
    }
}

/// Replays vectors by address and size.
fn misses(vectors: &[(u64, u32)], memory: &Memory) -> Option<Replayed> {
    let bytes: u64 = vectors.iter().map(|(_, bytes)| u64::from(*bytes)).sum();
    if bytes == 0 {
        return None;
    }
    let mut behind = None;
    let mut streamed = 0;
    for (address, bytes) in vectors {
        if behind == Some(*address) {
            streamed += u64::from(*bytes);
        }
        behind = Some(address + u64::from(*bytes));
    }
    let random = memory.random(bytes as f64 / vectors.len() as f64);
    let at_rates = (memory.streamed()).mixed(streamed as f64 / bytes as f64, random);
    let burst = memory.burst_bytes();
    // A burst in flight is not requested again.
    let mut on_its_way = VecDeque::from(vec![u64::MAX; memory.waiting()]);
    let mut accesses = vec![];
    for (address, bytes) in vectors {
        for own in address / burst..=(address + u64::from(*bytes) - 1) / burst {
            if !on_its_way.contains(&own) {
                on_its_way.pop_front();
                on_its_way.push_back(own);
                accesses.push(read(own * burst));
            }
        }
    }
    Some(Replayed::new(memory, &accesses, bytes, at_rates))
}

impl Replayed {
    /// Replays `accesses`, which request so many bytes.
    fn new(memory: &Memory, accesses: &[Access], bytes: u64, at_rates: Rate) -> Self {
        let a_byte_moved = memory.measured(accesses.iter().copied());
        let moved = (accesses.len() as u64 * memory.burst_bytes()) as f64 / bytes as f64;
        Self {
            bytes,
            at_rates,
            replayed: a_byte_moved.over(moved),
            moved,
        }
    }
}

/// Loads of the gathering unit. MVoxels with the same rows are the same, and lie in memory in the
/// order of their first use, as their entries do.
struct Loads {
    config: Config,
    burst: u64,
    places: HashMap<Vec<i16>, u64>,
    /// First free bursts, for MVoxels and for entries.
    free: [u64; 2],
    bytes: u64,
    /// Numbers of the bursts in order.
    bursts: Vec<u64>,
}

impl Loads {
    fn new(config: &Config, burst: u64) -> Self {
        Self {
            config: config.clone(),
            burst,
            places: HashMap::new(),
            free: [0, TABLE / burst],
            bytes: 0,
            bursts: vec![],
        }
    }

    /// Interleaves both streams of a task.
    fn load(&mut self, task: &GatherTask) {
        if self.bursts.len() >= MOST {
            return;
        }
        let entries = match self.config.rit.path {
            RitPath::Dram => task.entries.len() * self.config.entry_bytes(task.vertices),
            RitPath::Direct => 0,
        } as u64;
        let rows = CODE * task.rows.len() as u64;
        self.bytes += rows + entries;
        let [rows, entries] = [rows, entries].map(|bytes| bytes.div_ceil(self.burst));
        let [place, table] = &mut self.free;
        let first = *self.places.entry(task.rows.clone()).or_insert_with(|| {
            let own = *place;
            *place += rows;
            own
        });
        let mut listed = 0;
        for i in 0..rows.max(1) {
            self.bursts.extend((i < rows).then_some(first + i));
            let upto = (i + 1) * entries / rows.max(1);
            self.bursts.extend((listed..upto).map(|e| *table + e));
            listed = upto;
        }
        *table += entries;
    }
}

impl Observer for Loads {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        call.tasks.iter().for_each(|task| self.load(task));
        Ok(())
    }

    /// Operands do not come from memory.
    fn computed(&mut self, _: &VectorCall<'_>) -> Result<(), UnitError> {
        Ok(())
    }

    /// Records come from the reorder buffer, and pixels are written once.
    fn composited(&mut self, _: &SplatCall<'_>) -> Result<(), UnitError> {
        Ok(())
    }

    /// Weights stay on chip.
    fn multiplied(&mut self, _: &Product) {}
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::rit::{RitEntry, Vertices};

    use super::*;

    /// Vectors behind each other are a stream; far apart they are runs at random places.
    #[test]
    fn misses_are_streams_or_runs() {
        let memory = Memory::with_channels(4);
        let list = |stride: u64| -> Vec<(u64, u32)> {
            (0..20_000).map(|i| (i * stride % (1 << 29), 64)).collect()
        };
        let streamed = misses(&list(64), &memory).unwrap();
        assert!((streamed.replayed.ns / memory.streamed().ns - 1.0).abs() < 0.02);
        // A step that is prime to the number of rows and banks.
        let random = misses(&list(64 * 104_729), &memory).unwrap();
        assert_eq!(random.at_rates.ns, memory.random(64.0).ns);
        let off = random.replayed.pj / random.at_rates.pj;
        assert!((off - 1.0).abs() < 0.1, "{off}");
        assert_eq!(misses(&[], &memory), None);
    }

    /// Codes of four bytes that lie in one burst ask for it once, while it is on its way.
    #[test]
    fn what_is_on_its_way_is_not_asked_for_again() {
        let memory = Memory::with_channels(4);
        let list: Vec<(u64, u32)> = (0..40_000).map(|i| (4 * i, 4)).collect();
        let found = misses(&list, &memory).unwrap();
        assert!((found.moved - 1.0).abs() < 1e-3, "{}", found.moved);
        // The same burst again after many others.
        let far = |i: u64| ((i % 2000) * 32, 4u32);
        let found = misses(&(0..8000).map(far).collect::<Vec<_>>(), &memory).unwrap();
        assert!((found.moved - 8.0).abs() < 1e-9, "{}", found.moved);
    }

    /// RIT entries and rows of an MVoxel are loaded side by side.
    #[test]
    fn both_streams_of_an_mvoxel_go_side_by_side() {
        let mut loads = Loads::new(&Config::paper(), 32);
        loads.load(&GatherTask {
            vertices: Vertices::Eight,
            channels: 16,
            rows: vec![0; 64],
            entries: vec![RitEntry {
                slot: 0,
                rows: [0; 8],
                weights: [0; 8],
            }],
        });
        let is_entry = |burst: &u64| burst * loads.burst >= TABLE;
        let found: Vec<bool> = loads.bursts.iter().map(is_entry).collect();
        assert_eq!(found, [false, false, true, false, false, true]);
        assert_eq!(loads.bytes, 128 + 48);
    }

    /// What is loaded for a frame is what is counted of it, and no stream is faster than one alone.
    #[test]
    fn loads_of_a_frame_are_those_counted() {
        let memory = Memory::with_channels(4);
        let config = Config::paper();
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(32), Some(32)).unwrap();
        let found = Replay::of(&scene, &config, 1 << 12, &memory, None).unwrap();
        let array = potamoi_cycles::mac_array::MacArray::PAPER;
        let work = super::super::FrameWork::count(&scene, &config, array, 1 << 12, None);
        let total = work.unwrap().total();
        let loaded = found.loaded.unwrap();
        assert_eq!(loaded.bytes, total.row_bytes + total.rit_bytes);
        assert!(loaded.replayed.ns >= 0.98 * loaded.at_rates.ns);
        let missed = found.missed.unwrap();
        assert!(missed.replayed.ns > memory.streamed().ns);
    }
}
