//! `potamoi emit`: the Verilog of both units.

use std::collections::BTreeMap;

use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_hdl::emit::emit;
use serde::Serialize;

use crate::cli::EmitArgs;
use crate::common::Common;
use crate::failure::Failure;
use crate::files;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// 12 hexadecimal digits.
    configuration: String,
    /// Top modules.
    units: Vec<&'static str>,
    /// Lines of every file, by path below the folder.
    files: BTreeMap<String, usize>,
}

pub(crate) fn run(common: &Common, args: &EmitArgs) -> Result<(), Failure> {
    let config = common.read_config()?;
    let command = format!("potamoi{} emit", common.arguments());
    let made = emit(&config, &command)?;
    for (path, text) in &made {
        files::write(&args.out.join(path), text)?;
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "emit",
        configuration: config.hash(),
        units: vec![GATHERING_UNIT, VECTOR_UNIT],
        files: made
            .iter()
            .map(|(path, text)| (path.clone(), text.lines().count()))
            .collect(),
    };
    println!(
        "{} modules, {} lines of Verilog-2005 in {}, configuration {}",
        report.files.len(),
        report.files.values().sum::<usize>(),
        args.out.display(),
        report.configuration
    );
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}
