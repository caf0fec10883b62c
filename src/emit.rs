//! `potamoi emit`: the Verilog of both units.

use potamoi_hdl::emit::emit;

use crate::cli::EmitArgs;
use crate::common::Common;
use crate::failure::Failure;
use crate::files;

pub(crate) fn run(common: &Common, args: &EmitArgs) -> Result<(), Failure> {
    let config = common.read_config()?;
    let command = format!("potamoi{} emit", common.arguments());
    let files = emit(&config, &command)?;
    for (path, text) in &files {
        files::write(&args.out.join(path), text)?;
    }
    let lines: usize = files.values().map(|t| t.lines().count()).sum();
    println!(
        "{} modules, {lines} lines of Verilog-2005 in {}, configuration {}",
        files.len(),
        args.out.display(),
        config.hash()
    );
    Ok(())
}
