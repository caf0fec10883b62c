//! PeakRDL reads the SystemRDL of the registers as the JSON has them.

use std::path::Path;
use std::process::{Command, Output};

use potamoi_formats::config::{Config, PRESETS};
use potamoi_soc::npu::register_map_of;
use potamoi_soc::npu::registers::{RegisterMap, json, system_rdl};

fn peakrdl(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("peakrdl")
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap_or_else(|e| {
            panic!("peakrdl: {e}; to get it: tools/setup registers, with .tools/bin in PATH")
        })
}

fn said(done: &Output) -> String {
    let both = [done.stdout.as_slice(), done.stderr.as_slice()].concat();
    String::from_utf8_lossy(&both).into_owned()
}

fn lay(map: &RegisterMap, folder: &Path) {
    std::fs::write(folder.join("map.rdl"), system_rdl(map, "", "test")).unwrap();
    std::fs::write(folder.join("map.json"), json(map)).unwrap();
}

fn compared(folder: &Path) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/npu/compare_rdl.py");
    peakrdl(folder, &[&script.to_string_lossy(), "map.rdl", "map.json"])
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn peakrdl_reads_the_map_of_every_preset_as_the_json_has_it() {
    let wide = "[gu]\nrecords_a_row = 2\ncounter_bits = 64";
    let presets = PRESETS
        .iter()
        .map(|(name, _)| Config::preset(name).unwrap());
    for config in presets.chain([Config::from_toml(wide, "test").unwrap()]) {
        let folder = tempfile::tempdir().unwrap();
        lay(&register_map_of(&config).unwrap(), folder.path());
        let done = compared(folder.path());
        assert!(
            done.status.success() && said(&done).is_empty(),
            "{}",
            said(&done)
        );
        // Its exporters take it without a warning.
        for export in [
            &["ip-xact", "map.rdl", "-o", "map.xml"][..],
            &["html", "map.rdl", "-o", "html"],
            &["c-header", "map.rdl", "-o", "map.h"],
            &[
                "regblock",
                "map.rdl",
                "-o",
                "block",
                "--cpuif",
                "axi4-lite-flat",
            ],
        ] {
            let done = peakrdl(folder.path(), export);
            let text = said(&done);
            assert!(
                done.status.success() && !text.contains("warning"),
                "{export:?}: {text}"
            );
        }
    }
}

/// A difference in any property is found.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_map_that_differs_from_the_json_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let map = register_map_of(&Config::preset("small").unwrap()).unwrap();
    lay(&map, folder.path());
    let rdl = folder.path().join("map.rdl");
    let text = std::fs::read_to_string(&rdl).unwrap();
    for (from, to, expected) in [
        ("GU_LEFT @ 0x048", "GU_LEFT @ 0x05c", "offset 92"),
        ("SEGMENTS[14:8] = 7'h1", "SEGMENTS[14:8] = 7'h2", "reset 2"),
        ("SEGMENTS[14:8] = 7'h1", "SEGMENTS[15:9] = 7'h1", "low 9"),
        ("onwrite = woclr", "onwrite = wzc", "effect of a write"),
        ("sw = rw; hw = r; desc", "sw = r; hw = w; desc", "access"),
        ("singlepulse; ", "", "pulse False"),
        ("desc = \"Commands.\"", "desc = \"\"", "description"),
        ("GU_DONE[0:0]", "GU_END[0:0]", "fields"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&rdl, text.replacen(from, to, 1)).unwrap();
        let done = compared(folder.path());
        assert!(
            !done.status.success() && said(&done).contains(expected),
            "{from}: {}",
            said(&done)
        );
    }
}
