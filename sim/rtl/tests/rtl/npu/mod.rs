//! The SoC top: a driver in C99 on the Verilated top, and the bench beside the Verilog.

mod foreign_master;
mod mutants;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, NPU_EXT, VECTOR_UNIT};
use potamoi_netlist::PortInfo;
use potamoi_rtl::bench::standalone;
use potamoi_soc::emit::emit;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

const UNITS: [&str; 3] = [GATHERING_UNIT, VECTOR_UNIT, NPU_EXT];

/// Emits units, top and benches of a configuration.
fn lay(config: &Config, folder: &Path) {
    let mut files = emit(config, "", "test").unwrap();
    let benches = standalone(config, &UNITS, "").unwrap();
    let benches = benches.into_iter();
    files.extend(benches.map(|(name, text)| (format!("sim/{name}"), text)));
    for (path, text) in files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// Whether a command succeeds, and what it says.
fn run(command: &mut Command) -> (bool, String) {
    let done = command
        .output()
        .unwrap_or_else(|e| panic!("{command:?}: {e}; tools/setup installs it"));
    let said = String::from_utf8([done.stdout, done.stderr].concat()).unwrap();
    (done.status.success(), said)
}

/// A list of fields, highest first, as the harness takes it.
fn fields(text: &mut String, name: &str, stream: &str, fields: &[(String, u32)]) {
    let _ = write!(text, "#define {name}_FIELDS(X)");
    for (field, bits) in fields {
        let _ = write!(text, " X({stream}, {field}, {bits})");
    }
    text.push('\n');
    let below = fields
        .iter()
        .rev()
        .take_while(|(field, _)| field != "tlast");
    let _ = writeln!(
        text,
        "#define {name}_LAST {}",
        below.map(|(_, bits)| bits).sum::<u32>()
    );
}

/// Payload of a stream in the order of its ports.
fn payload(ports: &[PortInfo], stream: &str) -> Vec<(String, u32)> {
    let own = ports.iter().filter_map(|port| {
        let field = port.name.strip_prefix(stream)?.strip_prefix('_')?;
        let is_payload = !["tvalid", "tready"].contains(&field);
        is_payload.then(|| (field.to_owned(), port.ty.width))
    });
    own.collect()
}

/// Settings, beats, cycles and counters of a job.
fn job(ports: &[PortInfo], streams: &[&str]) -> Vec<(String, u32)> {
    let begin = |begin: &str| {
        let own = ports.iter().filter(|port| port.name.starts_with(begin));
        let own = own.filter(|port| port.name != "cfg_clear");
        own.map(|port| (port.name.clone(), port.ty.width))
            .collect::<Vec<_>>()
    };
    let mut all = begin("cfg_");
    let beats = |stream: &&str| ["from", "end"].map(|end| (format!("{stream}_{end}"), 32));
    all.extend(streams.iter().flat_map(beats));
    all.push(("closed".to_owned(), 16));
    all.push(("cycles".to_owned(), 32));
    all.extend(begin("stat_"));
    all
}

/// Name, file and fields, highest first, of the words of each `.hex` file.
type Layout = Vec<(&'static str, &'static str, Vec<(String, u32)>)>;

fn layout(config: &Config) -> Layout {
    let (gathers, vectors) = (
        gathering_unit(config).unwrap(),
        vector_unit(config).unwrap(),
    );
    let (gathers, vectors) = (gathers.ports(), vectors.ports());
    let mut all = vec![];
    for (ports, stream, file) in [
        (&gathers, "s_axis_rit", "gather_rit.hex"),
        (&gathers, "s_axis_mft", "gather_mft.hex"),
        (&gathers, "m_axis_feat", "gather_feat.hex"),
        (&vectors, "s_axis_vec", "vector_in.hex"),
        (&vectors, "m_axis_vec", "vector_out.hex"),
    ] {
        all.push((stream, file, payload(ports, stream)));
    }
    let of_gathers = job(&gathers, &["s_axis_rit", "s_axis_mft", "m_axis_feat"]);
    all.push(("gather_jobs", "gather_jobs.hex", of_gathers));
    let of_vectors = job(&vectors, &["s_axis_vec", "m_axis_vec"]);
    all.push(("vector_jobs", "vector_jobs.hex", of_vectors));
    all
}

/// The layout as macros for the harness.
fn macros(config: &Config) -> String {
    let mut text = String::new();
    for (name, _, own) in layout(config) {
        let short = match name {
            "s_axis_rit" => "RIT",
            "s_axis_mft" => "MFT",
            "m_axis_feat" => "FEAT",
            "s_axis_vec" => "VEC_IN",
            "m_axis_vec" => "VEC_OUT",
            "gather_jobs" => "GATHER_JOB",
            _ => "VECTOR_JOB",
        };
        let stream = if name.ends_with("_jobs") { "job" } else { name };
        fields(&mut text, short, stream, &own);
    }
    text
}

/// Compiles the driver as C99, links it to the Verilated top, and runs the jobs of both units.
fn drive(config: &Config) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    lay(config, at);
    let sources = [
        ("driver.h", include_str!("driver.h")),
        ("driver.c", include_str!("driver.c")),
        ("harness.cpp", include_str!("harness.cpp")),
    ];
    for (name, text) in sources {
        std::fs::write(at.join(name), text).unwrap();
    }
    std::fs::write(at.join("layout.h"), macros(config)).unwrap();
    let (well, said) = run(Command::new("cc").current_dir(at).args([
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-Iregisters",
        "-c",
        "driver.c",
    ]));
    assert!(well && said.is_empty(), "{said}");
    let flags = format!("-I{0} -I{0}/registers -std=c++17 -O1", at.display());
    let object = at.join("driver.o");
    let mut verilog = vec![];
    for unit in UNITS {
        let files = std::fs::read_dir(at.join(unit)).unwrap();
        verilog.extend(files.map(|file| file.unwrap().path()));
    }
    verilog.sort();
    let (well, said) = run(Command::new("verilator")
        .current_dir(at)
        .args([
            "--cc",
            "--exe",
            "--build",
            "-O3",
            "--x-initial",
            "unique",
            "--top-module",
            NPU_EXT,
        ])
        .args(["-CFLAGS", &flags, "harness.cpp"])
        .arg(&object)
        .args(verilog)
        .env("MAKEFLAGS", "-j2")
        .arg("-Mdir")
        .arg("build"));
    assert!(well, "{said}");
    let (well, said) =
        run(Command::new(at.join("build").join(format!("V{NPU_EXT}"))).current_dir(at.join("sim")));
    assert!(well && said.contains("PASS: "), "{said}");
}

#[test]
fn a_driver_in_c_runs_the_jobs_of_both_units() {
    drive(&Config::preset("small").unwrap());
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_driver_in_c_runs_the_jobs_of_every_organisation() {
    for preset in ["paper", "parity", "feature-major"] {
        drive(&Config::preset(preset).unwrap());
    }
    let records = "[gu]\nrecords_a_row = 2\ncounter_bits = 48";
    drive(&Config::from_toml(records, "test").unwrap());
}
