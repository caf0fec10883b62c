//! `potamoi emit`: the Verilog of both units.

use std::collections::BTreeMap;

use clap::ValueEnum;
use potamoi_analysis::{Hardware, LeftOut};
use potamoi_base::file_set;
use potamoi_base::outputs as files;
use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_rtl::bench;
use potamoi_scene::Scene;
use potamoi_units::emit::emit;
use serde::Serialize;

use crate::args::Common;
use crate::cli::EmitArgs;
use crate::emit_unit::EmitUnit;
use crate::failure::Failure;
use crate::scene;
use crate::stdout::say;

/// Folder of the testbenches.
const SIM: &str = "sim";
/// Longest prefix of module names.
const LONGEST_PREFIX: usize = 64;
/// File of a configuration reduced to a scene.
const CONFIGURATION: &str = "configuration.toml";
/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    /// Organisation of the gathering unit's banks, and the reason.
    organisation: Organisation,
    organisation_reason: String,
    /// Top modules.
    units: Vec<&'static str>,
    /// The scene that the configuration was reduced to.
    for_scene: Option<String>,
    /// Parts left out, which the scene does not use.
    left_out: Vec<LeftOut>,
    /// Number of lines of every file, by path in the folder.
    files: BTreeMap<String, usize>,
    /// Items that the scene's files leave open.
    not_checked: Vec<String>,
}

pub(crate) fn run(common: &Common, args: &EmitArgs) -> Result<(), Failure> {
    files::prepare([args.json.as_ref()])?;
    let asked = common.read_config()?;
    let prefix = checked_prefix(args)?;
    refuse_own_configuration(common, args)?;
    let hardware = match &args.for_scene {
        Some(name) => {
            let scene = Scene::open(name)?;
            scene::note(&scene);
            Hardware::of(&scene, &asked)?
        }
        None => Hardware::whole(&asked),
    };
    let config = hardware.config;
    let mut options = String::new();
    if let Some(unit) = args
        .unit
        .to_possible_value()
        .filter(|_| args.unit != EmitUnit::Both)
    {
        options += &format!(" --unit {}", unit.get_name());
    }
    if !prefix.is_empty() {
        options += &format!(" --prefix {prefix}");
    }
    // A preset by name; any other file by its hash, so that its place changes no byte.
    let command = match common.preset() {
        Some(name) if config == asked => format!("potamoi --config {name} emit{options}"),
        _ => format!("potamoi --config FILE emit{options}, FILE having that hash"),
    };
    let units: Vec<&'static str> = [
        (
            GATHERING_UNIT,
            hardware.gathers && args.unit.has(EmitUnit::Gu),
        ),
        (
            VECTOR_UNIT,
            hardware.computes && args.unit.has(EmitUnit::Vu),
        ),
    ]
    .into_iter()
    .filter_map(|(unit, is_called_for)| is_called_for.then_some(unit))
    .collect();
    let mut made = emit(&config, prefix, &command)?;
    made.retain(|path, _| {
        units
            .iter()
            .any(|unit| path.starts_with(&format!("{unit}/")))
    });
    let mut all = made.clone();
    for (name, text) in bench::standalone(&config, &units, prefix)? {
        all.insert(format!("{SIM}/{name}"), text);
    }
    if args.for_scene.is_some() {
        all.insert(CONFIGURATION.to_owned(), text_of(&config)?);
    }
    let stale = file_set::replace(
        &args.out_dir,
        &all,
        &config.hash(),
        args.overwrite,
        &file_set::finish_apart,
    )?;
    let (organisation, organisation_reason) = config.organisation();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "emit",
        organisation,
        organisation_reason,
        configuration: config.hash(),
        units,
        for_scene: args.for_scene.clone(),
        left_out: hardware.left_out,
        files: all
            .iter()
            .filter(|(path, _)| *path != CONFIGURATION)
            .map(|(path, text)| (path.clone(), text.lines().count()))
            .collect(),
        not_checked: scene::left_open_of_files(),
    };
    print(&report, &made, &stale, args);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}

/// The prefix of module names, if it can begin a name.
fn checked_prefix(args: &EmitArgs) -> Result<&str, Failure> {
    let prefix = args.prefix.as_deref().unwrap_or_default();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let begins = prefix
        .chars()
        .next()
        .is_none_or(|c| c.is_ascii_alphabetic());
    if begins && prefix.chars().all(is_plain) && prefix.len() <= LONGEST_PREFIX {
        return Ok(prefix);
    }
    Err(Failure::Usage(format!(
        "--prefix {prefix}: expected a letter, then letters, digits and underscores, {LONGEST_PREFIX} \
         at most"
    )))
}

/// Refuses a configuration file that its own reduced form would overwrite.
fn refuse_own_configuration(common: &Common, args: &EmitArgs) -> Result<(), Failure> {
    if let (Some(config), Some(scene)) = (&common.config, &args.for_scene) {
        let own = args.out_dir.join(CONFIGURATION);
        if let (Ok(read), Ok(written)) = (config.canonicalize(), own.canonicalize())
            && read == written
        {
            return Err(Failure::Usage(format!(
                "--config {} would be overwritten by its reduced configuration for {scene}: name \
                 another folder with --out-dir",
                config.display()
            )));
        }
    }
    Ok(())
}

/// Prints the files left out, removed and written.
fn print(report: &Report, made: &BTreeMap<String, String>, stale: &[String], args: &EmitArgs) {
    if let Some(scene) = &report.for_scene {
        let path = args.out_dir.join(CONFIGURATION);
        say!(
            "for {scene}, from any camera; reduced configuration: {}",
            path.display()
        );
        for part in &report.left_out {
            let LeftOut {
                field,
                asked,
                left,
                reason,
            } = part;
            say!("  {field}: {left} instead of {asked}, since {reason}");
        }
        if report.left_out.is_empty() {
            say!("  it calls for the whole configuration");
        }
    }
    for name in stale {
        let path = args.out_dir.join(name);
        say!("removed {}, of another configuration", path.display());
    }
    say!(
        "{} modules, {} lines of Verilog-2005 in {}, configuration {}",
        made.len(),
        made.values()
            .map(|text| text.lines().count())
            .sum::<usize>(),
        args.out_dir.display(),
        report.configuration
    );
    say!(
        "testbenches with golden vectors: make -C {}",
        crate::args::quoted(&args.out_dir.join(SIM))
    );
    say!(
        "banks of the gathering unit: {}, since {}",
        name_of(report.organisation),
        report.organisation_reason
    );
}

/// Text of a configuration file.
fn text_of(config: &Config) -> Result<String, Failure> {
    config
        .to_toml()
        .map_err(|error| Failure::check(format!("{CONFIGURATION}: {error}")))
}

const fn name_of(organisation: Organisation) -> &'static str {
    match organisation {
        Organisation::Auto | Organisation::ChannelMajor => "channel-major",
        Organisation::Parity => "parity",
        Organisation::FeatureMajor => "feature-major",
    }
}
