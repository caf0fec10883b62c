//! Sweeps on the workers of a Dask scheduler on the loopback: their bytes are those of threads, whoever is
//! killed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{expect, potamoi, stderr, stdout};

/// Longest wait for a process of Dask, or for lines of a journal.
const LONGEST: Duration = Duration::from_secs(180);

/// The Python with Dask distributed that `tools/setup` installs.
fn python() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join(".tools/bin/python3-dask");
    assert!(
        own.is_file(),
        "no {}: tools/setup dask installs it",
        own.display()
    );
    own
}

fn until(what: &str, done: &mut dyn FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < LONGEST, "{what} takes too long");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A scheduler with workers on the loopback, each in a process of its own.
struct Cluster {
    folder: PathBuf,
    address: String,
    scheduler: Child,
    workers: Vec<Child>,
}

impl Cluster {
    fn start(folder: &Path) -> Self {
        let file = folder.join("scheduler.json");
        let arguments = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"];
        let scheduler = Command::new(python())
            .args(["-m", "distributed.cli.dask_scheduler"])
            .args(arguments)
            .arg("--scheduler-file")
            .arg(&file)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = None;
        until("the scheduler", &mut || {
            let text = fs::read_to_string(&file).unwrap_or_default();
            let read = serde_json::from_str::<serde_json::Value>(&text).ok();
            address = read.and_then(|own| Some(own["address"].as_str()?.to_owned()));
            address.is_some()
        });
        Self {
            folder: folder.to_owned(),
            address: address.unwrap(),
            scheduler,
            workers: vec![],
        }
    }

    /// Starts a worker with a program.
    fn add(&mut self, program: &Path) {
        let name = format!("worker{}", self.workers.len());
        let worker = Command::new(python())
            .args(["-m", "distributed.cli.dask_worker", &self.address])
            .args(["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny"])
            .args(["--no-dashboard", "--name", &name, "--local-directory"])
            .arg(self.folder.join(name))
            .env("POTAMOI_PROGRAM", program)
            .stderr(Stdio::null())
            .spawn();
        self.workers.push(worker.unwrap());
    }

    fn add_right(&mut self) {
        self.add(Path::new(env!("CARGO_BIN_EXE_potamoi")));
    }

