//! `potamoi emit --unit exp`: the exponential by itself, and its bench.

use std::collections::BTreeMap;

use potamoi_base::file_set;
use potamoi_base::outputs as files;
use potamoi_formats::config::Config;
use potamoi_rtl::bench;
use potamoi_units::emit::emit_exponential;
use potamoi_units::exponential::EXPONENTIAL;
use serde::Serialize;

use crate::args::{Common, quoted};
use crate::cli::EmitArgs;
use crate::failure::Failure;
use crate::stdout::say;

const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    /// Top modules.
    units: [&'static str; 1],
    /// Form of the exponential.
    form: &'static str,
    /// Number of lines of every file, by path in the folder.
    files: BTreeMap<String, usize>,
}

pub(crate) fn run(
    common: &Common,
    args: &EmitArgs,
    asked: &Config,
    prefix: &str,
) -> Result<(), Failure> {
    if let Some(scene) = &args.for_scene {
        return Err(Failure::Usage(format!(
            "--for-scene {scene} with --unit exp: the exponential by itself is of no scene; leave \
             --for-scene out"
        )));
    }
    let mut config = asked.clone();
    let mut options = " --unit exp".to_owned();
    if let Some(form) = args.form {
        config.vu.exp = form.plain();
        options += &format!(" --form {}", form.name());
    }
    if !prefix.is_empty() {
        options += &format!(" --prefix {prefix}");
    }
    let command = match common.preset() {
        Some(name) => format!("potamoi --config {name} emit{options}"),
        None => format!("potamoi --config FILE emit{options}, FILE having that hash"),
    };
    let mut made = emit_exponential(&config, prefix, &command)?;
    for (name, text) in bench::exponential(&config, prefix)? {
        made.insert(format!("sim/{name}"), text);
    }
    let stale = file_set::replace(
        &args.out_dir,
        &made,
        &config.hash(),
        args.overwrite,
        &file_set::finish_apart,
    )?;
    for name in stale {
        let path = args.out_dir.join(name);
        say!("removed {}, of another configuration", path.display());
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "emit",
        configuration: config.hash(),
        units: [EXPONENTIAL],
        form: config.vu.exp.form.name(),
        files: made
            .iter()
            .map(|(path, text)| (path.clone(), text.lines().count()))
            .collect(),
    };
    say!(
        "exponential, form {}: {} files in {}, configuration {}",
        report.form,
        report.files.len(),
        args.out_dir.display(),
        report.configuration
    );
    say!(
        "testbench with every operand: make -C {}",
        quoted(&args.out_dir.join("sim"))
    );
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}
