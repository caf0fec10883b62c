//! Power of a unit from its netlists and work.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use potamoi_formats::config::{Config, rules};
use potamoi_gates::Flat;
use potamoi_netlist::Module;
use potamoi_result_cache as result_cache;

use super::library::PowerLibrary;
use super::measure::{Measured, Work, measure};
use super::multiply::MultiplyWindow;
use super::order::{Extent, Order};
use super::static_data::{StaticData, named_loads};
use super::total::Ran;
use super::unavailable::Unavailable;
use crate::cache_keys::PowerInputs;
use crate::error::cannot_keep;
use crate::mapped_netlist::Mapping;
use crate::power_report::{Power, PowerReport};
use crate::unit::remade_with_names;
use crate::{SynthError, SynthesisedUnit, UnitKind};

/// Banks and lanes of the slices.
const BANKS: [u32; 2] = [2, 4];
const LANES: [u32; 2] = [1, 2];

/// Steps of an estimate from slices that [`Order::step`] reports.
pub const POWER_STEPS: u64 = 2 * 3;

/// Power of a unit.
#[derive(Debug)]
pub struct Estimated {
    /// The power.
    pub power: Power,
    /// The unit, where it was synthesised again for it: nets of the unit are found by name in its
    /// slices, and the cached unit had other names.
    pub remade: Option<SynthesisedUnit>,
}

/// Estimates the power of a unit; cached in `cache` by the netlists of the modules and by work, so
/// that names of nets change nothing.
///
/// # Errors
/// A program fails, files cannot be written, the library is corrupt, or the netlist differs from
/// the golden model.
pub fn estimate(order: &Order<'_>, cache: &Path) -> Result<Estimated, SynthError> {
    let windows = &order.windows;
    let work = match order.unit {
        UnitKind::Gathering => windows.gather.cloned().map(Work::Gather),
        UnitKind::Vector => windows.vector.cloned().map(Work::Vector),
        UnitKind::ArrayMac => (windows.gather).map(|own| Work::Multiply(MultiplyWindow::of(own))),
        UnitKind::Splat => windows.splat.cloned().map(Work::Splat),
    };
    let Some(work) = work else {
        let absent = format!("the scene {} has too little work for it", order.scene);
        return Ok(Estimated {
            power: Power::Absent { absent },
            remade: None,
        });
    };
    let planned = order.parts(&work, cache)?;
    let kept = order.inputs(&planned).key().file(cache, "json");
    if let Some(power) = result_cache::read(&kept) {
        let remade = None;
        return Ok(Estimated { power, remade });
    }
    let remade = order.with_names(&planned, cache)?;
    let order = Order {
        made: remade.as_ref().unwrap_or(order.made),
        ..*order
    };
    let kept = order.inputs(&planned).key().file(cache, "json");
    let parts = planned.into_iter().map(|part| part.made(&order));
    let parts: Vec<Part> = parts.collect::<Result<_, _>>()?;
    let power = match order.compute(&work, &parts, &measure) {
        Ok(report) => Power::Estimated(Box::new(report)),
        Err(Unavailable::Absent(absent)) => Power::Absent { absent },
        Err(Unavailable::Wrong(error)) => return Err(error),
    };
    std::fs::create_dir_all(cache).map_err(cannot_keep(cache))?;
    result_cache::write(&kept, &power).map_err(cannot_keep(&kept))?;
    // As it is read again, so that nothing depends on whether it was kept.
    let power = result_cache::read(&kept).unwrap_or(power);
    Ok(Estimated { power, remade })
}

/// A part to simulate, before its netlist is made.
struct Planned<'a> {
    size: u64,
    config: Config,
    module: Arc<Module>,
    works: Vec<(f64, Work)>,
    /// How a slice is mapped; `None` is the whole unit.
    mapping: Option<Mapping<'a>>,
}

