//! Repeated timing of a netlist.

use std::path::Path;

use potamoi_result_cache as result_cache;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::cache_keys::RetimeInputs;
use super::error::{CHECK_LIBRARY, cannot_keep};
use super::script::{LIBRARY, NETLIST};
use super::tools::TIMING;
use super::work_folder::WorkFolder;
use super::{Library, SynthError, SynthesisedUnit, Tools, UnitKind};

/// Inputs of a timing run.
pub(super) struct Retiming<'a> {
    pub(super) unit: UnitKind,
    pub(super) made: &'a SynthesisedUnit,
    pub(super) library: &'a Library,
    pub(super) tools: &'a Tools,
    /// Cache folder.
    pub(super) cache: &'a Path,
}

/// Wanted result.
pub(super) struct Wanted<'a> {
    /// Version of the cached format.
    pub(super) version: &'a str,
    /// Part of the file names.
    pub(super) name: &'a str,
    /// Description for errors.
    pub(super) what: &'a str,
    pub(super) script: &'a str,
    /// Files beside library and netlist, by name.
    pub(super) others: &'a [(&'a str, &'a str)],
}

impl Retiming<'_> {
    /// Runs the script and parses OpenSTA's output; cached.
    ///
    /// # Errors
    /// OpenSTA fails or prints output that is not understood; files cannot be written.
    pub(super) fn run<T: Serialize + DeserializeOwned>(
        &self,
        wanted: &Wanted<'_>,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, SynthError> {
        let (library, unit, netlist) = (self.library, self.unit, &self.made.netlist);
        let inputs = RetimeInputs {
            unit,
            wanted: [wanted.name, wanted.version],
            opensta: &self.tools.opensta,
            library: &library.sha256,
            script: wanted.script,
            netlist,
            others: wanted.others,
        };
        let kept = inputs.key().file(self.cache, "json");
        if let Some(found) = result_cache::read(&kept) {
            return Ok(found);
        }
        let folder = WorkFolder::new()?;
        let files = [
            (LIBRARY, &*library.text),
            (NETLIST, netlist),
            (TIMING, wanted.script),
        ];
        for (name, text) in files.iter().chain(wanted.others) {
            folder.write(name, text)?;
        }
        let said = self.tools.sta(folder.path(), unit.top())?;
        let found = read(&said).ok_or_else(|| SynthError::Output {
            tool: "sta",
            unit: unit.top(),
            what: wanted.what.to_owned(),
            remedy: CHECK_LIBRARY,
        })?;
        result_cache::write(&kept, &found).map_err(cannot_keep(&kept))?;
        // As it is read again, so that nothing depends on whether it was kept.
        Ok(result_cache::read(&kept).unwrap_or(found))
    }
}
