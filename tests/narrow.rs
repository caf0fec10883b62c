//! Output of all commands with tables, within a hundred characters, and with all columns on request;
//! files for shells; names that are misspelt.

use crate::common::{expect, run, stderr};

const COMMANDS: [&[&str]; 11] = [
    &["characterise", "--scene", "lantern", "--width", "12"],
    &["layouts", "--scene", "lantern", "--width", "12"],
    &[
        "verify",
        "--scene",
        "lantern",
        "--width",
        "8",
        "--engine",
        "interpreter",
    ],
    &[
        "cost",
        "--scene",
        "garden",
        "--width",
        "12",
        "--knobs",
        "iterations",
    ],
    &["cost", "--study", "exp"],
    &[
        "model", "--scene", "lantern", "--width", "12", "--frames", "2",
    ],
    &[
        "compare", "paper", "small", "--scene", "lantern", "--width", "12", "--frames", "2",
    ],
    &["effects", "--scene", "lantern", "--width", "12"],
    &["estimate"],
    &["explain"],
    &["explain", "vu.exp.form"],
];

#[test]
fn lines_have_a_hundred_characters_at_most() {
    let folder = tempfile::tempdir().unwrap();
    for command in COMMANDS {
        let text = expect(folder.path(), 0, command);
        let wide: Vec<&str> = (text.lines())
            .filter(|line| line.chars().count() > 100)
            .collect();
        assert!(
            wide.is_empty(),
            "{}\n{}",
            command.join(" "),
            wide.join("\n")
        );
    }
}

#[test]
fn all_columns_are_printed_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let own = [
        "cost",
        "--scene",
        "garden",
        "--width",
        "12",
        "--knobs",
        "iterations",
    ];
    let text = expect(folder.path(), 0, &own);
    let answer = text.lines().next().unwrap();
    assert!(
        answer.ends_with("% of the frame's time") && answer.contains("iteration"),
        "{text}"
    );
    assert!(
        text.contains("SSIM, gathering cycles") && text.contains("(--wide)"),
        "{text}"
    );
    let text = expect(folder.path(), 0, &[&own[..], &["--wide"]].concat());
    assert!(!text.contains("left out"), "{text}");
    let is_head = |line: &&str| line.contains("gathering cycles") && line.contains("SSIM");
    assert!(text.lines().any(|line| is_head(&line)), "{text}");
}

#[test]
fn a_field_is_explained_and_a_machine_is_begun() {
    let folder = tempfile::tempdir().unwrap();
    let text = expect(folder.path(), 0, &["explain", "vu.exp.iterations"]);
    for part in [
        "meaning",
        "default",
        "16",
        "allowed",
        "presets",
        "small",
        "--knobs",
        "vector-unit.md",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // The last part of a path, and a knob.
    let text = expect(folder.path(), 0, &["explain", "window"]);
    assert!(
        text.contains("path.window") && text.contains("a knob of cost"),
        "{text}"
    );
    expect(folder.path(), 0, &["init", "mine"]);
    let own = ["estimate", "--config", "mine/machine.toml"];
    let paper = expect(folder.path(), 0, &["estimate", "--config", "paper"]);
    assert_eq!(expect(folder.path(), 0, &own), paper);
    let points = expect(
        folder.path(),
        0,
        &["sweep", "mine/plan.toml", "--work-dir", "s", "--missing"],
    );
    assert!(points.lines().count() >= 6, "{points}");
    let again = run(folder.path(), &["init", "mine"]);
    assert_eq!(again.status.code(), Some(2));
}

#[test]
fn misspelt_names_are_answered_with_the_nearest() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, name) in [
        ("render --scene lanten --out a.png", "lantern"),
        ("emit --config papr --out-dir rtl", "paper"),
        ("compare paper lean-splat --scene garden", "lean-splats"),
        ("effects --force sortin", "sorting"),
        ("cost --scene garden --knobs iteration", "iterations"),
        ("explain gu.bank", "gu.banks"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let done = run(folder.path(), &arguments);
        let said = stderr(&done);
        assert_eq!(done.status.code(), Some(2), "{said}");
        assert!(said.contains(&format!("did you mean `{name}`?")), "{said}");
    }
}

#[test]
fn pages_and_completions_are_written() {
    let folder = tempfile::tempdir().unwrap();
    expect(folder.path(), 0, &["man", "pages"]);
    let page = std::fs::read_to_string(folder.path().join("pages/potamoi-hard-cases.1")).unwrap();
    assert!(page.contains("picture"), "{page}");
    let text = expect(folder.path(), 0, &["completions", "bash"]);
    assert!(
        text.contains("hard-cases") && text.contains("--target-psnr"),
        "{text}"
    );
    assert_eq!(
        run(folder.path(), &["completions", "dos"]).status.code(),
        Some(2)
    );
}
