//! Proof of a unit.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::sync::Arc;
use std::time::Instant;

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_netlist::{CheckInfo, CheckKind, Header, IrErrors, Module, check_modules, verilog};
use potamoi_soc::npu::npu_ext;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::splat_unit::packer;
use potamoi_units::vector_unit::vector_unit;
use schemars::JsonSchema;
use serde::Serialize;

use crate::script::{Kept, load, script};
use crate::solver::{failed, failed_step, reached};
use crate::tools::{Tools, no_outcome};
use crate::{Outcome, Property, ProveError};

/// Bits of the counters in a proof, the fewest that a configuration may have.
const COUNTER_BITS: u32 = 16;
/// Clocks of an induction.
const INDUCTION: u32 = 1;

/// A unit to prove.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Its name.
    pub name: String,
    /// The unit.
    pub module: Arc<Module>,
    /// The module that it is read with and lies in; itself if none.
    pub within: Option<Arc<Module>>,
    /// Modules below that are proven apart: here their outputs are anything.
    pub apart: BTreeSet<String>,
    /// Whether payloads are compared in all bits, and not in one that stands for all.
    pub all_bits: bool,
    /// Edits of its text, for mutants: a file, text that occurs in it, and what replaces the first.
    pub edits: Vec<[String; 3]>,
    /// A Yosys command that puts a fault into the netlist of [`Unit::load`].
    pub fault: Option<String>,
}

/// What is proven of a configuration: the units, each followed by its modules that are proven alone,
/// and the SoC top around them, with narrow counters.
///
/// # Errors
/// The netlist's own checks.
pub fn units(config: &Config) -> Result<Vec<Unit>, IrErrors> {
    let mut config = config.clone();
    config.gu.counter_bits = COUNTER_BITS;
    let mut all = vec![];
    for unit in units_as_built(&config)? {
        let alone = unit.proven_alone();
        all.push(unit);
        all.extend(alone);
    }
    all.push(top_as_built(&config)?);
    Ok(all)
}

/// The SoC top of a configuration around its units, which are proven apart, with counters of their
/// own width.
///
/// # Errors
/// The netlist's own checks.
pub fn top_as_built(config: &Config) -> Result<Unit, IrErrors> {
    let mut top = Unit::new(npu_ext(config)?);
    top.apart = [GATHERING_UNIT, VECTOR_UNIT].map(str::to_owned).into();
    Ok(top)
}

/// The units of a configuration, with counters of their own width; of a splat unit its packer.
///
/// # Errors
/// The netlist's own checks.
pub fn units_as_built(config: &Config) -> Result<Vec<Unit>, IrErrors> {
    let mut all = vec![gathering_unit(config)?, vector_unit(config)?];
    if let Some(su) = &config.su {
        all.push(packer(config, su)?);
    }
    Ok(all.into_iter().map(Unit::new).collect())
}

/// What is looked for.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Cycles of the runs in which what is not proven is looked for.
    pub depth: u32,
    /// Cycles within which cover points are looked for; 0 for not at all.
    pub cover: u32,
}

/// What is known of a unit.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Proof {
    /// The unit.
    pub unit: String,
    /// All its properties, then its cover points.
    pub properties: Vec<Property>,
    /// Every way in which the system that is proven may do more than the unit.
    pub abstractions: Vec<String>,
    /// What is taken for granted of the inputs.
    pub assumptions: Vec<String>,
    /// Seconds for the assertions.
    pub seconds: f64,
    /// Seconds for the cover points.
    pub cover_seconds: f64,
}

impl Unit {
    fn new(module: Arc<Module>) -> Self {
        Self {
            name: module.name().to_owned(),
            module,
            within: None,
            apart: BTreeSet::new(),
            all_bits: false,
            edits: vec![],
            fault: None,
        }
    }

    /// Its modules that are proven alone, read with it.
    #[must_use]
    pub fn proven_alone(&self) -> Vec<Self> {
        let alone = self.module.proven_alone().into_values();
        let within = Some(Arc::clone(&self.module));
        alone
            .map(|module| Self {
                within: within.clone(),
                all_bits: self.all_bits,
                edits: self.edits.clone(),
                fault: self.fault.clone(),
                ..Self::new(module)
            })
            .collect()
    }

    /// Modules whose hardware its proof has.
    #[must_use]
    pub fn modules(&self) -> BTreeSet<String> {
        let cut = self.module.data_modules_beside(&self.apart);
        self.module.modules_outside(&cut)
    }

    /// Its checks.
    #[must_use]
    pub fn checks(&self) -> Vec<CheckInfo> {
        self.module.checks_beside(&self.apart)
    }

