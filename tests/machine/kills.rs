//! Runs that are killed at any moment: no child outlives them, the next run is right, and nothing
//! is left behind after it.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::files;

/// A command, and the files that it writes.
struct Run {
    command: &'static [&'static str],
    outputs: &'static [&'static str],
}

const EMIT: Run = Run {
    command: &["emit", "--out-dir", "rtl"],
    outputs: &["rtl"],
};
const WARP: Run = Run {
    command: &[
        "warp",
        "--scene",
        "lantern",
        "--width",
        "16",
        "--frames",
        "3",
        "--out-dir",
        "w",
    ],
    outputs: &["w"],
};
const COST: Run = Run {
    command: &["cost", "--study", "methods", "--csv", "c.csv"],
    outputs: &["c.csv"],
};
const MODEL: Run = Run {
    command: &[
        "model",
        "--scene",
        "lantern",
        "--width",
        "12",
        "--frames",
        "2",
        "--window",
        "2",
        "--chrome-trace",
        "t.json",
    ],
    outputs: &["t.json"],
};
const VERIFY: Run = Run {
    command: &[
        "--config", "small", "verify", "--scene", "lantern", "--width", "8",
    ],
    outputs: &[],
};

/// Numbers that a seed decides (Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        let (a, c) = (6_364_136_223_846_793_005, 1_442_695_040_888_963_407);
        self.0 = self.0.wrapping_mul(a).wrapping_add(c);
        (self.0 >> 33) % end
    }
}

fn start(run: &Run, at: &Path, mark: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_potamoi"))
        .args(run.command)
        .current_dir(at.join("out"))
        .env("POTAMOI_CACHE", at.join("cache"))
        .env("TMPDIR", at.join("tmp"))
        .env("POTAMOI_TEST_MARK", mark)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Processes with a mark in their environment.
fn alive(mark: &str) -> usize {
    let marked = format!("POTAMOI_TEST_MARK={mark}\0");
    let entries = fs::read_dir("/proc").unwrap().flatten();
    let environments = entries.filter_map(|e| fs::read(e.path().join("environ")).ok());
    environments
        .filter(|all| String::from_utf8_lossy(all).contains(&marked))
        .count()
}

fn content(at: &Path, run: &Run) -> Vec<(String, Vec<u8>)> {
    let mut all = vec![];
    for name in files(&at.join("out")) {
        let bytes = fs::read(at.join("out").join(&name)).unwrap();
        all.push((name, bytes));
    }
    assert!(
        run.outputs
            .iter()
            .all(|o| all.iter().any(|(n, _)| n.starts_with(o)))
    );
    all
}

/// Kills a command so many times, each in a folder of its own.
fn kill(run: &Run, times: u64, random: &mut Random) {
    let fresh = || {
        let folder = tempfile::tempdir().unwrap();
        for inside in ["out", "cache", "tmp"] {
            fs::create_dir(folder.path().join(inside)).unwrap();
        }
        Command::new("chmod")
            .arg("0700")
            .arg(folder.path().join("cache"))
            .status()
            .unwrap();
        folder
    };
    let folder = fresh();
    let begin = Instant::now();
    assert!(start(run, folder.path(), "whole").wait().unwrap().success());
    let length = begin.elapsed().as_micros() as u64;
    let expected = content(folder.path(), run);
    for time in 0..times {
        let folder = fresh();
        let at = folder.path();
        let mark = format!("{}-{}-{time}", std::process::id(), run.command.join("-"));
        let mut child = start(run, at, &mark);
        let pause = random.below(length);
        std::thread::sleep(Duration::from_micros(pause));
        let signal = ["-TERM", "-KILL"][random.below(2) as usize];
        let id = child.id().to_string();
        Command::new("kill").args([signal, &id]).status().unwrap();
        child.wait().unwrap();
        let killed = Instant::now();
        while alive(&mark) > 0 {
            let waited = killed.elapsed();
            assert!(
                waited < Duration::from_secs(2),
                "{mark} {signal} after {pause} us"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let what = format!(
            "{} {signal} after {pause} of {length} us",
            run.command.join(" ")
        );
        assert!(start(run, at, "again").wait().unwrap().success(), "{what}");
        assert!(
            content(at, run) == expected,
            "{what}: {:?}",
            files(&at.join("out"))
        );
        let mut left = files(&at.join("cache"));
        left.retain(|name| name.split('/').any(|part| part.starts_with('.')));
        left.extend(files(&at.join("tmp")));
        let inside = fs::read_dir(at.join("tmp")).unwrap().count();
        assert!(left.is_empty() && inside == 0, "{what}: {left:?}");
    }
}

/// Files of a set of Verilog, without what a killed run may have left.
fn verilog(at: &Path) -> Vec<(String, Vec<u8>)> {
    let names = files(&at.join("out"));
    let own = names
        .into_iter()
        .filter(|name| !name.contains("/.potamoi-"));
    own.map(|name| (name.clone(), fs::read(at.join("out").join(&name)).unwrap()))
        .collect()
}

/// Kills emissions over the set of another configuration: the old set is there, or the new one.
fn kill_over(times: u64, random: &mut Random) {
    let small = Run {
        command: &["--config", "small", "emit", "--out-dir", "rtl"],
        outputs: &["rtl"],
    };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for inside in ["out", "cache", "tmp"] {
        fs::create_dir(at.join(inside)).unwrap();
    }
    let begin = Instant::now();
    let sets = [&EMIT, &small].map(|run| {
        assert!(start(run, at, "whole").wait().unwrap().success());
        verilog(at)
    });
    let length = begin.elapsed().as_micros() as u64 / 2;
    assert!(sets[0] != sets[1]);
    for time in 0..times {
        let mark = format!("{}-over-{time}", std::process::id());
        let mut child = start([&EMIT, &small][time as usize % 2], at, &mark);
        // Files are moved into place near the end.
        let pause = length * 3 / 4 + random.below(length / 2);
        std::thread::sleep(Duration::from_micros(pause));
        child.kill().unwrap();
        child.wait().unwrap();
        let killed = Instant::now();
        while alive(&mark) > 0 {
            assert!(killed.elapsed() < Duration::from_secs(2), "{mark}");
            std::thread::sleep(Duration::from_millis(1));
        }
        let found = verilog(at);
        let is_one = sets.contains(&found);
        assert!(is_one, "after {pause} of {length} us: neither set");
    }
}

#[test]
fn a_killed_run_leaves_nothing_behind() {
    let mut random = Random(1);
    kill(&EMIT, 2, &mut random);
    kill(&WARP, 1, &mut random);
    kill_over(6, &mut random);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn fifty_killed_runs_leave_nothing_behind() {
    let mut random = Random(2);
    kill(&EMIT, 20, &mut random);
    kill(&WARP, 10, &mut random);
    kill(&COST, 8, &mut random);
    kill(&MODEL, 8, &mut random);
    kill(&VERIFY, 6, &mut random);
    kill_over(150, &mut random);
}
