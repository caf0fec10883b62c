//! Building, caching and refusing models.

use potamoi_verilated::{
    Direction::{Input, Output},
    Error, ModelBuilder, Opt, Toolchain, Warnings,
};
use std::{
    ffi::OsString,
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

const GOOD: &str = "module m(input wire [3:0] a, output wire [3:0] y); assign y = ~a; endmodule";

fn tools() -> Toolchain {
    Toolchain::detect().expect("these tests need Verilator 5 and a C++ compiler")
}

/// Verilator's own objects are shared by all tests; models are built anew in each.
fn fresh_cache() -> tempfile::TempDir {
    let shared = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("models");
    let cache = tempfile::tempdir().unwrap();
    builder(&shared).build(&tools()).unwrap();
    for entry in fs::read_dir(&shared).unwrap() {
        let from = entry.unwrap().path();
        let name = from.file_name().unwrap().to_str().unwrap();
        if name.starts_with("runtime-") {
            copy(&from, &cache.path().join(name));
        }
    }
    cache
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

fn builder(cache: &Path) -> ModelBuilder {
    ModelBuilder::new("m")
        .source("m.v", GOOD)
        .optimise(Opt::O0)
        .cache_dir(cache)
}

/// A Verilator that writes a line to `log` for every design it reads.
fn counting(folder: &Path) -> (Toolchain, PathBuf) {
    let (script, log) = (folder.join("verilator"), folder.join("log"));
    let real = tools().verilator_path().display().to_string();
    let text = format!(
        "#!/bin/sh\ncase \"$*\" in *--cc*) echo run >> '{}';; esac\nexec '{real}' \"$@\"\n",
        log.display()
    );
    fs::write(&script, text).unwrap();
    fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).unwrap();
    let env = |name: &str| match name {
        "VERILATOR" => Some(OsString::from(&script)),
        _ => std::env::var_os(name),
    };
    (Toolchain::detect_in(&env).unwrap(), log)
}

fn runs(log: &Path) -> usize {
    fs::read_to_string(log).unwrap_or_default().lines().count()
}

fn complement(library: &potamoi_verilated::Library, a: u64) -> u64 {
    let mut model = library.model(1).unwrap();
    model.set_u64(library.port("a").unwrap(), a).unwrap();
    model.eval().unwrap();
    model.get_u64(library.port("y").unwrap()).unwrap()
}

#[test]
fn a_cached_model_is_not_built_again_unless_damaged() {
    let cache = fresh_cache();
    let bin = tempfile::tempdir().unwrap();
    let (tools, log) = counting(bin.path());
    let first = builder(cache.path()).build(&tools).unwrap();
    assert!(!first.was_cached());
    let second = builder(cache.path()).build(&tools).unwrap();
    assert!(second.was_cached());
    assert_eq!(runs(&log), 1);

    let file = cache.path().join(format!("m-{}/model.so", second.key()));
    drop((first, second));
    let whole = fs::read(&file).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    for (i, bytes) in [&whole[..whole.len() / 2], &damaged[..], b""]
        .iter()
        .enumerate()
    {
        // A library may stay mapped until its thread ends, so its file is replaced and not written.
        fs::remove_file(&file).unwrap();
        fs::write(&file, bytes).unwrap();
        let again = builder(cache.path()).build(&tools).unwrap();
        assert!(!again.was_cached());
        assert_eq!(runs(&log), i + 2);
        assert_eq!(complement(&again, 5), 10);
    }
}

#[test]
fn threads_that_build_the_same_model_build_it_once() {
    let cache = fresh_cache();
    let bin = tempfile::tempdir().unwrap();
    let (tools, log) = counting(bin.path());
    std::thread::scope(|scope| {
        let build = || complement(&builder(cache.path()).build(&tools).unwrap(), 3);
        let jobs: Vec<_> = (0..4).map(|_| scope.spawn(build)).collect();
        for job in jobs {
            assert_eq!(job.join().unwrap(), 12);
        }
    });
    assert_eq!(runs(&log), 1);
    let left: Vec<String> = fs::read_dir(cache.path())
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| n.starts_with('.'))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

const CHILD_CACHE: &str = "POTAMOI_TEST_CHILD_CACHE";

/// Run by the next test in processes of its own; without its variable it has nothing to do.
#[test]
fn child_process_builds() {
    if let Some(cache) = std::env::var_os(CHILD_CACHE) {
        let library = builder(Path::new(&cache)).build(&tools()).unwrap();
        assert_eq!(complement(&library, 9), 6);
    }
}

#[test]
fn processes_that_build_the_same_model_agree() {
    let cache = fresh_cache();
    let program = std::env::current_exe().unwrap();
    let children: Vec<_> = (0..3)
        .map(|_| {
            std::process::Command::new(&program)
                .args(["--exact", "building::child_process_builds"])
                .env(CHILD_CACHE, cache.path())
                .stdout(std::process::Stdio::null())
                .spawn()
                .unwrap()
        })
        .collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let library = builder(cache.path()).build(&tools()).unwrap();
    assert!(library.was_cached());
    assert_eq!(complement(&library, 9), 6);
}

#[test]
fn content_decides_what_is_the_same() {
    let cache = fresh_cache();
    let one = builder(cache.path()).build(&tools()).unwrap();
    let text = GOOD.replace("~a", "a");
    let other = ModelBuilder::new("m")
        .source("m.v", text)
        .cache_dir(cache.path())
        .build(&tools())
        .unwrap();
    assert_ne!(one.key(), other.key());
    assert_eq!((complement(&one, 4), complement(&other, 4)), (11, 4));
}

#[test]
fn verilog_that_is_refused_gives_verilators_text() {
    let cache = fresh_cache();
    let build = |text: &str, warnings| {
        ModelBuilder::new("m")
            .source("m.v", text)
            .warnings(warnings)
            .cache_dir(cache.path())
            .build(&tools())
    };
    let error = build("module m(input a output b); endmodule", Warnings::Deny).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::Tool { .. }));
    assert!(
        text.contains("m.v:1:") && text.contains("syntax error"),
        "{text}"
    );

    let warns = "module m(input wire [7:0] a, output wire [3:0] y); assign y = a; endmodule";
    let text = build(warns, Warnings::Deny).unwrap_err().to_string();
    assert!(text.contains("WIDTH"), "{text}");
    build(warns, Warnings::Allow).unwrap();

    let text = build("module n; endmodule", Warnings::Deny)
        .unwrap_err()
        .to_string();
    assert!(text.contains("m"), "{text}");
}

