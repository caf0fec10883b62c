//! Precompiled headers of Verilator: reading them dominates the compilation of a small model.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::Error;
use crate::Toolchain;
use crate::commands::{PRELUDE, PRELUDE_FILE, common_flags, compiler, run, tools_key, write};
use crate::store::{self, Product, SCRATCH};

/// Names of the precompiled header and of its source.
const PRECOMPILED: &str = "model.h.gch";
const SOURCE: &str = "model.h";

/// Number of cached models from which headers are precompiled: that takes three seconds, and saves
/// one for each model.
const FROM: usize = 4;

/// Puts Verilator's headers, precompiled, beside the prelude in `scratch`, where the
/// compiler takes them from there and the cache has come to many models.
///
/// GCC looks for `NAME.gch` beside the file of `-include NAME`. All that is compiled in
/// `scratch` must have the flags of the precompiled headers: GCC 12 breaks down where only
/// the level of optimisation differs.
#[cfg_attr(not(unix), expect(unused_variables))]
pub(crate) fn provide(
    cache: &Path,
    tools: &Toolchain,
    optimise: &str,
    scratch: &Path,
) -> Result<(), Error> {
    #[cfg(unix)]
    if !tools.cxx_version().contains("clang") && has_many(cache) {
        let made = precompiled(cache, tools, optimise)?;
        let link = scratch.join(format!("{PRELUDE_FILE}.gch"));
        std::os::unix::fs::symlink(&made, &link).map_err(|e| Error::io("link", &link, &e))?;
    }
    Ok(())
}

fn has_many(cache: &Path) -> bool {
    std::fs::read_dir(cache).is_ok_and(|entries| entries.count() > FROM)
}

/// The precompiled headers, made or taken from the cache once per process.
fn precompiled(cache: &Path, tools: &Toolchain, optimise: &str) -> Result<PathBuf, Error> {
    static FOUND: Mutex<BTreeMap<(PathBuf, String), PathBuf>> = Mutex::new(BTreeMap::new());
    let text = format!("{PRELUDE}#include \"verilated.h\"\n");
    let key = tools_key(
        "headers",
        tools,
        &[&common_flags(false)[..], &[optimise]].concat(),
    )
    .with(&text);
    let place = (cache.to_path_buf(), key.hex());
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(path) = found.get(&place).filter(|path| path.exists()) {
        return Ok(path.clone());
    }
    let entry = store::fetch(cache, "headers", &key, &|folder| {
        let scratch = folder.join(SCRATCH);
        // What `-include` names is empty here: its text is part of the header.
        write(&scratch.join(PRELUDE_FILE), "")?;
        write(&scratch.join(SOURCE), &text)?;
        let mut command = compiler(tools, &scratch, false);
        command.args([optimise, "-Iobj", "-x", "c++-header", SOURCE, "-o"]);
        command.arg(folder.join(PRECOMPILED));
        run(command, "precompiling Verilator's headers")?;
        Ok(Product {
            files: vec![PRECOMPILED.to_owned()],
            notes: Vec::new(),
        })
    })?;
    let path = entry.folder.join(PRECOMPILED);
    found.insert(place, path.clone());
    Ok(path)
}
