//! `potamoi emit`: the Verilog of both units and of their SoC top.

use std::collections::BTreeMap;
use std::path::Path;

use clap::ValueEnum;
use potamoi_analysis::{Hardware, LeftOut};
use potamoi_base::file_set;
use potamoi_base::outputs as files;
use potamoi_formats::config::{Config, NO_SPLAT_UNIT, Organisation};
use potamoi_formats::units::{GATHERING_UNIT, NPU_EXT, SPLAT_UNIT, VECTOR_UNIT};
use potamoi_rtl::bench;
use potamoi_scene::Scene;
use potamoi_soc::emit::emit;
use potamoi_soc::npu::REGISTERS;
use potamoi_soc::package::Package;
use potamoi_units::memory_list::{ListedMemory, memory_list};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::cli::EmitArgs;
use crate::emit_exponential;
use crate::emit_unit::EmitUnit;
use crate::failure::Failure;
use crate::published::{Published, either};
use crate::scene;
use crate::stdout::{prose, say};

/// Folder of the testbenches.
const SIM: &str = "sim";
/// Longest prefix of module names.
const LONGEST_PREFIX: usize = 64;
/// File of a configuration reduced to a scene.
const CONFIGURATION: &str = "configuration.toml";
/// File of the memories.
const MEMORIES: &str = "memory_list.json";
/// Version of the JSON report and of the list of memories.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "emit",
    version: FORMAT_VERSION,
    shape: either::<Report, emit_exponential::Report>,
};

#[derive(Serialize, JsonSchema)]
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

/// The list of memories, for a memory compiler.
#[derive(Serialize)]
struct Memories<'a> {
    format_version: u32,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    memories: &'a [ListedMemory],
}

pub(crate) fn run(common: &Common, args: &EmitArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let asked = common.read_config()?;
    let prefix = checked_prefix(args)?;
    if args.unit == EmitUnit::Exp {
        return emit_exponential::run(common, args, &asked, prefix);
    }
    if let Some(form) = args.form {
        return Err(Failure::Usage(format!(
            "--form {} is of --unit exp alone: for other units set vu.exp.form in the configuration",
            form.name()
        )));
    }
    refuse_own_configuration(common, args)?;
    if args.unit == EmitUnit::Su && asked.su.is_none() {
        return Err(Failure::Usage(format!("--unit su: {NO_SPLAT_UNIT}")));
    }
    let hardware = match &args.for_scene {
        Some(name) => {
            let scene = Scene::open(name)?;
            scene::note(&scene);
            Hardware::of(&scene, &asked)?
        }
        None => Hardware::whole(&asked),
    };
    let config = hardware.config;
    let command = command_of(common, args, config == asked);
    let units: Vec<&'static str> = [
        (
            GATHERING_UNIT,
            hardware.gathers && args.unit.has(EmitUnit::Gu),
        ),
        (
            VECTOR_UNIT,
            hardware.computes && args.unit.has(EmitUnit::Vu),
        ),
        (
            SPLAT_UNIT,
            config.su.is_some() && args.unit.has(EmitUnit::Su),
        ),
        (
            NPU_EXT,
            hardware.gathers && hardware.computes && args.unit == EmitUnit::Both,
        ),
    ]
    .into_iter()
    .filter_map(|(unit, is_called_for)| is_called_for.then_some(unit))
    .collect();
    let mut made = emit(&config, prefix, &command)?;
    made.retain(|path, _| {
        let folder = path.split('/').next().unwrap_or_default();
        units.contains(&folder) || folder == REGISTERS && units.contains(&NPU_EXT)
    });
    let mut all = made.clone();
    let memories = companions(&config, prefix, &command, &units, &mut all)?;
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
    print(&report, &made, &memories, &stale, args);
    args.files.write(&report)?;
    Ok(())
}

/// The command that writes the same files, without the folder. A preset by name; any other file by its
/// hash, so that its place changes no byte.
fn command_of(common: &Common, args: &EmitArgs, is_whole: bool) -> String {
    let mut options = String::new();
    let unit = args.unit.to_possible_value();
    if let Some(unit) = unit.filter(|_| args.unit != EmitUnit::Both) {
        options += &format!(" --unit {}", unit.get_name());
    }
    if let Some(prefix) = args.prefix.as_ref().filter(|prefix| !prefix.is_empty()) {
        options += &format!(" --prefix {prefix}");
    }
    match common.preset() {
        Some(name) if is_whole => format!("potamoi --config {name} emit{options}"),
        _ => format!("potamoi --config FILE emit{options}, FILE having that hash"),
    }
}

/// Adds what lies beside the Verilog: benches, the list of memories, which it returns, and files for the
/// tools of others.
fn companions(
    config: &Config,
    prefix: &str,
    command: &str,
    units: &[&'static str],
    all: &mut BTreeMap<String, String>,
) -> Result<Vec<ListedMemory>, Failure> {
    for (name, text) in bench::standalone(config, units, prefix)? {
        all.insert(format!("{SIM}/{name}"), text);
    }
    let mut memories = memory_list(config, prefix)?;
    memories.retain(|own| units.contains(&own.unit.as_str()));
    let list = Memories {
        format_version: FORMAT_VERSION,
        configuration: config.hash(),
        memories: &memories,
    };
    all.insert(MEMORIES.to_owned(), text_of_json(&list)?);
    let paths = all.keys().map(String::as_str);
    let package = Package::new(config, prefix, command, units, paths)?.files();
    all.extend(package);
    Ok(memories)
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

/// JSON of a file that lies beside the Verilog.
fn text_of_json(report: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(report);
    let text = text.map_err(|e| files::FileError::new(Path::new(MEMORIES), e.into()))?;
    Ok(text + "\n")
}

/// Prints the files left out, removed and written.
fn print(
    report: &Report,
    made: &BTreeMap<String, String>,
    memories: &[ListedMemory],
    stale: &[String],
    args: &EmitArgs,
) {
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
        say!("removed {}, of an earlier emission", path.display());
    }
    let modules = made.iter().filter(|(path, _)| path.ends_with(".v"));
    let lines = modules.clone().map(|(_, text)| text.lines().count());
    say!(
        "{} modules, {} lines of Verilog-2005 in {}, configuration {}",
        modules.count(),
        lines.sum::<usize>(),
        args.out_dir.display(),
        report.configuration
    );
    for own in memories {
        let ListedMemory {
            count,
            words,
            bits,
            module,
            ..
        } = own;
        let meant_for = match &own.in_place {
            Some(name) => format!("{name} where POTAMOI_MACROS is defined"),
            None => "meant for flip-flops".to_owned(),
        };
        say!(
            "memory {module}: {count} of {words} x {bits} bits, {}, {meant_for}",
            own.ports()
        );
    }
    if report.units.contains(&NPU_EXT) {
        say!(
            "registers of {NPU_EXT}: SystemRDL, JSON, Markdown and a C header in {}",
            crate::args::quoted(&args.out_dir.join(REGISTERS))
        );
    }
    say!(
        "testbenches with golden vectors: make -C {}",
        crate::args::quoted(&args.out_dir.join(SIM))
    );
    prose!(
        0,
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