    /// Proves all properties together; what is not inductive is looked for in bounded runs.
    ///
    /// # Errors
    /// A program is missing, fails or gives no outcome.
    pub fn prove(&self, tools: &Tools, options: Options) -> Result<Proof, ProveError> {
        let folder = self.files()?;
        let system = System {
            unit: self,
            tools,
            folder: folder.path(),
            cut: self.module.data_modules_beside(&self.apart),
        };
        let begun = Instant::now();
        let all = self.checks();
        let asserted = |c: &&CheckInfo| matches!(c.kind, CheckKind::Assert | CheckKind::Invariant);
        let names: BTreeSet<String> = all
            .iter()
            .filter(asserted)
            .map(|c| c.path.clone())
            .collect();
        let mut outcomes = system.assertions(&names, options.depth)?;
        let seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        if options.cover > 0 {
            let covers = all.iter().filter(|c| c.kind == CheckKind::Cover);
            let covers: Vec<String> = covers.map(|c| c.path.clone()).collect();
            outcomes.extend(system.covers(&covers, options.cover)?);
        }
        let properties = all.iter().filter_map(|check| {
            outcomes.get(&check.path).map(|outcome| Property {
                name: check.path.clone(),
                says: check.doc.clone(),
                supports: check.kind == CheckKind::Invariant,
                outcome: *outcome,
            })
        });
        let given = all.iter().filter(|c| c.kind == CheckKind::Assume);
        Ok(Proof {
            unit: self.name.clone(),
            properties: properties.collect(),
            abstractions: self.abstractions(&system.cut),
            assumptions: given.map(|c| c.doc.clone()).collect(),
            seconds,
            cover_seconds: begun.elapsed().as_secs_f64(),
        })
    }

    /// Looks for a failure of one property in all runs of `depth` cycles. Without one, the property is
    /// proven if all of the unit are.
    ///
    /// # Errors
    /// A program is missing, fails or gives no outcome.
    pub fn look(&self, tools: &Tools, property: &str, depth: u32) -> Result<Outcome, ProveError> {
        let folder = self.files()?;
        let system = System {
            unit: self,
            tools,
            folder: folder.path(),
            cut: self.module.data_modules_beside(&self.apart),
        };
        let names = BTreeSet::from([property.to_owned()]);
        let mut outcomes = BTreeMap::new();
        system.bounded(vec![property.to_owned()], &names, depth, &mut outcomes)?;
        if let Some(Outcome::Failed(step)) = outcomes.get(property) {
            return Ok(Outcome::Failed(*step));
        }
        system.write(&Kept::AllBut(&[]))?;
        let (inductive, _) = system.smtbmc(&["-i", "-t", &INDUCTION.to_string()])?;
        Ok(match inductive {
            true => Outcome::Proven,
            false => Outcome::Bounded(depth),
        })
    }

    /// Yosys commands that read the unit and its checks from the Verilog in the folder.
    #[must_use]
    pub fn load(&self) -> [String; 4] {
        load(self.read_with().name(), self.all_bits)
    }

    fn read_with(&self) -> &Arc<Module> {
        self.within.as_ref().unwrap_or(&self.module)
    }

    /// A folder with the Verilog and its checks.
    ///
    /// # Errors
    /// A file that cannot be written, or an edit that does not fit.
    pub fn files(&self) -> Result<tempfile::TempDir, ProveError> {
        let folder = tempfile::tempdir().map_err(|e| ProveError::Files(self.name.clone(), e))?;
        let header = Header::default();
        let text = verilog(self.read_with(), &header).into_iter();
        let checks = check_modules(&header).into_iter();
        let checks = checks.map(|(file, text)| (file.to_owned(), text));
        for (file, mut text) in text.chain(checks) {
            for [_, from, to] in self.edits.iter().filter(|[of, ..]| *of == file) {
                if !text.contains(from) {
                    return Err(ProveError::NoPlace(file, from.clone()));
                }
                text = text.replacen(from, to, 1);
            }
            fs::write(folder.path().join(&file), text).map_err(|e| ProveError::Files(file, e))?;
        }
        Ok(folder)
    }

    fn abstractions(&self, cut: &BTreeSet<String>) -> Vec<String> {
        let mut all: Vec<String> = cut
            .iter()
            .map(|m| format!("outputs of {m} are free"))
            .collect();
        if !self.all_bits {
            all.push("one bit of a payload stands for all".to_owned());
        }
        let ports = self.module.ports();
        if ports.iter().any(|p| p.name == "stat_entries") {
            all.push(format!("counters have {COUNTER_BITS} bits"));
        }
        all
    }
}