    /// The command that sweeps the plan of the folder on this cluster.
    fn sweep(&self, out: &str) -> Command {
        let mut command = sweep(&self.folder, out, "cache-of-runner");
        command
            .args(["--engine", "dask", "--scheduler", &self.address])
            .env("POTAMOI_PYTHON", python());
        command
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for child in self.workers.iter_mut().chain([&mut self.scheduler]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn sweep(folder: &Path, out: &str, cache: &str) -> Command {
    let mut command = potamoi();
    command
        .current_dir(folder)
        .env("POTAMOI_CACHE", folder.join(cache))
        .args(["sweep", "plan.toml", "--work-dir", out]);
    command
}

/// What a command printed that succeeded.
fn said(output: &Output) -> String {
    let text = stdout(output) + &stderr(output);
    assert!(output.status.success(), "{text}");
    text
}

/// Lines of a journal by key, none of which it has twice.
fn journal(folder: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(folder.join("journal.jsonl")).unwrap();
    let mut found = BTreeMap::new();
    for line in text.lines().skip(1) {
        let own: serde_json::Value = serde_json::from_str(line).unwrap();
        let key = own["key"].as_str().unwrap().to_owned();
        assert!(
            found.insert(key, line.to_owned()).is_none(),
            "twice: {line}"
        );
    }
    found
}

fn assert_equal(folder: &Path, out: &str) {
    let bytes = |of: &str| fs::read(folder.join(of).join("rows.csv")).unwrap();
    assert!(bytes("threads") == bytes(out), "{out}");
    assert_eq!(
        journal(&folder.join("threads")),
        journal(&folder.join(out)),
        "{out}"
    );
}

fn lines(folder: &Path) -> usize {
    let text = fs::read_to_string(folder.join("journal.jsonl"));
    text.map_or(0, |text| text.lines().count())
}

/// Names of the files of counted work. Rates of memories are none: each worker measures them in a moment.
fn counted(cache: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(cache.join("work")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    let names = names.map(|name| name.to_string_lossy().into_owned());
    names.filter(|name| !name.starts_with("rate-")).collect()
}

/// A program that is not the sweep's, and a file that is there once it ran.
fn another_program(folder: &Path) -> (PathBuf, PathBuf) {
    let (program, ran) = (folder.join("another"), folder.join("another-ran"));
    let text = format!(
        "#!/bin/sh\n: > {}\nexec {} \"$@\"\n",
        ran.display(),
        env!("CARGO_BIN_EXE_potamoi")
    );
    fs::write(&program, text).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    (program, ran)
}

/// A plan with a machine and a device in files of their own.
fn write_plan(folder: &Path, vary: &str) {
    let machine = "preset = \"paper\"\n[system]\ngpu.device = \"gpu.toml\"\n";
    fs::write(folder.join("own.toml"), machine).unwrap();
    let device = "sim/gpu/devices/xavier-nx.toml";
    let device = Path::new(env!("CARGO_MANIFEST_DIR")).join(device);
    fs::copy(device, folder.join("gpu.toml")).unwrap();
    let plan = format!("machines = [\"own.toml\"]\nscenes = [\"garden\"]\n{vary}");
    fs::write(folder.join("plan.toml"), plan).unwrap();
}

#[test]
fn a_sweep_on_two_workers_has_the_bytes_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_plan(
        at,
        "width = 16\n[vary]\n\"vu.lanes\" = [3, 6, 12, 24, 48]\n\"system.memory_channels\" = [1, 2]\n\
         \"gu.banks\" = [16, 0]\n",
    );
    let mut cluster = Cluster::start(at);
    let (program, ran) = another_program(at);
    cluster.add_right();
    cluster.add_right();
    cluster.add(&program);
    said(&sweep(at, "threads", "cache").output().unwrap());
    let text = said(&cluster.sweep("dask").output().unwrap());
    assert_equal(at, "dask");
    // Refused points are alike where they break the same rule.
    assert!(text.contains("20 points: 11 evaluated now"), "{text}");
    assert_eq!(
        text.matches("is refused and gets no points").count(),
        1,
        "{text}"
    );
    assert!(text.contains("SHA-256") && !ran.exists(), "{text}");
    // All that was counted came back, and nothing was counted twice.
    assert_eq!(
        counted(&at.join("cache")),
        counted(&at.join("cache-of-runner"))
    );
    assert!(!text.contains("made by two workers"), "{text}");
    let again = said(&cluster.sweep("dask").output().unwrap());
    assert!(again.contains(": 0 evaluated now"), "{again}");
    let parquet = Command::new(python())
        .current_dir(at)
        .env(
            "PYTHONPATH",
            Path::new(env!("CARGO_MANIFEST_DIR")).join("python"),
        )
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .args(["-m", "potamoi.parquet", "dask/rows.csv", "rows.parquet"])
        .output();
    assert!(said(&parquet.unwrap()).contains("20 rows"));
}

#[test]
fn what_a_cluster_needs_is_told_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_plan(at, "width = 8\n");
    let on = |code: i32, rest: &[&str]| {
        let own = ["sweep", "plan.toml", "--work-dir", "out"];
        expect(at, code, &[&own[..], rest].concat())
    };
    assert!(on(2, &["--engine", "dask"]).contains("--scheduler"));
    let both = ["--scheduler", "tcp://127.0.0.1:1"];
    assert!(on(2, &both).contains("--engine dask"));
    let engine = |address: &str, python: &Path| {
        let mut command = sweep(at, "out", "cache");
        command.args(["--engine", "dask", "--scheduler", address]);
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
        command.env("PYTHONPATH", sources);
        let done = command.env("POTAMOI_PYTHON", python).output().unwrap();
        (done.status.code(), stderr(&done))
    };
    let (code, text) = engine("tcp://10.0.0.5:8786", &python());
    assert!(code == Some(2) && text.contains("tls://"), "{text}");
    let bare = at.join("bare");
    fs::write(&bare, "#!/bin/sh\nexec python3 -S \"$@\"\n").unwrap();
    fs::set_permissions(&bare, fs::Permissions::from_mode(0o755)).unwrap();
    let (code, text) = engine("tcp://127.0.0.1:1", &bare);
    assert!(code == Some(3) && text.contains("distributed"), "{text}");
    assert!(text.contains("pip install"), "{text}");
    let (code, text) = engine("tcp://127.0.0.1:1", &at.join("none"));
    assert!(code == Some(3) && text.contains("pip install"), "{text}");
    assert!(!at.join("out/rows.csv").exists());
}

/// What `--missing` lists is what `--points` evaluates, and each point has one line.
#[test]
fn points_are_listed_and_evaluated_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_plan(
        at,
        "width = 8\n[vary]\n\"vu.lanes\" = [3, 6]\n\"gu.banks\" = [16, 0]\n",
    );
    let listed = expect(
        at,
        0,
        &["sweep", "plan.toml", "--work-dir", "out", "--missing"],
    );
    // Keys are those of the content, from wherever the plan is named.
    let elsewhere = tempfile::tempdir().unwrap();
    let plan = at.join("plan.toml").display().to_string();
    let again = ["sweep", &plan, "--work-dir", "out", "--missing"];
    assert_eq!(expect(elsewhere.path(), 0, &again), listed);
    let listed: Vec<serde_json::Value> = listed
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let numbers: Vec<String> = listed.iter().map(|own| own["number"].to_string()).collect();
    let printed = expect(
        at,
        0,
        &["sweep", "plan.toml", "--points", &numbers.join(",")],
    );
    let mut printed: Vec<&str> = printed.lines().collect();
    printed.sort_unstable();
    said(&sweep(at, "out", "cache").output().unwrap());
    let journal = journal(&at.join("out"));
    assert_eq!(journal.len(), listed.len());
    assert!(
        listed
            .iter()
            .all(|own| journal.contains_key(own["key"].as_str().unwrap()))
    );
    let mut lines: Vec<&str> = journal.values().map(String::as_str).collect();
    lines.sort_unstable();
    assert_eq!(printed, lines);
    let text = expect(at, 2, &["sweep", "plan.toml", "--points", "4"]);
    assert!(text.contains("below 4"), "{text}");
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

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn nothing_is_lost_and_nothing_twice_whoever_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_plan(
        at,
        "width = 48\n[vary]\n\"vu.lanes\" = { from = 1, to = 25, step = 1 }\n\
         \"system.memory_channels\" = [1, 2, 4, 8]\n\"gu.banks\" = [16, 32]\n",
    );
    said(&sweep(at, "threads", "cache").output().unwrap());
    let all = journal(&at.join("threads")).len();
    assert_eq!(all, 200);
    let mut cluster = Cluster::start(at);
    cluster.add_right();
    cluster.add_right();
    // One of two workers is killed while it has points.
    let output = |name: &str| fs::File::create(at.join(name)).unwrap();
    let mut run = cluster.sweep("worker-killed");
    let mut run = run.stderr(output("said")).spawn().unwrap();
    until("the first half", &mut || {
        lines(&at.join("worker-killed")) > all / 4
    });
    cluster.workers[0].kill().unwrap();
    assert!(
        lines(&at.join("worker-killed")) <= all,
        "all were finished before"
    );
    assert!(run.wait().unwrap().success());
    let text = fs::read_to_string(at.join("said")).unwrap();
    assert!(text.contains("is gone"), "{text}");
    assert_equal(at, "worker-killed");
    // The whole sweep is killed, and goes on.
    cluster.add_right();
    let mark = format!("{}-sweep", std::process::id());
    let mut run = cluster.sweep("sweep-killed");
    let mut run = run.env("POTAMOI_TEST_MARK", &mark).spawn().unwrap();
    until("the first half", &mut || {
        lines(&at.join("sweep-killed")) > all / 4
    });
    run.kill().unwrap();
    run.wait().unwrap();
    until("the end of the runner", &mut || alive(&mark) == 0);
    let before = lines(&at.join("sweep-killed")) - 1;
    assert!(before < all, "all were finished before");
    let text = said(&cluster.sweep("sweep-killed").output().unwrap());
    let now = format!("{} evaluated now", all - before);
    // The last line may have been torn.
    let torn = format!("{} evaluated now", all - before + 1);
    assert!(
        text.contains(&now) || text.contains(&torn),
        "{before}: {text}"
    );
    assert_equal(at, "sweep-killed");
    // A plan that is named by its whole path lies elsewhere on a worker, and has the same rows.
    let mut whole = potamoi();
    let plan = at.join("plan.toml");
    whole.arg("sweep").arg(plan).arg("--work-dir");
    whole.arg(at.join("whole-path"));
    whole.args(["--engine", "dask", "--scheduler", &cluster.address]);
    whole.env("POTAMOI_CACHE", at.join("cache"));
    said(&whole.env("POTAMOI_PYTHON", python()).output().unwrap());
    assert_equal(at, "whole-path");
}
