//! Mapping of a module to cells, without timing.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_netlist::{Header, Module, verilog};
use potamoi_result_cache::{self as result_cache, Key};

use crate::cache_keys::{MappedInputs, NamelessInputs};
use crate::error::cannot_keep;
use crate::script::{LIBRARY, NETLIST, scripts};
use crate::tools::{SYNTH, left_nothing};
use crate::work_folder::WorkFolder;
use crate::{Library, NetlistDigests, SynthError, Tools};

/// File of the cells' functions.
const FUNCTIONS: &str = "cells.v";

/// Maps a unit to cells; cached in `cache` by Verilog, library, scripts and programs, so that its nets
/// have the names of the Verilog. If interrupted, it leaves nothing in the cache.
///
/// # Errors
/// A program fails; files cannot be written.
pub fn netlist(
    module: &Arc<Module>,
    unit: &'static str,
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<String, SynthError> {
    Mapping::new(module, unit, library, tools, cache).made()
}

/// A module to be mapped to cells.
pub(crate) struct Mapping<'a> {
    run: Run<'a>,
    netlists: NetlistDigests,
    /// Verilog by file name.
    files: BTreeMap<String, String>,
    script: String,
    others: [(&'static str, String); 2],
}

impl<'a> Mapping<'a> {
    pub(crate) fn new(
        module: &Arc<Module>,
        unit: &'static str,
        library: &'a Library,
        tools: &'a Tools,
        cache: &'a Path,
    ) -> Self {
        let macros = module.memory_modules();
        let files = verilog(module, &Header::default());
        let is_macro = |file: &str| macros.keys().any(|m| file == format!("{m}.v"));
        let (memories, logic): (Vec<&str>, Vec<&str>) = files
            .keys()
            .map(String::as_str)
            .partition(|file| is_macro(file));
        let version = tools.yosys_version();
        let scripts = scripts(module.name(), &logic, &memories, library, version);
        Self {
            run: Run {
                unit,
                library,
                tools,
                cache,
            },
            netlists: NetlistDigests::new(module),
            script: format!(
                "{}write_verilog -noattr -simple-lhs {NETLIST}\n",
                scripts.yosys
            ),
            others: scripts.others,
            files,
        }
    }

    /// Key of the netlist whatever its nets are called: of results in which no net is named.
    pub(crate) fn key(&self) -> Key {
        let inputs = NamelessInputs {
            unit: self.run.unit,
            yosys: &self.run.tools.yosys,
            library: &self.run.library.sha256,
            script: &self.script,
            others: &self.others,
            netlists: &self.netlists,
        };
        inputs.key()
    }

    /// The netlist, from the cache or a new run.
    pub(crate) fn made(&self) -> Result<String, SynthError> {
        let others = self.others.iter().map(|(file, text)| (*file, &**text));
        let sources = self.files.iter().map(|(file, text)| (&**file, &**text));
        let texts: BTreeMap<&str, &str> = sources.chain(others).collect();
        self.run.made(&texts, &self.script, NETLIST)
    }
}

/// Verilog of the functions of a library's cells, for Yosys.
///
/// # Errors
/// Yosys fails; files cannot be written.
pub fn cell_functions(
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<String, SynthError> {
    let script = format!(
        "read_liberty -ignore_miss_func {LIBRARY}\nproc\nwrite_verilog -noattr {FUNCTIONS}\n"
    );
    let run = Run {
        unit: "cells",
        library,
        tools,
        cache,
    };
    run.made(&BTreeMap::new(), &script, FUNCTIONS)
}

/// A Yosys script with its inputs.
struct Run<'a> {
    unit: &'static str,
    library: &'a Library,
    tools: &'a Tools,
    cache: &'a Path,
}

impl Run<'_> {
    /// The file that the script writes, from the cache or a new run.
    fn made(
        &self,
        texts: &BTreeMap<&str, &str>,
        script: &str,
        result: &str,
    ) -> Result<String, SynthError> {
        let Self {
            unit,
            library,
            tools,
            cache,
        } = self;
        let inputs = MappedInputs {
            unit,
            yosys: &tools.yosys,
            library: &library.sha256,
            script,
            texts,
        };
        let kept = inputs.key().file(cache, "v");
        if let Some(text) = result_cache::read_text(&kept) {
            return Ok(text);
        }
        std::fs::create_dir_all(cache).map_err(cannot_keep(cache))?;
        let folder = WorkFolder::new()?;
        for (file, text) in texts {
            folder.write(file, text)?;
        }
        folder.write(LIBRARY, &library.text)?;
        folder.write(SYNTH, script)?;
        tools.yosys(folder.path(), SYNTH, unit)?;
        let text = folder.read(result);
        let text = text.ok_or_else(|| left_nothing("yosys", unit, "leaves no netlist"))?;
        result_cache::write_text(&kept, &text).map_err(cannot_keep(&kept))?;
        Ok(text)
    }
}
