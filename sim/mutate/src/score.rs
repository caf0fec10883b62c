//! The judges in turn, and what each finds.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use potamoi_formats::config::Config;
use potamoi_prove::Unit;
use schemars::JsonSchema;
use serde::Serialize;

use crate::all_operands::AllOperands;
use crate::bench::Bench;
use crate::equivalence::{Miter, Miters};
use crate::proofs::Systems;
use crate::record::{Kept, Record};
use crate::unit_miter::UnitMiter;
use crate::{Design, Draw, Fate, Judge, Mutant, MutateError, Tools};

/// How a score is taken.
#[derive(Debug, Clone)]
pub struct Options {
    /// The judges; a mutant that none of them settles is alive.
    pub judges: BTreeSet<Judge>,
    /// The mutants to draw.
    pub draw: Draw,
    /// Length of the runs in which the proofs look for a counterexample.
    pub cycles: u32,
    /// Where verdicts are kept, if they are. Those of the verification are not: they depend on the
    /// scene, and few mutants get there.
    pub kept: Option<Kept>,
}

/// The verification of Verilog against the golden models: the difference that it finds.
pub type Verify<'a> =
    dyn Fn(&BTreeMap<String, String>) -> Result<Option<String>, MutateError> + Sync + 'a;

/// A mutant and its fate.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Judged {
    /// The mutant.
    #[serde(flatten)]
    pub mutant: Mutant,
    /// Its fate.
    #[serde(flatten)]
    pub fate: Fate,
}

/// The score of a module.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Score {
    /// Mutants.
    pub mutants: usize,
    /// Those that the bench finds.
    pub bench: usize,
    /// Those of the others that the verification finds.
    pub verify: usize,
    /// Those of the others of which a proof fails.
    pub proofs: usize,
    /// Those that are equivalent.
    pub equivalent: usize,
    /// Those that are alive.
    pub alive: usize,
}

impl Score {
    /// The scores of the modules, by name.
    #[must_use]
    pub fn of(judged: &[Judged]) -> BTreeMap<String, Self> {
        let mut all = BTreeMap::<String, Self>::new();
        for one in judged {
            all.entry(one.mutant.module.clone())
                .or_default()
                .add(&one.fate);
        }
        all
    }

    /// The score of all modules together.
    #[must_use]
    pub fn sum(judged: &[Judged]) -> Self {
        let mut all = Self::default();
        for one in judged {
            all.add(&one.fate);
        }
        all
    }

    fn add(&mut self, fate: &Fate) {
        self.mutants += 1;
        *match fate {
            Fate::Bench { .. } => &mut self.bench,
            Fate::Verify { .. } => &mut self.verify,
            Fate::Proofs { .. } => &mut self.proofs,
            Fate::Equivalent { .. } => &mut self.equivalent,
            Fate::Alive => &mut self.alive,
        } += 1;
    }

    /// Percentages of the mutants that are not equivalent: found by the bench, and by all judges.
    #[must_use]
    pub fn percent(&self) -> Option<[f64; 2]> {
        let all = self.mutants - self.equivalent;
        let found = [self.bench, all - self.alive];
        (all > 0).then(|| found.map(|n| 100.0 * n as f64 / all as f64))
    }
}