impl Planned<'_> {
    fn made(self, order: &Order<'_>) -> Result<Part, SynthError> {
        let netlist = match &self.mapping {
            None => order.made.netlist.clone(),
            Some(mapping) => {
                let netlist = mapping.made()?;
                (order.step)();
                netlist
            }
        };
        Ok(Part {
            size: self.size,
            config: self.config,
            netlist,
            module: self.module,
            works: self.works,
        })
    }
}

/// A netlist to simulate, with its work, run after run.
pub(super) struct Part {
    /// Banks or lanes.
    pub(super) size: u64,
    pub(super) config: Config,
    pub(super) netlist: String,
    pub(super) module: Arc<Module>,
    /// Work of each run, with its weight in the energy.
    pub(super) works: Vec<(f64, Work)>,
}

/// Simulates work on a netlist, with delays or without.
pub(super) type Measure = dyn Fn(&StaticData, &Config, &Work, bool) -> Result<Measured, SynthError>;

/// Banks or lanes of slices of two sizes for each of the unit's kinds, with weights. Both sizes
/// cover the same ones: the larger slice all at once, the smaller one some at a time.
pub(super) fn sets(kinds: &[(f64, Range<usize>)], sizes: [u32; 2]) -> [Vec<(f64, Vec<usize>)>; 2] {
    let parts = (sizes[1] / sizes[0]) as usize;
    let mut sets = [vec![], vec![]];
    for (share, range) in kinds {
        let picked = |i: usize| range.start + i * range.len() / sizes[1] as usize;
        let picked: Vec<usize> = (0..sizes[1] as usize).map(picked).collect();
        for first in 0..parts {
            let part = picked.iter().skip(first).step_by(parts);
            sets[0].push((share / parts as f64, part.copied().collect()));
        }
        sets[1].push((*share, picked));
    }
    sets
}

impl<'a> Order<'a> {
    /// Banks or lanes of the unit.
    pub(super) fn size(&self) -> u32 {
        match self.unit {
            UnitKind::Gathering => self.config.gu.banks,
            UnitKind::Vector => self.config.vu.lanes,
            UnitKind::ArrayMac | UnitKind::Splat => 1,
        }
    }

