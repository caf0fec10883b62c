//! Report of `potamoi hard-cases`.

use std::time::Duration;

use potamoi_analysis::hard_cases::pictures::{self, Shown};
use potamoi_analysis::hard_cases::{CheckState, Found, HardCase, Measured, SceneCases, SceneCheck};
use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::scene::say_not_checked;
use crate::stdout::say;
use crate::tables;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 1;

/// The pictures of the hard scenes, or why there are none.
pub(super) struct Pictures {
    pub(super) shown: Vec<Shown>,
    pub(super) none: Option<String>,
}

impl Pictures {
    /// Renders them; a configuration without what splats need has none.
    pub(super) fn of(config: &Config) -> Self {
        match pictures::shown(config) {
            Ok(shown) => Self { shown, none: None },
            Err(reason) => Self {
                shown: vec![],
                none: Some(reason.to_string()),
            },
        }
    }
}

#[derive(Serialize, JsonSchema)]
struct OfScene<'a> {
    name: &'a str,
    width: u32,
    height: u32,
    checks: &'a [SceneCheck],
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    /// Hash of the configuration.
    configuration: String,
    /// How it is named in print.
    #[serde(skip)]
    named: &'a str,
    preset: Option<&'static str>,
    /// Names of what fails.
    failed: Vec<String>,
    cases: &'a [HardCase],
    /// Checks of the pictures of hard scenes.
    pictures: Vec<&'a SceneCheck>,
    /// Why there are no such pictures.
    no_pictures: Option<&'a str>,
    scene: Option<OfScene<'a>>,
    seconds: f64,
    /// Items that the scene's files leave open.
    not_checked: Vec<String>,
}

/// Two digits and the magnitude.
fn number(value: Option<f64>) -> String {
    match value {
        None => "no number".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(v) if v < 1e7 && (v >= 100.0 || v.fract() == 0.0) => format!("{v:.0}"),
        Some(v) if (0.01..100.0).contains(&v) => format!("{v:.2}"),
        Some(v) => format!("{v:.1e}"),
    }
}

const fn word(state: CheckState) -> &'static str {
    match state {
        CheckState::Passes => "pass",
        CheckState::Fails => "FAIL",
        CheckState::DoesNotApply => "-",
    }
}

/// A case in words: its state, and the lines below its name.
fn words(found: &Found) -> (&'static str, Vec<String>) {
    match found {
        Found::Measured(own) => {
            let state = if own.passes { "pass" } else { "FAIL" };
            let easy = match own.is_hard {
                true => "",
                false => ", within the bound: not hard with this configuration",
            };
            let lines = vec![
                format!(
                    "ours {}, at most {} {} ({})",
                    number(own.error),
                    number(Some(own.bound)),
                    own.unit,
                    own.derivation
                ),
                format!("obvious {} ({}){easy}", number(own.naive_error), own.naive),
            ];
            (state, lines)
        }
        Found::DoesNotApply { reason } => ("-", vec![format!("does not apply: {reason}")]),
        Found::NotComputed { reason } => ("FAIL", vec![format!("cannot be computed: {reason}")]),
    }
}

/// Prints a case: its state and its name, and the lines below.
fn say_case(state: &str, name: &str, lines: &[String]) {
    say!(
        "{}",
        tables::broken_at_words(name, &format!("  {state:<6}"), "        ")
    );
    for line in lines {
        say!(
            "{}",
            tables::broken_at_words(line, "          ", "            ")
        );
    }
}

fn check_lines(check: &SceneCheck) -> Vec<String> {
    let naive = check.naive.iter().map(|own| format!("obvious: {own}"));
    std::iter::once(check.evidence.clone())
        .chain(naive)
        .collect()
}

