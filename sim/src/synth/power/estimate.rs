//! From a unit's netlists and work to its power.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_formats::config::{Config, rules};
use potamoi_hdl::ir::Module;

use crate::synth::gates::{Flat, netlist};
use crate::synth::{Library, SynthError, Tools, UnitKind, UnitReport};

use super::Lack;
use super::activity::{GatherWindow, VectorWindow};
use super::compose::{Slice, compose};
use super::count::Energies;
use super::library::PowerLibrary;
use super::measure::{Measured, Work, measure};
use super::report::{Activity, Figures, ModulePower, Power, PowerReport};
use super::still::{Still, named_loads};

/// Version of what is kept of an estimate.
const KEPT: &str = "potamoi-power 3";
/// Banks and lanes of the slices.
const BANKS: [u32; 2] = [2, 4];
const LANES: [u32; 2] = [1, 2];

/// How much of a unit is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Two slices of few banks or lanes, of which the unit is composed; the whole unit
    /// where it has no more, or cannot be sliced.
    Slices,
    /// All of it.
    Whole,
}

/// What is to be estimated.
pub struct Order<'a> {
    /// The configuration.
    pub config: &'a Config,
    /// Its unit.
    pub unit: UnitKind,
    /// Its cells.
    pub library: &'a Library,
    /// What maps slices.
    pub tools: &'a Tools,
    /// What was made of the unit, and its netlist.
    pub made: (&'a UnitReport, &'a str),
    /// The scene whose work it is.
    pub scene: &'a str,
    /// Work for the gathering unit, and for the vector unit.
    pub windows: (Option<&'a GatherWindow>, Option<&'a VectorWindow>),
    /// How much is simulated.
    pub extent: Extent,
    /// Called after each step that was taken: a slice mapped, a netlist run without delays
    /// or with them.
    pub step: &'a dyn Fn(),
}

/// Steps of an estimate from slices that [`Order::step`] is told of.
pub const POWER_STEPS: u64 = 2 * 3;

/// Estimates the power of a unit, or finds what an earlier run on the same netlists and
/// work left in `cache`.
///
/// # Errors
/// A program fails, files cannot be written, the library is corrupt, or the netlist
/// computes something else than the golden model.
pub fn estimate(order: &Order<'_>, cache: &Path) -> Result<Power, SynthError> {
    let work = match (order.unit, order.windows) {
        (UnitKind::Gathering, (Some(window), _)) => Work::Gather(window.clone()),
        (UnitKind::Vector, (_, Some(window))) => Work::Vector(window.clone()),
        _ => {
            return Ok(Power::Absent {
                absent: format!("the scene {} has too little work for it", order.scene),
            });
        }
    };
    let parts = order.parts(&work, cache)?;
    let cannot = |path: &Path| {
        let path = path.to_owned();
        move |source| SynthError::File { path, source }
    };
    let kept = cache.join(format!("{}-power-{}.json", order.unit, order.key(&parts)));
    if let Some(power) = read_kept(&kept) {
        return Ok(power);
    }
    let power = match order.compute(&work, &parts) {
        Ok(report) => Power::Estimated(Box::new(report)),
        Err(Lack::Absent(absent)) => Power::Absent { absent },
        Err(Lack::Wrong(error)) => return Err(error),
    };
    std::fs::create_dir_all(cache).map_err(cannot(cache))?;
    let json = serde_json::to_vec_pretty(&power).map_err(|e| cannot(&kept)(e.into()))?;
    potamoi_golden::files::write(&kept, &json).map_err(cannot(&kept))?;
    // As it is read again, so that nothing depends on whether it was kept.
    Ok(read_kept(&kept).unwrap_or(power))
}

fn read_kept(path: &Path) -> Option<Power> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

/// A netlist to be run, and the work that it is given, run after run.
struct Part {
    /// Banks or lanes.
    size: u64,
    config: Config,
    netlist: String,
    module: Arc<Module>,
    /// Each with its share of the energy.
    works: Vec<(f64, Work)>,
}

