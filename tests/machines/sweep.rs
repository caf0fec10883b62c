//! Sweeps: from plans to rows, through kills and mistakes.

use std::fs;
use std::time::{Duration, Instant};

use super::assert_narrow;
use crate::common::{expect, potamoi, words};

const PLAN: &str = "scenes = [\"garden\"]\nwidth = 48\n[vary]\n\"vu.lanes\" = { from = 2, to = 16, step = 1 }\n\
    \"system.memory_channels\" = [1, 2, 4]\n\"gu.banks\" = [16, 0, 32]\nclock_ghz = [\"reached\", 1.0]\n";

#[test]
fn a_killed_sweep_goes_on_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("plan.toml"), PLAN).unwrap();
    let sweep = |out: &'static str| {
        [
            "sweep",
            "plan.toml",
            "--work-dir",
            out,
            "--front",
            "fps,mm2",
        ]
    };
    let whole = expect(path, 0, &sweep("whole"));
    assert!(whole.contains("270 points: 181 evaluated now"), "{whole}");
    assert!(
        whole.contains("90 without figures") && whole.contains("gu.banks"),
        "{whole}"
    );
    let mut child = potamoi()
        .current_dir(path)
        .args(sweep("killed"))
        .spawn()
        .unwrap();
    let journal = path.join("killed/journal.jsonl");
    let lines = || fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    let begun = Instant::now();
    while lines() < 40 && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = lines() - 1;
    assert!((39..181).contains(&before), "{before}");
    let resumed = expect(path, 0, &sweep("killed"));
    let count = |text: &str, after: &str| -> usize {
        let at = text.find(after).unwrap();
        let digits = text[..at].rsplit(' ').next().unwrap();
        digits.parse().unwrap()
    };
    let (read, now) = (
        count(&resumed, " read from"),
        count(&resumed, " evaluated now"),
    );
    // The last line may have been torn.
    assert!(read + now == 181 && before - read <= 1, "{resumed}");
    let bytes = |of: &str| fs::read(path.join(of).join("rows.csv")).unwrap();
    assert!(bytes("whole") == bytes("killed"));
    let again = expect(
        path,
        0,
        &[&sweep("killed")[..], &["--beside", "whole"]].concat(),
    );
    assert!(
        again.contains(": 0 evaluated now") && again.contains("0 figures differ"),
        "{again}"
    );
    assert_narrow(&again);
}

/// On one thread of the pool, too.
#[test]
fn a_sweep_has_the_same_bytes_on_one_thread() {
    let folder = tempfile::tempdir().unwrap();
    let plan = "scenes = [\"lantern\"]\nwidth = 16\n[vary]\n\"vu.lanes\" = [3, 6]\n\"gu.ports\" = [1, 2]\n";
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    for (out, threads) in [("one", "1"), ("many", "4")] {
        let mut command = potamoi();
        command
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads);
        let done = command
            .args(["sweep", "plan.toml", "--work-dir", out])
            .output()
            .unwrap();
        assert!(done.status.success());
    }
    let bytes = |of: &str| fs::read(folder.path().join(of).join("rows.csv")).unwrap();
    assert!(bytes("one") == bytes("many"));
}

/// A sweep without a figure is no success, and its rows say why.
#[test]
fn a_sweep_of_refused_points_alone_fails() {
    let folder = tempfile::tempdir().unwrap();
    let plan =
        "machines = [\"lean-splats\"]\nscenes = [\"lantern\"]\nwidth = 8\n[workload]\nframes = 1\n";
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    let text = expect(
        folder.path(),
        2,
        &["sweep", "plan.toml", "--work-dir", "out"],
    );
    assert!(text.contains("no point has figures"), "{text}");
    let rows = fs::read_to_string(folder.path().join("out/rows.csv")).unwrap();
    assert!(rows.contains("relu"), "{rows}");
}

#[test]
fn mistakes_of_a_plan_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    for (plan, said) in [
        ("[vary]\n\"vu.lnes\" = [3]", "vu.lnes"),
        ("[vary]\n\"vu.lanes\" = 3", "a list of values"),
        (
            "[vary]\n\"vu.lanes\" = { from = 3, to = 1, step = 1 }",
            "does not end",
        ),
        ("sceens = [\"garden\"]", "sceens"),
        ("scenes = [\"gardn\"]", "gardn"),
        ("machines = [\"papr\"]", "papr"),
        ("[workload]\nframes = 0", "1 frame or more"),
        (
            "[[together]]\n\"vu.lanes\" = [1, 2]\n\"gu.ports\" = [1]",
            "equally long",
        ),
        (
            "[vary]\n\"vu.lanes\" = [1]\n[[together]]\n\"vu.lanes\" = [2]",
            "varies twice",
        ),
    ] {
        fs::write(folder.path().join("plan.toml"), plan).unwrap();
        let text = expect(
            folder.path(),
            2,
            &["sweep", "plan.toml", "--work-dir", "out"],
        );
        assert!(text.contains(said), "{plan}: {text}");
        assert!(!folder.path().join("out").exists(), "{plan}");
    }
    fs::write(folder.path().join("plan.toml"), "").unwrap();
    let arguments = ["sweep", "plan.toml", "--work-dir", "out", "--front", "psnr"];
    let text = expect(folder.path(), 2, &arguments);
    assert!(
        text.contains("--front psnr") && text.contains("did you mean `psnr_db`?"),
        "{text}"
    );
}

/// Another plan in a used folder takes the place of its rows, which are named; a finished folder lacks
/// nothing; and a figure that no row has is on no front.
#[test]
fn what_a_used_folder_has_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |name: &str, lanes: &str| {
        let text = format!(
            "width = 8\n[workload]\nframes = 2\nquality = false\n[vary]\n\"vu.lanes\" = [{lanes}]\n"
        );
        fs::write(folder.path().join(name), text).unwrap();
    };
    plan("a.toml", "3, 6");
    plan("b.toml", "6, 12");
    let sweep = |plan: &str, more: &[&str]| {
        let all = [&["sweep", plan, "--work-dir", "w"][..], more].concat();
        expect(folder.path(), 0, &all)
    };
    let rows = || fs::read_to_string(folder.path().join("w/rows.csv")).unwrap();
    sweep("a.toml", &[]);
    let first = rows();
    let text = sweep("a.toml", &["--missing"]);
    assert!(text.contains("note: w lacks no point of a.toml"), "{text}");
    assert!(sweep("b.toml", &["--missing"]).contains("\"number\":1"));
    assert!(!sweep("a.toml", &[]).contains("another plan"));
    let text = sweep("b.toml", &["--front", "psnr_db,fps"]);
    assert!(
        text.contains("note: w/rows.csv had 1 row of another plan"),
        "{text}"
    );
    assert!(text.contains("0 of 2 rows"), "{text}");
    assert!(
        text.contains("psnr_db is not known for 2 of 2 rows"),
        "{text}"
    );
    assert!(words(&text).contains("`quality = false`"), "{text}");
    sweep("a.toml", &[]);
    assert_eq!(rows(), first);
}
