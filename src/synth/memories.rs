//! `potamoi synth --memories`: memories by shape, each with CACTI's figures.

use std::path::Path;

use potamoi_base::outputs as files;
use potamoi_synth::{Cacti, MemoryTable};

use crate::failure::Failure;
use crate::progress;
use crate::stdout::say;

pub(super) fn run(cache: &Path, path: &Path) -> Result<(), Failure> {
    let cacti = Cacti::find(cache)?;
    let bar = progress::bar(MemoryTable::wanted_len(), "memories");
    let table = MemoryTable::model(&cacti, &|| bar.inc(1));
    bar.finish_and_clear();
    let table = table?;
    files::write_json(path, &table)?;
    say!("{} memories: {}", table.len(), path.display());
    Ok(())
}
