//! Verilog from a folder, verified like the generator's own.

use std::path::Path;
use std::process::Command;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_rtl::verify::{Settings, Verifier};
use potamoi_rtl::{EngineKind, ForeignRtl};
use potamoi_scene::Scene;
use potamoi_soc::emit::emit;

use super::scenes_common::verified;

fn small() -> Config {
    Config::preset("small").unwrap()
}

fn emitted(prefix: &str) -> tempfile::TempDir {
    emitted_of(&small(), prefix)
}

fn emitted_of(config: &Config, prefix: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in emit(config, prefix, "test").unwrap() {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// The first difference of a frame, if there is one, and the feature vectors and elements compared.
fn verify(folder: &Path, engine: EngineKind, prefix: Option<&str>) -> (Option<String>, [u64; 2]) {
    verify_of(&small(), folder, engine, prefix)
}

fn verify_of(
    config: &Config,
    folder: &Path,
    engine: EngineKind,
    prefix: Option<&str>,
) -> (Option<String>, [u64; 2]) {
    let settings = Settings {
        engine,
        seed: 3,
        gather_every: 9,
        vector_every: 40,
        splat_every: 1,
        inject: None,
        rtl: Some(ForeignRtl::read(folder, prefix).unwrap()),
        excerpt: Some(folder.join("around.vcd")),
    };
    let mut scene = Scene::open("lantern").unwrap();
    scene.set_size(Some(12), Some(12)).unwrap();
    let mut none = |_| {};
    let mut verifier = Verifier::new(config, settings, &mut none);
    let done = verified(&mut verifier, |units| {
        let done = scene.render_fixed(config, units);
        done.map(|_| ()).map_err(|error| error.to_string())
    });
    let failure = verifier.failure().map(|f| {
        assert!(f.excerpt.is_some(), "{f:?}");
        f.mismatch.to_string()
    });
    if let (Err(error), None) = (done, &failure) {
        panic!("{error}");
    }
    let compared = [
        verifier.gather_report().samples,
        verifier.vector_report().elements,
    ];
    (failure, compared)
}

/// What a preset emits, read from a folder, has no difference under Verilator.
fn agrees_as_emitted(preset: &str) {
    let config = Config::preset(preset).unwrap();
    let folder = emitted_of(&config, "");
    let (failure, compared) = verify_of(&config, folder.path(), EngineKind::Verilator, None);
    assert_eq!(failure, None, "{preset}");
    assert!(compared.iter().all(|n| *n > 20), "{preset}: {compared:?}");
}

#[test]
fn the_papers_units_agree_as_they_are_emitted() {
    agrees_as_emitted("paper");
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn the_units_of_all_presets_agree_as_they_are_emitted() {
    for (preset, _) in PRESETS {
        agrees_as_emitted(preset);
    }
}

#[test]
fn an_emitted_folder_agrees_whatever_its_prefix() {
    for (prefix, given) in [("", None), ("npu0_", Some("npu0_")), ("npu0_", None)] {
        let folder = emitted(prefix);
        let (failure, compared) = verify(folder.path(), EngineKind::Icarus, given);
        assert_eq!(failure, None);
        assert!(compared.iter().all(|n| *n > 20), "{compared:?}");
    }
}

#[test]
fn an_edited_folder_gives_its_first_difference() {
    let folder = emitted("");
    let path = folder.path().join("gathering_unit/reducer.v");
    let text = std::fs::read_to_string(&path).unwrap();
    let edited = text.replacen("acc[14] & (acc[15] | (|acc[13:0]))", "1'b0", 1);
    assert_ne!(text, edited);
    std::fs::write(&path, edited).unwrap();
    // A working folder of SymbiYosys has copies, which are left alone.
    let copies = folder.path().join("gathering_unit_prove");
    std::fs::create_dir_all(copies.join("src")).unwrap();
    std::fs::write(copies.join("config.sby"), "").unwrap();
    std::fs::write(copies.join("src/reducer.v"), &text).unwrap();
    for engine in [EngineKind::Icarus, EngineKind::Verilator] {
        let (failure, _) = verify(folder.path(), engine, None);
        let failure = failure.unwrap();
        assert!(
            failure.contains("m_axis_feat_tdata of port 0, bank") && failure.contains("next beat"),
            "{failure}"
        );
    }
}

/// What Yosys writes of the units: one file of gates around the memories, ports declared in the
/// body.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn a_netlist_that_yosys_wrote_agrees() {
    let folder = emitted("");
    let out = tempfile::tempdir().unwrap();
    for unit in ["gathering_unit", "vector_unit"] {
        let script = format!(
            "read_verilog {unit}/*.v; hierarchy -top {unit}; proc; flatten; opt; memory -nomap; \
             techmap; opt; write_verilog {}/{unit}.v",
            out.path().display()
        );
        let done = Command::new("yosys")
            .current_dir(folder.path())
            .args(["-q", "-p", &script])
            .output();
        let done = done.unwrap_or_else(|e| panic!("yosys: {e}; tools/setup installs it"));
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
    }
    let (failure, compared) = verify(out.path(), EngineKind::Verilator, None);
    assert_eq!(failure, None);
    assert!(compared.iter().all(|n| *n > 20), "{compared:?}");
}
