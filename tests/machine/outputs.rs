use std::fs;
use std::os::unix::fs::{FileTypeExt as _, symlink};

use super::{expect, files};

#[test]
fn links_stay_and_streams_are_written_into() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("target"), "old").unwrap();
    symlink("target", at.join("link")).unwrap();
    symlink("nothing", at.join("dangling")).unwrap();
    expect(at, 0, "$P estimate --json link");
    assert!(fs::symlink_metadata(at.join("link")).unwrap().is_symlink());
    assert!(
        fs::read_to_string(at.join("target"))
            .unwrap()
            .contains("estimate")
    );
    let said = expect(at, 2, "$P estimate --json dangling");
    assert!(said.contains("a link that leads nowhere"), "{said}");
    expect(at, 0, "$P estimate --json /dev/null");
    let null = fs::metadata("/dev/null").unwrap().file_type();
    assert!(null.is_char_device());
    let said = expect(
        at,
        0,
        "$P estimate --json /dev/stdout | grep format_version",
    );
    assert!(said.contains("format_version"));
    let said = expect(at, 2, "mkfifo pipe; timeout 5 $P estimate --json pipe");
    assert!(said.contains("a FIFO that nobody reads"), "{said}");
    let whole = expect(
        at,
        0,
        "timeout 5 cat pipe & sleep 0.2; $P estimate --json pipe; wait",
    );
    assert!(whole.contains("format_version"), "{whole}");
}

#[test]
fn a_file_has_one_part() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let render = "$P render --scene garden --width 8 --numerics float";
    let said = expect(at, 2, &format!("{render} --out q.png --json ./q.png"));
    assert!(said.contains("are the same file"), "{said}");
    assert!(!at.join("q.png").exists(), "refused before any work");
    fs::write(
        at.join("s.toml"),
        "[model]\nkind = \"builtin\"\nname = \"lantern\"\n",
    )
    .unwrap();
    let frames = format!("{render} --frames 2 --out f.png --json f.0001.png");
    let said = expect(at, 2, &frames);
    assert!(said.contains("ends in .json"), "{said}");
    let before = fs::read(at.join("s.toml")).unwrap();
    for output in ["s.toml", "./s.toml", "hard"] {
        let make = "ln -f s.toml hard";
        let run = format!("{make}; $P characterise --scene s.toml --width 8 --json {output}");
        let said = expect(at, 2, &run);
        assert!(said.contains("would overwrite"), "{said}");
    }
    assert_eq!(fs::read(at.join("s.toml")).unwrap(), before);
}

#[test]
fn standard_output_is_full_or_closed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let said = expect(at, 2, "$P estimate > /dev/full");
    assert!(said.contains("cannot write standard output"), "{said}");
    for asked in ["--help", "--version", "help emit", "emit --help", "emit -h"] {
        let said = expect(at, 2, &format!("$P {asked} > /dev/full"));
        assert!(said.contains("cannot write standard output"), "{said}");
        expect(at, 0, &format!("$P {asked} > told; test -s told"));
        let gone = format!("{{ $P {asked}; echo $? > code; }} | true; grep -qx 0 code");
        expect(at, 0, &gone);
    }
    expect(at, 2, "$P emit --nothing");
    for command in ["estimate", "doctor", "cache"] {
        let said = expect(
            at,
            0,
            &format!("{{ $P {command} 2>&3; echo $? > code; }} 3>err | true; cat err"),
        );
        assert!(
            !said.contains("panicked") && !said.contains("roken pipe"),
            "{said}"
        );
    }
    expect(at, 2, "$P estimate --fit-to nothing 2>&-");
}

#[test]
fn pipes_and_devices_are_no_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(at, 0, "mkfifo p.ply p.spz p.toml p.json");
    for input in [
        "render --out o.png --width 8 --scene p.ply",
        "render --out o.png --width 8 --scene p.spz",
        "render --out o.png --width 8 --scene p.toml",
        "render --out o.png --width 8 --scene garden --camera p.json",
        "emit --out-dir rtl --config p.toml",
        "estimate --fit-to p.json",
        "model --scene garden --system p.toml",
        "verify --trace p.json",
    ] {
        let said = expect(at, 2, &format!("timeout 10 $P {input}"));
        assert!(said.contains("a FIFO"), "{input}: {said}");
    }
    let said = expect(
        at,
        2,
        "(ulimit -v 1500000; timeout 20 $P estimate --fit-to /dev/zero)",
    );
    assert!(said.contains("a device"), "{said}");
}

#[test]
fn emissions_replace_one_another_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(
        at,
        0,
        "$P --config feature-major emit --out-dir x; $P emit --out-dir p; cp -r x f",
    );
    // A limit of file sizes stands for a full disk.
    let script = "(trap '' XFSZ; ulimit -f 40; $P emit --out-dir x)";
    let said = expect(at, 2, script);
    assert!(said.contains("cannot write"), "{said}");
    expect(at, 0, "diff -r x f");
    fs::write(at.join("x/gathering_unit/mine.v"), "mine").unwrap();
    expect(
        at,
        0,
        "$P emit --out-dir x; rm x/gathering_unit/mine.v; diff -r x p",
    );
    // Edited and foreign files.
    expect(
        at,
        0,
        "echo edited >> x/vector_unit/vector_unit.v; cp -r x e",
    );
    let said = expect(at, 2, "$P --config small emit --out-dir x");
    assert!(
        said.contains("vector_unit/vector_unit.v") && said.contains("--overwrite"),
        "{said}"
    );
    expect(
        at,
        0,
        "diff -r x e; $P --config small emit --out-dir x --overwrite",
    );
    expect(at, 0, "$P --config small emit --out-dir s; diff -r x s");
    // A pipe that is none of the files stays, one that would be is refused.
    let said = expect(
        at,
        2,
        "mkfifo x/gathering_unit/x.v; $P --config small emit --out-dir x || exit 9; \
         mkdir -p y/vector_unit; mkfifo y/vector_unit/vector_unit.v; \
         timeout 5 $P emit --out-dir y --overwrite",
    );
    assert!(said.contains("a FIFO and is never replaced"), "{said}");
    assert!(files(at).iter().all(|name| !name.contains(".potamoi")));
}

#[test]
fn memory_that_is_refused_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let render = "$P render --scene lantern --width 16 --numerics float --out o.png";
    expect(at, 0, &format!("(ulimit -v 4000000; {render})"));
    let said = expect(
        at,
        2,
        "(ulimit -v 200000; $P render --scene garden --width 16384 --out o.png)",
    );
    assert!(said.contains("limit of 195 MiB"), "{said}");
    let large = "head -c 300000000 /dev/zero > large.ply";
    let run = "(ulimit -v 200000; $P render --scene large.ply --width 8 --out o.png)";
    let said = expect(at, 2, &format!("{large}; {run}"));
    assert!(said.contains("do not fit"), "{said}");
}
