//! `potamoi compare --rivals`: the fair bench.

use std::path::Path;

use potamoi_base::outputs as files;
use potamoi_machines::fair_bench::{BenchScene, Checked, FrozenInputs, Input, RivalRow};
use potamoi_machines::{FairBench, Machine, Row};
use potamoi_rivals::{Estimate, Origin, Overlap, Rival, Verdict};
use schemars::JsonSchema;
use serde::Serialize;

use super::CompareArgs;
use super::table::{bound, shortened};
use crate::bounds::{number, tight};
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::scene::{left_open_of_files, say_not_checked};
use crate::stdout::{prose, say};
use crate::tables;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 1;
/// Machines unless some are named.
const MACHINES: [&str; 3] = ["paper", "lean-splats", "fields"];
/// Longest name of a GPU and its program in the table, in characters.
const LONGEST: usize = 32;
/// What the columns of the tables mean.
const LEGEND: [&str; 10] = [
    "frames/s: ours scheduled at the clock that synthesis reaches; rivals by their published",
    "  structure, from where nothing is skipped to where all is that may be; GPUs at both bounds",
    "mJ: of the accelerator, ours without GPU and memory, rivals' published power times time; GPUs",
    "  at their limit of power",
    "mm^2 at the node that is named: nothing is scaled from one to another",
    "<, >: at most, at least: a constant of one of its stages is not known, so that the stage has no",
    "  time",
    "validated: a figure of its own publication is computed within 2 times without an assumed count,",
    "  with its ratio, computed over published; no: the reason stands with the rival's constants",
    "-: not known, or not of that algorithm",
];

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: &'a FairBench,
    /// Items that scenes' files leave open.
    not_checked: Vec<String>,
}

/// Refuses a rival among the machines: those are all compared, and none is chosen.
fn refuse_rivals(machines: &[String]) -> Result<(), Failure> {
    let rivals = Rival::all().map_err(|error| Failure::Usage(error.to_string()))?;
    let names: Vec<&str> = rivals.iter().map(|own| own.name.as_str()).collect();
    let is_rival = |given: &&String| {
        let given = given.to_lowercase();
        // NeuRex, of which there are two sizes, is one name.
        !given.is_empty() && names.iter().any(|own| own.starts_with(&given))
    };
    match machines
        .iter()
        .filter(|own| !Path::new(own).exists())
        .find(is_rival)
    {
        Some(given) => Err(Failure::Usage(format!(
            "{given}: --rivals compares with all published accelerators ({}), and the names beside it are \
             machines, presets or files: leave {given} out",
            names.join(", ")
        ))),
        None => Ok(()),
    }
}

pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    refuse_rivals(&args.machines)?;
    let machines = match args.machines.is_empty() {
        false => args.machines()?,
        true => args.machines_named(&MACHINES.map(str::to_owned))?,
    };
    let frozen = FrozenInputs::read()?;
    let mut scenes = frozen.open()?;
    scenes.extend(
        args.scenes
            .open_given()?
            .into_iter()
            .map(|scene| BenchScene {
                scene,
                digest: None,
            }),
    );
    let bar = progress::bar(0, "comparing");
    let found = FairBench::of(&machines, &scenes, frozen.frames, &Shown(&bar))?;
    bar.finish_and_clear();
    print(&found, &machines);
    let not_checked = left_open_of_files();
    say_not_checked(&not_checked);
    if let Some(path) = &args.csv {
        files::write(path, &csv(&found, path)?)?;
    }
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "compare --rivals",
            found: &found,
            not_checked,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