/// The files of a unit.
struct System<'a> {
    unit: &'a Unit,
    tools: &'a Tools,
    folder: &'a std::path::Path,
    cut: BTreeSet<String>,
}

impl System<'_> {
    fn write(&self, kept: &Kept<'_>) -> Result<(), ProveError> {
        let unit = self.unit;
        let mut lines = unit.load().to_vec();
        lines.extend(unit.fault.clone());
        if unit.within.is_some() {
            lines.push(format!("hierarchy -top {}", unit.module.name()));
        }
        let text = script(lines, &self.cut, kept, "system.smt2");
        let file = self.folder.join("system.ys");
        fs::write(file, text).map_err(|e| ProveError::Files("system.ys".to_owned(), e))?;
        self.tools.yosys(self.folder, "system.ys", &self.unit.name)
    }

    fn smtbmc(&self, arguments: &[&str]) -> Result<(bool, String), ProveError> {
        let all = [arguments, &["system.smt2"]].concat();
        self.tools.smtbmc(self.folder, &all, &self.unit.name)
    }

    /// Outcomes of these assertions.
    fn assertions(
        &self,
        names: &BTreeSet<String>,
        depth: u32,
    ) -> Result<BTreeMap<String, Outcome>, ProveError> {
        // What is inductive together with all others that are.
        let mut dropped: Vec<String> = vec![];
        let clocks = INDUCTION.to_string();
        while dropped.len() < names.len() {
            self.write(&Kept::AllBut(&dropped))?;
            let (passed, said) = self.smtbmc(&["-i", "-t", &clocks])?;
            if passed {
                break;
            }
            let failing = self.known(failed(&said), names, &said)?;
            dropped.extend(failing);
        }
        let mut outcomes: BTreeMap<String, Outcome> = BTreeMap::new();
        // The first cycles of all runs, where induction begins.
        let base = (INDUCTION + 2).to_string();
        if dropped.len() < names.len() {
            let (passed, said) = self.smtbmc(&["-t", &base])?;
            if !passed {
                let step = failed_step(&said).unwrap_or(0);
                for name in self.known(failed(&said), names, &said)? {
                    outcomes.insert(name, Outcome::Failed(step));
                }
                // Nothing follows from an induction that does not begin.
                let kept = names.iter().filter(|name| !dropped.contains(name));
                dropped.extend(kept.cloned().collect::<Vec<_>>());
            }
        }
        for name in names.iter().filter(|name| !dropped.contains(name)) {
            outcomes.insert(name.clone(), Outcome::Proven);
        }
        self.bounded(dropped, names, depth, &mut outcomes)?;
        Ok(outcomes)
    }

    /// Looks for failures in all runs of `depth` cycles.
    fn bounded(
        &self,
        mut open: Vec<String>,
        names: &BTreeSet<String>,
        depth: u32,
        outcomes: &mut BTreeMap<String, Outcome>,
    ) -> Result<(), ProveError> {
        open.retain(|name| !outcomes.contains_key(name));
        open.sort();
        open.dedup();
        let steps = depth.to_string();
        while !open.is_empty() {
            self.write(&Kept::Only(&open))?;
            let (passed, said) = self.smtbmc(&["-t", &steps])?;
            if passed {
                break;
            }
            let step = failed_step(&said).unwrap_or(0);
            for name in self.known(failed(&said), names, &said)? {
                open.retain(|own| *own != name);
                outcomes.insert(name, Outcome::Failed(step));
            }
        }
        outcomes.extend(open.into_iter().map(|name| (name, Outcome::Bounded(depth))));
        Ok(())
    }

    /// The names, all of which the unit has, and one at least.
    fn known(
        &self,
        found: Vec<String>,
        names: &BTreeSet<String>,
        said: &str,
    ) -> Result<Vec<String>, ProveError> {
        match !found.is_empty() && found.iter().all(|name| names.contains(name)) {
            true => Ok(found),
            false => Err(no_outcome("yosys-smtbmc", &self.unit.name, said)),
        }
    }

    /// Outcomes of these cover points.
    fn covers(&self, names: &[String], depth: u32) -> Result<Vec<(String, Outcome)>, ProveError> {
        if names.is_empty() {
            return Ok(vec![]);
        }
        self.write(&Kept::Covers)?;
        let (_, said) = self.smtbmc(&["-c", "-t", &depth.to_string()])?;
        let steps: BTreeMap<String, u32> = reached(&said).into_iter().collect();
        let outcome = |name: &String| match steps.get(name) {
            Some(step) => Outcome::Reached(*step),
            None => Outcome::NotReached(depth),
        };
        Ok(names
            .iter()
            .map(|name| (name.clone(), outcome(name)))
            .collect())
    }
}