    /// The slices of a unit, the smaller first; or the whole unit.
    fn parts(&self, work: &Work, cache: &'a Path) -> Result<Vec<Planned<'a>>, SynthError> {
        let all = self.size();
        let (sizes, can) = match work {
            Work::Gather(window) => (BANKS, window.can_be_sliced(self.config)),
            // The slowest lane decides when a vector is done.
            Work::Vector(_) => (LANES, !self.config.vu.exp.early_out),
            Work::Multiply(_) | Work::Splat(_) => ([1, 1], false),
        };
        let configs = sizes.map(|size| self.slice(size));
        let is_whole = self.extent == Extent::Whole
            || !can
            || all <= sizes[1]
            || configs.iter().any(|c| !rules::check(c).is_empty());
        if is_whole {
            return Ok(vec![Planned {
                size: all.into(),
                config: self.config.clone(),
                module: self.unit.module(self.config)?,
                works: vec![(1.0, work.clone())],
                mapping: None,
            }]);
        }
        let sets = sets(&work.kinds(all as usize), sizes);
        let mut parts = vec![];
        for ((config, size), sets) in configs.into_iter().zip(sizes).zip(sets) {
            let module = self.unit.module(&config)?;
            let own = |(share, set): (f64, Vec<usize>)| {
                let work = match work {
                    Work::Gather(w) => Work::Gather(w.of_banks(self.config, &set)),
                    Work::Vector(w) => Work::Vector(w.of_lanes(all as usize, &set)),
                    // Never in slices.
                    Work::Multiply(_) | Work::Splat(_) => work.clone(),
                };
                (share, work)
            };
            let mapping = Mapping::new(&module, self.unit.top(), self.library, self.tools, cache);
            parts.push(Planned {
                size: size.into(),
                works: sets.into_iter().map(own).collect(),
                config,
                module,
                mapping: Some(mapping),
            });
        }
        Ok(parts)
    }

    fn slice(&self, size: u32) -> Config {
        let mut config = self.config.clone();
        match self.unit {
            UnitKind::Gathering => config.gu.banks = size,
            UnitKind::Vector => config.vu.lanes = size,
            UnitKind::ArrayMac | UnitKind::Splat => {}
        }
        config
    }

    /// The unit with the names of today, where it is composed of slices and was made with others.
    fn with_names(
        &self,
        parts: &[Planned<'_>],
        cache: &Path,
    ) -> Result<Option<SynthesisedUnit>, SynthError> {
        if parts.iter().all(|part| part.mapping.is_none()) {
            return Ok(None);
        }
        let Self {
            made,
            config,
            unit,
            library,
            tools,
            ..
        } = self;
        remade_with_names(made, config, *unit, library, tools, cache)
    }

    /// Cache inputs of an estimate.
    fn inputs<'p>(&'p self, parts: &'p [Planned<'_>]) -> PowerInputs<'p, Work> {
        let key = |part: &Planned<'_>| match &part.mapping {
            None => self.made.key.clone(),
            Some(mapping) => mapping.key().hex(),
        };
        PowerInputs {
            unit: self.unit,
            library: &self.library.sha256,
            scene: self.scene,
            report: &self.made.report,
            config: self.config,
            netlist: &self.made.key,
            parts: (parts.iter())
                .map(|part| (key(part), &*part.works))
                .collect(),
        }
    }

    /// Simulates the parts with `measure`, and adds up.
    pub(super) fn compute(
        &self,
        work: &Work,
        parts: &[Part],
        measure: &Measure,
    ) -> Result<PowerReport, Unavailable> {
        let mut ran = vec![];
        for (part, still) in parts.iter().zip(self.stills(parts)?) {
            let runs = [false, true].map(|is_delayed| -> Result<Vec<Measured>, SynthError> {
                let run = |(_, work): &_| measure(&still, &part.config, work, is_delayed);
                let found = part.works.iter().map(run).collect();
                (self.step)();
                found
            });
            let [zero, glitches] = runs;
            ran.push(Ran {
                size: part.size,
                still,
                shares: part.works.iter().map(|(share, _)| *share).collect(),
                runs: [zero?, glitches?],
            });
        }
        self.report(work, &ran)
    }

    /// The parts' netlists. Nets that fan out to all banks or lanes are slower in the whole unit.
    fn stills(&self, parts: &[Part]) -> Result<Vec<StaticData>, Unavailable> {
        let library = PowerLibrary::read(self.library)?;
        let whole = match parts {
            [_] => BTreeMap::new(),
            _ => {
                let module = self.unit.module(self.config).map_err(SynthError::from)?;
                named_loads(&library, &self.flat(&library, &self.made.netlist, &module)?)?
            }
        };
        let still = |part: &Part| {
            let flat = self.flat(&library, &part.netlist, &part.module)?;
            StaticData::new(&library, &Arc::new(flat), &whole)
        };
        parts.iter().map(still).collect()
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
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 13 of 32 banks have a channel; four of each kind are simulated, in pairs in the smaller
    /// slice.
    #[test]
    fn slices_have_the_same_banks_and_share_one_unit() {
        let kinds = [(13.0 / 32.0, 0..13), (19.0 / 32.0, 13..32)];
        let [small, large] = sets(&kinds, BANKS);
        let banks = |sets: &[(f64, Vec<usize>)]| -> Vec<Vec<usize>> {
            sets.iter().map(|(_, banks)| banks.clone()).collect()
        };
        assert_eq!(banks(&large), [[0, 3, 6, 9], [13, 17, 22, 27]]);
        assert_eq!(banks(&small), [[0, 6], [3, 9], [13, 22], [17, 27]]);
        for sets in [&small, &large] {
            let sum: f64 = sets.iter().map(|(share, _)| share).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sets:?}");
        }
        assert!((small[0].0 - 13.0 / 64.0).abs() < 1e-12);
    }
}