/// Judges all mutants of a unit. `progress` is told how many are judged of how many, and by whom.
///
/// # Errors
/// A program is missing or fails, or the bench fails on the unit itself.
pub fn score(
    tools: &Tools,
    config: &Config,
    unit: &Unit,
    options: &Options,
    verify: &Verify<'_>,
    progress: &(dyn Fn(&str, usize, usize) + Sync),
) -> Result<Vec<Judged>, MutateError> {
    progress("building the mutants", 0, 1);
    // A mutant is a fault of one bit.
    let unit = &Unit {
        all_bits: true,
        ..unit.clone()
    };
    let design = Design::new(tools, unit, &options.draw)?;
    let commands: Vec<&str> = design.mutants.iter().map(|m| &*m.command).collect();
    let parts = (config, &design.netlist()?, commands, options.cycles);
    let mut court = Court {
        fates: vec![Fate::Alive; design.mutants.len()],
        design: &design,
        record: Record::open(options.kept.as_ref(), &(parts, tools)),
        progress,
    };
    // What is proven of the unit without a fault, for three of the judges.
    let proven = tools.proofs.as_ref();
    let proven = proven.map(|proofs| Systems::new(proofs, unit, options.cycles));
    let proven = proven.transpose()?;
    let mut unit_miters: Option<Vec<UnitMiter>> = None;
    for judge in &options.judges {
        if unit_miters.is_none() && [Judge::UnitMiter, Judge::Operands].contains(judge) {
            unit_miters = Some(court.unit_miters(tools, proven.as_ref())?);
        }
        match judge {
            Judge::Bench => {
                let bench = Bench::new(config, &design)?;
                court.judge(Judge::Bench, &|mutant| {
                    let found = bench.judge(mutant.number)?;
                    Ok(found.map(|[run, said]| Fate::Bench { run, said }))
                })?;
            }
            Judge::Miter | Judge::MiterFromZero => {
                let miter = match judge {
                    Judge::Miter => Miter::AnyState,
                    _ => Miter::FromZero,
                };
                let open = court.open().into_iter().map(|m| m.module.as_str());
                let miters = Miters::new(tools, &design, open)?;
                court.judge(*judge, &|mutant| {
                    let is_same = miters.equivalent(mutant, miter)?;
                    Ok(is_same.then_some(Fate::Equivalent { miter }))
                })?;
            }
            Judge::UnitMiter => {
                let miters = unit_miters.as_deref().unwrap_or_default();
                court.judge(Judge::UnitMiter, &|mutant| {
                    let own = miters.iter().find(|miter| miter.has(mutant));
                    let is_same = own.map_or(Ok(false), |miter| miter.equivalent(mutant))?;
                    let miter = Miter::InUnit;
                    Ok(is_same.then_some(Fate::Equivalent { miter }))
                })?;
            }
            Judge::Proofs => {
                let Some(systems) = &proven else {
                    continue;
                };
                court.judge(Judge::Proofs, &|mutant| {
                    let lost = systems.lost(mutant)?;
                    let is_found = !lost.is_empty();
                    Ok(is_found.then_some(Fate::Proofs { properties: lost }))
                })?;
            }
            Judge::Operands => {
                let miters = unit_miters.as_deref().unwrap_or_default();
                let Some(all) = AllOperands::new(config, &design, miters)? else {
                    continue;
                };
                court.judge(Judge::Operands, &|mutant| {
                    let miter = Miter::AllOperands;
                    let is_same = all.equivalent(mutant)?;
                    Ok(is_same.then_some(Fate::Equivalent { miter }))
                })?;
            }
            Judge::Verify => {
                if let Some(said) = verify(&design.verilog(0)?)? {
                    let unit = unit.name.clone();
                    return Err(MutateError::Unmutated("verification", unit, said));
                }
                court.judge(Judge::Verify, &|mutant| {
                    let found = verify(&design.verilog(mutant.number)?)?;
                    Ok(found.map(|said| Fate::Verify { said }))
                })?;
            }
        }
    }
    let fates = court.fates;
    let judged = design.mutants.iter().cloned().zip(fates);
    Ok(judged
        .map(|(mutant, fate)| Judged { mutant, fate })
        .collect())
}

/// Mutants and their fates so far.
struct Court<'a> {
    design: &'a Design,
    fates: Vec<Fate>,
    record: Record,
    progress: &'a (dyn Fn(&str, usize, usize) + Sync),
}

impl<'a> Court<'a> {
    /// Mutants that are alive.
    fn open(&self) -> Vec<&'a Mutant> {
        let all = self.design.mutants.iter();
        all.filter(|m| self.fates[m.number - 1] == Fate::Alive)
            .collect()
    }

    /// Miters of the unit and of its modules that are proven alone, with all open mutants. One of which a
    /// property is not proven has none.
    fn unit_miters(
        &self,
        tools: &Tools,
        systems: Option<&Systems<'_>>,
    ) -> Result<Vec<UnitMiter>, MutateError> {
        let (open, width) = (self.open(), self.design.width());
        let proven = systems.into_iter().flat_map(Systems::proven);
        proven
            .map(|unit| UnitMiter::new(tools, unit, &open, width))
            .collect()
    }

    fn judge(&mut self, by: Judge, verdict: &Verdict<'_>) -> Result<(), MutateError> {
        let open = self.open();
        let progress = |done| (self.progress)(by.name(), done, open.len());
        let record = &self.record;
        let found = match by {
            Judge::Verify => in_parallel(&open, verdict, &progress)?,
            _ => in_parallel(
                &open,
                &|mutant: &Mutant| record.verdict(by, mutant.number, || verdict(mutant)),
                &progress,
            )?,
        };
        record.save()?;
        for (mutant, fate) in open.iter().zip(found) {
            self.fates[mutant.number - 1] = fate;
        }
        Ok(())
    }
}

type Verdict<'a> = dyn Fn(&Mutant) -> Result<Option<Fate>, MutateError> + Sync + 'a;

/// The fates of mutants, judged on all cores. The result does not depend on their number.
fn in_parallel(
    mutants: &[&Mutant],
    verdict: &Verdict<'_>,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Fate>, MutateError> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let results = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while !stop.load(Ordering::Relaxed) {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(mutant) = mutants.get(at) else { break };
                    let found = verdict(mutant);
                    if found.is_err() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1);
                    if let Ok(mut results) = results.lock() {
                        results.insert(at, found);
                    }
                }
            });
        }
    });
    let results = results.into_inner().unwrap_or_default();
    // The first error in the order of the mutants.
    let fates = results.into_values();
    fates
        .map(|found| Ok(found?.unwrap_or(Fate::Alive)))
        .collect()
}