impl Order<'_> {
    /// Banks or lanes of the unit.
    fn size(&self) -> u32 {
        match self.unit {
            UnitKind::Gathering => self.config.gu.banks,
            UnitKind::Vector => self.config.vu.lanes,
        }
    }

    /// The slices of a unit, the smaller first; or the whole of it.
    fn parts(&self, work: &Work, cache: &Path) -> Result<Vec<Part>, SynthError> {
        let all = self.size();
        let (sizes, can) = match work {
            Work::Gather(window) => (BANKS, window.can_be_sliced(self.config)),
            // The slowest lane decides when a vector is done.
            Work::Vector(_) => (LANES, !self.config.vu.exp.early_out),
        };
        let configs = sizes.map(|size| self.slice(size));
        let is_whole = self.extent == Extent::Whole
            || !can
            || all <= sizes[1]
            || configs.iter().any(|c| !rules::check(c).is_empty());
        if is_whole {
            return Ok(vec![Part {
                size: all.into(),
                config: self.config.clone(),
                netlist: self.made.1.to_owned(),
                module: self.unit.module(self.config)?,
                works: vec![(1.0, work.clone())],
            }]);
        }
        // The same banks in both: the larger slice has them all, the smaller one half of
        // them at a time.
        let halves = (sizes[1] / sizes[0]) as usize;
        let mut sets = [vec![], vec![]];
        for (share, range) in work.kinds(all as usize) {
            let picked = |i: usize| range.start + i * range.len() / sizes[1] as usize;
            let picked: Vec<usize> = (0..sizes[1] as usize).map(picked).collect();
            for first in 0..halves {
                let half = picked.iter().skip(first).step_by(halves);
                sets[0].push((share / halves as f64, half.copied().collect()));
            }
            sets[1].push((share, picked));
        }
        let mut parts = vec![];
        for ((config, size), sets) in configs.into_iter().zip(sizes).zip(sets) {
            let module = self.unit.module(&config)?;
            let own = |(share, set): (f64, Vec<usize>)| {
                let work = match work {
                    Work::Gather(w) => Work::Gather(w.of_banks(self.config, &set)),
                    Work::Vector(w) => Work::Vector(w.of_lanes(all as usize, &set)),
                };
                (share, work)
            };
            let netlist = netlist(&module, self.unit.top(), self.library, self.tools, cache)?;
            (self.step)();
            parts.push(Part {
                size: size.into(),
                netlist,
                works: sets.into_iter().map(own).collect(),
                config,
                module,
            });
        }
        Ok(parts)
    }

    fn slice(&self, size: u32) -> Config {
        let mut config = self.config.clone();
        match self.unit {
            UnitKind::Gathering => config.gu.banks = size,
            UnitKind::Vector => config.vu.lanes = size,
        }
        config
    }

    /// Of everything that an estimate depends on.
    fn key(&self, parts: &[Part]) -> String {
        let mut key = blake3::Hasher::new();
        let mut with = |part: &str| {
            key.update(&(part.len() as u64).to_le_bytes());
            key.update(part.as_bytes());
        };
        let (report, _) = self.made;
        let modules = serde_json::to_string(report).unwrap_or_default();
        let origins = [KEPT, &self.library.sha256, self.scene, &modules];
        origins.into_iter().for_each(&mut with);
        with(&format!("{:?}", self.config));
        with(self.made.1);
        for part in parts {
            with(&part.netlist);
            with(&format!("{:?}", part.works));
        }
        key.finalize().to_hex()[..32].to_owned()
    }

    fn compute(&self, work: &Work, parts: &[Part]) -> Result<PowerReport, Lack> {
        let library = PowerLibrary::read(self.library)?;
        let mut found = vec![];
        // Nets that leave a module for all banks or lanes are slower in the whole unit.
        let whole = match parts {
            [_] => BTreeMap::new(),
            _ => {
                let module = self.unit.module(self.config).map_err(SynthError::from)?;
                named_loads(&library, &self.flat(&library, self.made.1, &module)?)?
            }
        };
        for part in parts {
            let flat = self.flat(&library, &part.netlist, &part.module)?;
            let still = Still::new(&library, &Arc::new(flat), &whole)?;
            let runs = [false, true].map(|is_delayed| -> Result<Vec<Measured>, SynthError> {
                let run = |(_, work): &_| measure(&still, &part.config, work, is_delayed);
                let found = part.works.iter().map(run).collect();
                (self.step)();
                found
            });
            let [zero, glitches] = runs;
            let shares: Vec<f64> = part.works.iter().map(|(share, _)| *share).collect();
            found.push((part.size, still, shares, [zero?, glitches?]));
        }
        let nothing = || Lack::Absent("nothing was simulated".to_owned());
        let (_, largest, shares, runs) = found.last().ok_or_else(nothing)?;
        let last = runs[0].first().ok_or_else(nothing)?;
        let mut ways = vec![];
        for way in 0..2 {
            let of = |pick: fn(&Measured) -> &[Energies]| -> Result<_, Lack> {
                let slices = found.iter().map(|(size, still, shares, runs)| {
                    let slice = |m| Slice::new(*size, still, pick(m));
                    let all: Vec<Slice> = runs[way].iter().map(slice).collect();
                    Slice::mean(&all, shares).ok_or_else(nothing)
                });
                self.whole(&slices.collect::<Result<Vec<_>, _>>()?)
            };
            let toggles = runs[way].iter().zip(shares).map(|(m, s)| s * m.toggles);
            let at_work = of(|m| &m.energies)?;
            let at_rest = of(|m| &m.at_rest)?;
            ways.push((at_work, at_rest, toggles.sum()));
        }
        let [zero, glitches] = [&ways[0], &ways[1]];
        let leakage_nw = zero.0.values().map(|(_, leakage)| leakage).sum();
        let clock_ghz = (f64::from(self.config.clock_mhz) / 1e3).min(self.made.0.clock_ghz);
        let figures = |way: &(Whole, Whole, f64)| {
            let sum = |whole: &Whole| {
                let all = whole.values().map(|(energies, _)| *energies);
                all.fold(Energies::default(), Energies::plus).times(1e-3)
            };
            let (at_work, at_rest) = (sum(&way.0), sum(&way.1));
            Figures {
                toggles_a_net: way.2,
                switching_pj_a_cycle: at_work.switching,
                internal_pj_a_cycle: at_work.internal,
                clock_pj_a_cycle: at_work.clock,
                pj_a_cycle: at_work.total(),
                rest_pj_a_cycle: at_rest.total(),
                pj_an_item: at_work.total() * last.cycles as f64 / work.items() as f64,
                mw: at_work.total() * clock_ghz + leakage_nw * 1e-6,
            }
        };
        let (report, _) = self.made;
        let modules = report.modules.iter().map(|module| {
            let of = |whole: &Whole| whole.get(&module.module).copied().unwrap_or_default();
            let (energies, leakage_nw) = of(&zero.0);
            ModulePower {
                module: module.module.clone(),
                count: module.count,
                zero_delay_pj_a_cycle: energies.total() * 1e-3,
                with_glitches_pj_a_cycle: of(&glitches.0).0.total() * 1e-3,
                leakage_nw,
            }
        });
        Ok(PowerReport {
            clock_ghz,
            volts: largest.units.volts,
            activity: Activity {
                scene: self.scene.to_owned(),
                work: describe(work),
                simulated: found.iter().map(|(size, ..)| self.named(*size)).collect(),
                cycles: last.cycles,
                busy: last.busy,
                item: self.item().to_owned(),
                items: work.items(),
                channels: channels(work),
            },
            leakage_nw,
            zero_delay: figures(zero),
            with_glitches: figures(glitches),
            modules: modules.collect(),
        })
    }

    fn flat(
        &self,
        library: &PowerLibrary,
        netlist: &str,
        module: &Module,
    ) -> Result<Flat, SynthError> {
        let memories = module.memory_modules();
        let flat = Flat::new(netlist, self.unit.top(), &library.gates, &memories);
        flat.map_err(|problem| SynthError::Gates {
            unit: self.unit.to_string(),
            library: self.library.name.clone(),
            problem,
        })
    }

    /// The whole unit from its slices, or from itself.
    fn whole(&self, slices: &[Slice]) -> Result<Whole, Lack> {
        let (report, _) = self.made;
        match slices {
            [small, large] => {
                let pair = [small.clone(), large.clone()];
                compose(&pair, self.size().into(), &report.modules).map_err(|module| {
                    Lack::Absent(format!("its module {module} is in no slice of it"))
                })
            }
            _ => {
                let pieces = slices.iter().flat_map(|slice| &slice.pieces);
                Ok(pieces
                    .map(|(name, piece)| (name.clone(), (piece.energies, piece.leakage)))
                    .collect())
            }
        }
    }

    fn named(&self, size: u64) -> String {
        let name = match self.unit {
            UnitKind::Gathering => "bank",
            UnitKind::Vector => "lane",
        };
        let s = if size == 1 { "" } else { "s" };
        format!("{size} {name}{s}")
    }

    const fn item(&self) -> &'static str {
        match self.unit {
            UnitKind::Gathering => "sample",
            UnitKind::Vector => "exponential",
        }
    }
}

/// Energies in femtojoules a cycle and leakage in nanowatts, by kind of module.
type Whole = BTreeMap<String, (Energies, f64)>;

fn channels(work: &Work) -> u64 {
    match work {
        Work::Gather(window) => window.tasks.first().map_or(0, |t| t.channels as u64),
        Work::Vector(_) => 0,
    }
}

fn describe(work: &Work) -> String {
    match work {
        Work::Gather(window) => {
            let vertices = window.tasks.first().map_or(0, |t| t.vertices.count());
            let channels = channels(work);
            format!(
                "{} entries of {} MVoxels, the largest of the frame, {vertices} vertices each, \
                 {channels} channels",
                window.entries(),
                window.tasks.len()
            )
        }
        Work::Vector(window) => format!(
            "{} operations `{}` in {} runs of the frame",
            window.elements(),
            window.op.map_or("", |op| op.code.name()),
            window.runs.len()
        ),
    }
}