fn csv(found: &FairBench, path: &Path) -> Result<String, Failure> {
    let text = found.csv();
    text.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

fn print(found: &FairBench, machines: &[Machine]) {
    for own in &found.rivals {
        notes(own);
    }
    say!("");
    for input in &found.inputs {
        self::input(found, input);
    }
    for line in LEGEND {
        say!("{line}");
    }
    if machines
        .iter()
        .any(|own| own.path.variant().name != "fs+gu")
    {
        say!(
            "machines that warp render fewer pixels than the trace has: rivals render full frames"
        );
    }
}

fn input(found: &FairBench, input: &Input) {
    let [width, height] = input.size;
    let kind = match (&input.frozen, input.is_as_frozen()) {
        (None, _) => "added".to_owned(),
        (Some(_), true) => format!("frozen, trace {}", short(&input.digest)),
        (Some(known), false) => format!(
            "NOT the frozen trace: {} instead of {}",
            short(&input.digest),
            short(known)
        ),
    };
    say!(
        "{} ({}), {width} x {height}, {kind}",
        input.scene,
        input.algorithm
    );
    let mut table = tables::narrow(["", "frames/s", "mJ", "mm^2", "nm", "bound by", "validated"]);
    for row in &input.machines {
        if let Row::Figures(own) = row {
            let name = match own.variant {
                "fs+gu" => shortened(&own.machine),
                variant => format!("{}: {variant}", shortened(&own.machine)),
            };
            table.add_row([
                name,
                tight(&own.frames_per_second),
                own.accelerator_mj
                    .map_or_else(dash, |own| millijoules([own.low(), own.high()])),
                own.mm2.map_or_else(dash, |own| format!("{own:.2}")),
                "12".to_owned(),
                bound(own),
                dash(),
            ]);
        }
    }
    for own in &input.gpus {
        let program = own.program.split(',').next().unwrap_or_default();
        table.add_row([
            cut(&format!("{}, {program}", own.device)),
            tight(&own.frames_per_second),
            tight(&own.mj),
            dash(),
            dash(),
            dash(),
            dash(),
        ]);
    }
    for row in &input.rivals {
        if let Some(checked) = found.rivals.iter().find(|own| own.rival.name == row.rival) {
            table.add_row(cells(checked, row));
        }
    }
    say!("{table}");
    reasons(found, input);
    say!("");
}

fn cells(checked: &Checked, row: &RivalRow) -> [String; 7] {
    let (rival, estimate) = (&checked.rival, row.estimate.as_ref());
    let known =
        |of: Option<f64>, digits: usize| of.map_or_else(dash, |own| format!("{own:.digits$}"));
    let validated = match &checked.verdict {
        Verdict::Validated(check) => format!("yes, {:.2}", check.ratio[0]),
        Verdict::Not(_) => "no".to_owned(),
    };
    [
        rival.title.clone(),
        estimate.map_or_else(dash, |own| {
            format!("{}{}", at_most(own, "<"), span(own.frame.rates()))
        }),
        estimate
            .and_then(|own| Some(format!("{}{}", at_most(own, ">"), millijoules(own.mj?))))
            .unwrap_or_else(dash),
        known(rival.area_mm2.value, 2),
        known(rival.node_nm.value, 0),
        estimate.map_or_else(dash, |own| own.bottleneck.clone()),
        validated,
    ]
}

/// A mark where a stage of the estimate has no time, since a constant of it is not known.
fn at_most(of: &Estimate, mark: &'static str) -> &'static str {
    match of.stages.iter().any(|(_, time)| time.is_none()) {
        true => mark,
        false => "",
    }
}

/// Why rows have no figures.
fn reasons(found: &FairBench, input: &Input) {
    for own in &input.machines {
        if let Row::Refused {
            machine, refused, ..
        } = own
        {
            prose!(2, "{machine}: - ({refused})");
        }
    }
    let mut refused: Vec<(&str, Vec<&str>)> = vec![];
    for own in &input.rivals {
        let checked = found.rivals.iter().find(|of| of.rival.name == own.rival);
        let (Some(checked), Some(why)) = (checked, own.refused.as_deref()) else {
            continue;
        };
        let title = checked.rival.title.as_str();
        match refused.iter_mut().find(|(same, _)| *same == why) {
            Some((_, titles)) => titles.push(title),
            None => refused.push((why, vec![title])),
        }
    }
    for (why, titles) in refused {
        let text = format!("{}: - ({why})", titles.join(", "));
        prose!(2, "{text}");
    }
}

/// What a rival's row rests on.
fn notes(own: &Checked) {
    let rival = &own.rival;
    let note = |text: String| prose!(2, "{text}");
    let heading = format!("{} ({})", rival.title, rival.publication);
    prose!(0, "{heading}");
    note(match &own.verdict {
        Verdict::Validated(check) => format!(
            "validated: {}: {} computed, {} published ({}): {}",
            check.what,
            span(check.computed),
            number(check.published),
            check.source,
            span(check.ratio)
        ),
        Verdict::Not(why) => format!("not validated: {why}"),
    });
    let rule = match rival.overlap {
        Overlap::Longest => "a frame takes its longest stage",
        Overlap::Sum => "a frame takes the sum of its stages",
    };
    note(format!("{rule} ({})", rival.overlap_origin.text()));
    for (place, constant) in rival.constants() {
        let value = constant.value.map_or_else(dash, |own| own.to_string());
        match &constant.origin {
            Origin::Source(_) => {}
            Origin::Assumed(why) => {
                note(format!(
                    "assumed: {place}: {value} {}: {why}",
                    constant.unit
                ));
            }
            Origin::Unknown(why) => note(format!("{place}: {value}: {why}")),
        }
    }
    note(format!("left out: {}", rival.left_out.join("; ")));
}

fn dash() -> String {
    "-".to_owned()
}

fn short(digest: &str) -> &str {
    digest.get(..8).unwrap_or(digest)
}

fn cut(name: &str) -> String {
    name.chars().take(LONGEST).collect()
}

/// As [`span`], with more digits where there is less than a tenth.
fn millijoules(of: [f64; 2]) -> String {
    let [low, high] = of.map(|own| match own < 0.1 {
        true => format!("{own:.4}"),
        false => number(own),
    });
    match low == high {
        true => low,
        false => format!("{low}-{high}"),
    }
}

/// From the lower to the higher; one figure where both read alike.
fn span(of: [f64; 2]) -> String {
    let [low, high] = of.map(number);
    match low == high {
        true => low,
        false => format!("{low}-{high}"),
    }
}