#[test]
fn ports_that_are_not_as_stated_are_refused() {
    let cache = fresh_cache();
    let with = |name: &str, bits, dir| builder(cache.path()).port(name, bits, dir).build(&tools());
    with("a", 4, Input).unwrap();
    let text = with("b", 4, Input).unwrap_err().to_string();
    assert_eq!(
        text,
        "module m has no port b; its ports are: input a (4 bits), output y (4 bits)"
    );
    for (bits, dir) in [(5, Input), (4, Output), (0, Input)] {
        let error = with("a", bits, dir).unwrap_err();
        assert!(matches!(error, Error::PortMismatch { .. }), "{error}");
        assert!(
            error
                .to_string()
                .contains("the Verilog has input a (4 bits)")
        );
    }
}

#[test]
fn a_description_that_cannot_be_built_is_refused() {
    let cache = fresh_cache();
    let none = ModelBuilder::new("m")
        .cache_dir(cache.path())
        .build(&tools());
    assert!(matches!(none, Err(Error::NoSource { .. })));
    let twice = builder(cache.path()).source("m.v", GOOD).build(&tools());
    assert!(matches!(twice, Err(Error::BadName { .. })));
    let file = cache.path().join("file");
    fs::write(&file, "").unwrap();
    let no_folder = builder(&file).build(&tools());
    assert!(matches!(no_folder, Err(Error::NoFolder { .. })));
}

#[test]
fn included_files_are_found() {
    let cache = fresh_cache();
    let library = ModelBuilder::new("m")
        .source("inc.vh", "`define W 4\n")
        .source(
            "m.v",
            "`include \"inc.vh\"\nmodule m(input wire [`W-1:0] a, output wire [`W-1:0] y); \
             assign y = ~a; endmodule",
        )
        .cache_dir(cache.path())
        .build(&tools())
        .unwrap();
    assert_eq!(complement(&library, 1), 14);
}
