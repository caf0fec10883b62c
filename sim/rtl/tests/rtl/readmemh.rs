//! The `$readmemh` files and their testbenches, run by Icarus Verilog alone.
use std::path::Path;
use std::process::Command;

use potamoi_formats::config::Config;
use potamoi_reference::trace_recorder::Limits;
use potamoi_rtl::bench::readmemh;
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;
use potamoi_soc::emit::emit;

fn run(folder: &Path, unit: &str) -> String {
    let mut sources = vec![format!("{unit}_tb.v")];
    for file in std::fs::read_dir(folder.join(unit)).unwrap() {
        let name = file.unwrap().file_name();
        sources.push(format!("{unit}/{}", name.to_str().unwrap()));
    }
    let done = Command::new("iverilog")
        .current_dir(folder)
        .args(["-g2005", "-Wall", "-o", "tb"])
        .args(&sources)
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let done = Command::new("vvp")
        .current_dir(folder)
        .args(["-n", "tb"])
        .output()
        .unwrap();
    let said = String::from_utf8(done.stdout).unwrap();
    assert_eq!(done.status.success(), said.contains("PASS"), "{said}");
    said
}

#[test]
fn the_testbenches_pass_and_find_a_changed_bit() {
    check("banks = 8\nports = 2\nsegments = 2");
}

#[test]
fn the_testbenches_of_banks_of_whole_vectors_do_so_too() {
    check("organisation = \"feature-major\"\nbanks = 8\nports = 2\nlanes = 6\nsegments = 2");
}

#[test]
fn the_testbenches_of_exact_sums_and_shared_rows_do_so_too() {
    check("banks = 32\nrecords_a_row = 2\nsums = \"exact\"\npipelined = true");
}

/// Of samples that lie in several MVoxels, the sums of their parts come out of the hardware.
#[test]
fn the_testbenches_of_parted_samples_do_so_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("split.toml");
    let model = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n";
    std::fs::write(&path, format!("{model}[render]\nhalo = \"split\"\n")).unwrap();
    let scene = Scene::open(path.to_str().unwrap()).unwrap();
    check_scenes("banks = 8\nsums = \"exact\"", [("split", scene)]);
}

fn check(gu: &str) {
    let scenes = ["garden", "lantern"].map(|name| (name, Scene::open(name).unwrap()));
    check_scenes(gu, scenes);
}

fn check_scenes<const N: usize>(gu: &str, scenes: [(&str, Scene); N]) {
    let text = format!("[gu]\n{gu}\n[rit]\nentries = 16\n[vu]\nlanes = 5");
    let config = Config::from_toml(&text, "test").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = emit(&config, "", "test").unwrap();
    for (path, text) in &files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    for (name, mut scene) in scenes {
        scene.set_size(Some(20), Some(20)).unwrap();
        let limits = Limits {
            entries: 120,
            elements: 900,
        };
        let trace = Trace::record(&scene, &config, limits).unwrap();
        let files = readmemh(&config, &trace.gathered, &trace.computed, "potamoi emit").unwrap();
        for (name, memory) in &files.memories {
            let text = &files.texts[name];
            assert_eq!(text.lines().count(), memory.count, "{name}");
            let digits = memory.width.div_ceil(4) as usize;
            assert!(text.lines().all(|l| l.len() == digits), "{name}");
        }
        for (name, text) in &files.texts {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        for unit in ["gathering_unit", "vector_unit"] {
            let said = run(folder.path(), unit);
            assert!(said.contains("PASS"), "{name} {unit}: {said}");
        }
        // The lowest bit of the last word.
        for (unit, file) in [
            ("gathering_unit", "gather_feat.hex"),
            ("vector_unit", "vector_out.hex"),
        ] {
            let mut text = files.texts[file].trim_end().to_owned();
            let digit = text.pop().unwrap().to_digit(16).unwrap();
            text.push(char::from_digit(digit ^ 1, 16).unwrap());
            std::fs::write(folder.path().join(file), text).unwrap();
            let said = run(folder.path(), unit);
            assert!(said.contains("FAIL: beat "), "{name} {unit}: {said}");
        }
    }
}