impl<'a> Report<'a> {
    pub(super) fn new(
        (config, preset, named): (&Config, Option<&'static str>, &'a str),
        cases: &'a [HardCase],
        pictures: &'a Pictures,
        scene: Option<(&'a Scene, &'a SceneCases)>,
        failed: Vec<String>,
        took: Duration,
    ) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            command: "hard-cases",
            configuration: config.hash(),
            named,
            preset,
            failed,
            cases,
            pictures: pictures.shown.iter().map(|own| &own.check).collect(),
            no_pictures: pictures.none.as_deref(),
            scene: scene.map(|(scene, found)| OfScene {
                name: scene.name(),
                width: scene.camera().width,
                height: scene.camera().height,
                checks: &found.checks,
            }),
            seconds: took.as_secs_f64(),
            not_checked: scene.map_or_else(Vec::new, |(scene, _)| scene.left_open()),
        }
    }

    /// The direct answer: how many apply, and what fails.
    fn verdict(&self) -> String {
        let checks = || {
            let own = self.scene.iter().flat_map(|own| own.checks);
            self.pictures.iter().copied().chain(own)
        };
        let all = self.cases.len() + checks().count();
        let is_out = |own: &&HardCase| matches!(own.found, Found::DoesNotApply { .. });
        let out = self.cases.iter().filter(is_out).count();
        let out = out
            + checks()
                .filter(|own| own.state == CheckState::DoesNotApply)
                .count();
        let (name, applied) = (self.named, all - out);
        let rest = match out {
            0 => String::new(),
            out => format!("; {out} do not apply"),
        };
        match self.failed.len() {
            0 => {
                format!("pass: all {applied} cases that apply hold with configuration {name}{rest}")
            }
            failed => format!("FAIL: {failed} of {applied} cases with configuration {name}{rest}"),
        }
    }

    pub(super) fn print(&self) {
        say!("{}", self.verdict());
        let mut parts: Vec<&str> = self.cases.iter().map(|own| own.part).collect();
        parts.dedup();
        for part in parts {
            say!("\n{part}");
            for own in self.cases.iter().filter(|own| own.part == part) {
                let (state, lines) = words(&own.found);
                say_case(state, own.name, &lines);
            }
        }
        say!("\npictures of hard scenes, 33 x 25");
        for own in &self.pictures {
            say_case(word(own.state), own.name, &check_lines(own));
        }
        if let Some(reason) = self.no_pictures {
            say_case("-", "none", &[format!("does not apply: {reason}")]);
        }
        let Some(scene) = &self.scene else {
            say!("\nno scene: --scene SCENE also checks a file of yours");
            return;
        };
        say!("\nscene {}, {} x {}", scene.name, scene.width, scene.height);
        for own in scene.checks {
            say_case(word(own.state), own.name, &check_lines(own));
        }
        say_not_checked(&self.not_checked);
    }

    /// One line a case: empty fields where one is not known.
    pub(super) fn csv(&self) -> Result<String, Failure> {
        let mut rows = csv::Writer::from_writer(vec![]);
        let head = [
            "part",
            "case",
            "state",
            "error",
            "bound",
            "unit",
            "derivation",
            "obvious_form",
            "obvious_error",
            "evidence",
        ];
        let mut lines = vec![head.map(str::to_owned)];
        for own in self.cases {
            lines.push(case_fields(own));
        }
        let pictures = self.pictures.iter().map(|own| ("pictures", *own));
        let scene = self.scene.iter().flat_map(|own| own.checks);
        for (part, own) in pictures.chain(scene.map(|own| ("scene", own))) {
            let none = String::new;
            lines.push([
                part.to_owned(),
                own.name.to_owned(),
                word(own.state).to_lowercase(),
                none(),
                none(),
                none(),
                none(),
                own.naive.clone().unwrap_or_default(),
                none(),
                own.evidence.clone(),
            ]);
        }
        let written = lines.iter().try_for_each(|line| rows.write_record(line));
        let fail = |error: String| Failure::Output(format!("CSV: {error}"));
        written.map_err(|error| fail(error.to_string()))?;
        let bytes = rows.into_inner().map_err(|error| fail(error.to_string()))?;
        String::from_utf8(bytes).map_err(|error| fail(error.to_string()))
    }
}

fn case_fields(own: &HardCase) -> [String; 10] {
    let field = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let (state, evidence, found) = match &own.found {
        Found::Measured(found) if found.passes => ("pass", "", Some(found)),
        Found::Measured(found) => ("fail", "", Some(found)),
        Found::DoesNotApply { reason } => ("-", &**reason, None),
        Found::NotComputed { reason } => ("fail", &**reason, None),
    };
    let text = |of: fn(&Measured) -> &str| found.map_or("", of).to_owned();
    [
        own.part.to_owned(),
        own.name.to_owned(),
        state.to_owned(),
        field(found.and_then(|own| own.error)),
        field(found.map(|own| own.bound)),
        text(|own| &own.unit),
        text(|own| &own.derivation),
        text(|own| &own.naive),
        field(found.and_then(|own| own.naive_error)),
        evidence.to_owned(),
    ]
}
