//! The proofs as a judge.

use std::collections::BTreeSet;

use potamoi_prove::{Options, Outcome, Tools, Unit};

use crate::{Mutant, MutateError};

/// What is proven of a unit and of its modules that are proven alone.
pub(crate) struct Systems<'a> {
    tools: &'a Tools,
    options: Options,
    all: Vec<System>,
}

struct System {
    unit: Unit,
    modules: BTreeSet<String>,
    /// Properties that are not proven without a fault.
    unproven: Vec<String>,
}

impl<'a> Systems<'a> {
    /// Proves what is proven without a fault.
    pub(crate) fn new(tools: &'a Tools, unit: &Unit, cycles: u32) -> Result<Self, MutateError> {
        let mut this = Self {
            tools,
            options: Options {
                depth: cycles,
                cover: 0,
            },
            all: vec![],
        };
        for unit in [vec![unit.clone()], unit.proven_alone()].concat() {
            let unproven = this.not_proven(&unit)?;
            let modules = unit.modules();
            this.all.push(System {
                unit,
                modules,
                unproven,
            });
        }
        Ok(this)
    }

    /// The units of which all properties are proven.
    pub(crate) fn proven(&self) -> impl Iterator<Item = &Unit> {
        let proven = self.all.iter().filter(|system| system.unproven.is_empty());
        proven.map(|system| &system.unit)
    }

    /// Properties that are not proven of a mutant, and are without it.
    pub(crate) fn lost(&self, mutant: &Mutant) -> Result<Vec<String>, MutateError> {
        let mut all = vec![];
        for system in &self.all {
            if !system.modules.contains(&mutant.module) {
                continue;
            }
            let mut faulty = system.unit.clone();
            faulty.fault = Some(mutant.command.clone());
            let mut lost = self.not_proven(&faulty)?;
            lost.retain(|name| !system.unproven.contains(name));
            all.append(&mut lost);
        }
        Ok(all)
    }

    /// Properties and invariants that are not proven.
    fn not_proven(&self, unit: &Unit) -> Result<Vec<String>, MutateError> {
        let proof = unit.prove(self.tools, self.options)?;
        let open = proof.properties.into_iter();
        let open = open.filter(|p| p.outcome != Outcome::Proven);
        let name = |name: String| match unit.within {
            Some(_) => format!("{}.{name}", unit.name),
            None => name,
        };
        Ok(open.map(|p| name(p.name)).collect())
    }
}
