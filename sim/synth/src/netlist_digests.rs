//! Digests of a unit's netlist, module by module.

use std::collections::BTreeMap;

use potamoi_formats::config::Config;
use potamoi_netlist::Module;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{SynthError, UnitKind};

/// Digest of the netlist of each module of a unit by the module's name, 16 hexadecimal digits each.
///
/// A module's digest depends on those of the modules below it, so that the top module's is that of
/// the whole unit. Names of nodes and instances, comments and the printed text change none; see
/// [`potamoi_netlist::Digest`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct NetlistDigests(BTreeMap<String, String>);

impl NetlistDigests {
    /// Digests of the netlist that is generated now for a unit.
    ///
    /// # Errors
    /// The netlist's own checks.
    pub fn of(config: &Config, unit: UnitKind) -> Result<Self, SynthError> {
        Ok(Self::new(&*unit.module(config)?))
    }

    pub(crate) fn new(module: &Module) -> Self {
        let digests = module.digests().into_iter();
        Self(digests.map(|(name, d)| (name, d.to_string())).collect())
    }

    /// Names of the modules that are new, gone or different in `now`. A module differs where one
    /// below it does.
    #[must_use]
    pub fn changed<'a>(&'a self, now: &'a Self) -> Vec<&'a str> {
        let gone = self.0.keys().filter(|name| !now.0.contains_key(*name));
        let others = now
            .0
            .iter()
            .filter(|(name, d)| self.0.get(*name) != Some(d));
        gone.chain(others.map(|(name, _)| name))
            .map(String::as_str)
            .collect()
    }

    /// Checks that the top module has one.
    pub(crate) fn check(&self, top: &str) -> Result<(), String> {
        match self.0.contains_key(top) {
            true => Ok(()),
            false => Err(format!("netlists: no digest of {top}")),
        }
    }
}
