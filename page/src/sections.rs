//! The nine sections.

use maud::{Markup, html};
use potamoi_plots::PlotError;

use super::Page;
use super::tables::table;
use super::value::{Form, Place};

/// A section: its anchor, its title and its contents.
type Section = (&'static str, &'static str, Markup);

/// A scene on a machine that renders it.
struct Pair<'a> {
    scene: Place<'a>,
    machine: Place<'a>,
    /// Begin of the names of its pictures and plots.
    id: String,
}

impl Page<'_> {
    pub(super) fn sections(&self) -> Result<Vec<Section>, PlotError> {
        Ok(vec![
            ("verdict", "Verdict", self.verdict()?),
            (
                "pictures",
                "Pictures",
                self.each(|own| Ok(self.shots(&own.scene, &own.machine, &own.id)))?,
            ),
            (
                "proof",
                "What was verified",
                self.each(|own| Ok(proof(&own.machine.get("more"))))?,
            ),
            (
                "time-energy",
                "Time and energy",
                self.each(|own| self.variants(own))?,
            ),
            (
                "accuracy",
                "Accuracy against time",
                self.each(|own| self.accuracy(own))?,
            ),
            (
                "effects",
                "Effects",
                self.each(|own| {
                    Ok(super::effects::effects(
                        &own.machine.get("more").get("effects"),
                    ))
                })?,
            ),
            (
                "hard-cases",
                "Hard cases",
                self.each(|own| {
                    Ok(super::hard_cases::hard_cases(
                        &own.machine.get("more").get("hard_cases"),
                    ))
                })?,
            ),
            (
                "paper",
                "The paper beside it",
                self.each(|own| Ok(paper(&own.machine.get("more"))))?,
            ),
            (
                "provenance",
                "Where the figures come from",
                self.provenance(),
            ),
        ])
    }

    fn pairs(&self) -> Vec<Pair<'_>> {
        let mut pairs = vec![];
        for (at, scene) in self.root.get("scenes").all().into_iter().enumerate() {
            for (number, machine) in scene.get("machines").all().into_iter().enumerate() {
                if !machine.get("more").is_null() {
                    pairs.push(Pair {
                        scene: scene.clone(),
                        machine,
                        id: format!("s{at}-m{number}"),
                    });
                }
            }
        }
        pairs
    }

    /// A part for each scene on each machine, with its heading.
    fn each(
        &self,
        of: impl Fn(&Pair<'_>) -> Result<Markup, PlotError>,
    ) -> Result<Markup, PlotError> {
        let pairs = self.pairs();
        let parts = pairs.iter().map(|own| Ok((heading(own), of(own)?)));
        let parts = parts.collect::<Result<Vec<_>, PlotError>>()?;
        Ok(html! { @for (heading, part) in &parts { h3 { (heading) } (part) } })
    }

    fn verdict(&self) -> Result<Markup, PlotError> {
        let pairs = self.pairs();
        let compared = self.plot(
            "compare",
            "Machines on the scenes: frames a second and millijoules a frame",
        )?;
        Ok(html! {
            @for own in &pairs { (line(own)) }
            @for scene in self.root.get("scenes").all() {
                @for own in scene.get("machines").all() {
                    @if let Some(why) = own.get("figures").json()["refused"].as_str() {
                        p { (own.get("machine").text()) " is left out: " (why) }
                    }
                }
            }
            (table("Machines on the scenes", &[
                "machine", "clock, GHz", "frames/s", "mJ a frame", "PSNR, dB", "units, mm²", "all, mm²", "frames/s if the units took no time", "GPU alone, frames/s",
            ], pairs.iter().map(row).collect()))
            p { "A range goes from where all demands of a GPU kernel overlap to where none do. Areas are before wires." }
            (compared)
            @for own in &pairs {
                @for unknown in own.machine.get("figures").get("unknown").all() {
                    p { "- of " (unknown.get("block").text()) ": " (unknown.get("why").text()) }
                }
            }
        })
    }

    fn variants(&self, own: &Pair<'_>) -> Result<Markup, PlotError> {
        let all = own.machine.get("more").get("variants").all();
        fn free<'a>(own: &Place<'a>) -> Place<'a> {
            own.get("if_gpu_were_free")
        }
        Ok(html! {
            p { "Each variant stands above the same with a GPU that takes no time and no energy: what is left is what a change of the units can gain." }
            (self.plot(&format!("{}-time", own.id), "Milliseconds of work a frame, by resource. Work overlaps, so that a bar may be longer than its frame, whose time the tick shows")?)
            (table("Time by variant", &[
                "variant", "frames/s", "ms a frame", "speed-up", "frames/s if the GPU were free", "ms a frame, GPU free",
            ], all.iter().map(|own| vec![
                html! { (own.get("name").text()) },
                own.get("frames_per_second").range(),
                own.get("frame_ms").range(),
                own.get("speed_up").range(),
                free(own).get("frames_per_second").range(),
                free(own).get("frame_ms").range(),
            ]).collect()))
            (self.plot(&format!("{}-energy", own.id), "Millijoules a frame, by part")?)
            (table("Energy by variant", &["variant", "mJ a frame", "saving", "mJ a frame if the GPU were free"],
                all.iter().map(|own| vec![
                    html! { (own.get("name").text()) },
                    own.get("mj").range(),
                    own.get("saving").range(),
                    free(own).get("mj").range(),
                ]).collect()))
            (parts("Milliseconds of work a frame, mean of both bounds", &all, "work_ms"))
            (parts("Millijoules a frame by part, mean of both bounds", &all, "parts_mj"))
        })
    }

    fn accuracy(&self, own: &Pair<'_>) -> Result<Markup, PlotError> {
        let found = own.machine.get("more").get("accuracy");
        if let Some(why) = found.unknown() {
            return Ok(html! { p { "-: " (why) } });
        }
        let points = found.get("points").all();
        let mut knobs: Vec<&str> = points
            .iter()
            .skip(1)
            .map(|own| own.get("knob").text())
            .collect();
        knobs.dedup();
        let plots = found.get("plots").all();
        let panels = plots.iter().map(|plot| {
            let name = plot.get("1").text();
            let beside = plot.get("0").text();
            let caption = match beside {
                "truth" => "dB beside the truth over microseconds a frame",
                _ => "dB beside the converged picture of the model over microseconds a frame",
            };
            Ok((beside, name, self.plot(name, caption)?))
        });
        let panels = panels.collect::<Result<Vec<_>, PlotError>>()?;
        let db = |own: &Place<'_>| match own.is_null() {
            true => html! { "-" },
            false if own.get("db").is_null() => html! { "equal" },
            false => own.get("db").number(Form::Hundredths),
        };
        Ok(html! {
            p { (super::FRONT_LINES) "." }
            p {
                "The frame is that of the pictures, rendered again and again, with one setting changed. The rates \
                 above are of a path of frames, whose cameras differ. Areas are of the units' cells, without \
                 memories. Where a setting changes a unit, formulas give the change of its area, clock and energy (~)."
            }
            @if panels.len() > 1 {
                fieldset class="filter" data-choice=(own.id) {
                    legend { "Beside" }
                    @for (at, (beside, ..)) in panels.iter().enumerate() {
                        label { input type="radio" name=(format!("{}-beside", own.id)) value=(beside) checked[at == 0]; " " (beside) }
                    }
                }
            }
            @for (beside, name, plot) in &panels {
                div data-panel-of=(own.id) data-panel=(beside) {
                    p class="filter" {
                        label for=(format!("{name}-filter")) { "Knob" }
                        select id=(format!("{name}-filter")) data-filter=(name) {
                            option value="all" { "all" }
                            @for knob in &knobs { option value=(knob) { (knob) } }
                        }
                    }
                    (plot)
                }
            }
            details {
                summary { "All settings as a table" }
                (table("Settings of knobs, one at a time", &[
                    "setting", "dB beside truth", "dB beside converged", "µs a frame", "mJ", "cells, mm²",
                ], points.iter().zip(found.get("frame_us").all()).map(|(own, us)| vec![
                    html! { (own.get("knob").text()) " " (own.get("setting").text()) },
                    db(&own.get("truth")),
                    db(&own.get("converged")),
                    us.number(Form::Short),
                    own.get("energy_mj").number(Form::Short),
                    html! {
                        @if own.get("is_estimated").is_true() && !own.get("area_mm2").is_null() { "~" }
                        (own.get("area_mm2").number(Form::Small))
                    },
                ]).collect()))
                @for own in found.get("refused").all() {
                    p { (own.get("knob").text()) " " (own.get("setting").text()) " is left out: " (own.get("why").text()) }
                }
            }
        })
    }

    fn provenance(&self) -> Markup {
        let pairs = self.pairs();
        let open = self.root.get("not_checked").all();
        html! {
            (table("Origin of the figures", &["figure", "origin", "how", "command"],
                self.root.get("provenance").all().iter().map(|own| vec![
                    html! { (own.get("figure").text()) },
                    html! { (own.get("origin").text()) },
                    html! { (own.get("how").text()) },
                    html! { @if own.get("command").is_null() { "-" } @else { code { (own.get("command").text()) } } },
                ]).collect()))
            (table("What was run", &["scene and machine", "hash of the scene", "preset", "hash of the configuration"],
                pairs.iter().map(|own| vec![
                    html! { (heading(own)) },
                    html! { code { (own.scene.get("hash").text()) } },
                    html! { (own.machine.get("more").get("preset").text()) },
                    html! { code { (own.machine.get("more").get("configuration").text()) } },
                ]).collect()))
            @for own in &pairs { (blocks(own)) }
            @if !open.is_empty() {
                p { "What the scenes' files leave open:" }
                ul class="open" { @for own in &open { li { (own.text()) } } }
            }
        }
    }
}

fn heading(own: &Pair<'_>) -> String {
    let preset = own.machine.get("more").get("preset");
    let machine = match own.machine.get("machine").text() {
        // Nothing was named: the preset that the scene's model needs.
        "default" if !preset.is_null() => preset.text(),
        named => named,
    };
    format!("{} on {machine}", own.scene.get("name").text())
}

/// One sentence on a scene on a machine.
fn line(own: &Pair<'_>) -> Markup {
    let figures = own.machine.get("figures");
    let more = own.machine.get("more");
    let size = own.scene.get("size");
    let quality = figures.get("quality");
    let beside = match quality.get("beside").text() {
        "truth" => "the truth",
        _ => "the converged picture",
    };
    let bound = ["max", "sum"].map(|bound| figures.get("bottleneck").get(bound));
    let names = bound.clone().map(|own| own.get("0").text());
    let share = |own: &Place<'_>| {
        let share = own.get("1");
        html! { @if !share.is_null() { " (" (share.number(Form::Percent)) " of the time)" } }
    };
    let proof = more.get("proof");
    html! {
        p class="verdict" {
            (heading(own)) ", " (size.get("0").number(Form::Count)) " × " (size.get("1").number(Form::Count)) ": "
            b { (figures.get("frames_per_second").range()) " frames/s" }
            " by the variant " (figures.get("variant").text())
            " at " (figures.get("clock_ghz").number(Form::Hundredths)) " GHz (" (figures.get("clock_origin").text()) "), "
            b { (figures.get("mj").range()) " mJ a frame" } ", "
            b {
                @if quality.get("db").is_null() { "equal to" }
                @else { (quality.get("db").number(Form::Hundredths)) " dB beside" }
                " " (beside)
            } ", "
            b { (figures.get("units_mm2").number(Form::Small)) " mm² of units with memories" } ", bound by the "
            (names[0]) (share(&bound[0]))
            @if names[0] != names[1] { " or the " (names[1]) (share(&bound[1])) }
            ". "
            @if let Some(why) = proof.unknown() { "Not verified: " (why) }
            @else {
                "Verified in every bit and cycle, without a mismatch: "
                @for (at, unit) in proof.get("units").all().iter().filter(|own| !own.get("share").is_null()).enumerate() {
                    @if at > 0 { ", " }
                    (unit.get("share").number(Form::Percent)) " of the " (unit.get("unit").text()) "'s work"
                }
                "."
            }
        }
    }
}

fn row(own: &Pair<'_>) -> Vec<Markup> {
    let figures = own.machine.get("figures");
    vec![
        html! { (heading(own)) ": " (figures.get("variant").text()) },
        html! { (figures.get("clock_ghz").number(Form::Hundredths)) " " (figures.get("clock_origin").text()) },
        figures.get("frames_per_second").range(),
        figures.get("mj").range(),
        figures.get("quality").get("db").number(Form::Hundredths),
        figures.get("units_mm2").number(Form::Small),
        figures.get("mm2").number(Form::Hundredths),
        figures.get("free_units_frames_per_second").range(),
        figures.get("gpu_alone_frames_per_second").range(),
    ]
}

fn proof(more: &Place<'_>) -> Markup {
    let own = more.get("proof");
    if let Some(why) = own.unknown() {
        return html! { p { "-: " (why) } };
    }
    html! {
        div class="cards" {
            @for unit in own.get("units").all() {
                div class="card" {
                    h4 { (unit.get("unit").text()) }
                    @if unit.get("share").is_null() {
                        p { "-: the frame has no work for it" }
                    } @else {
                        p {
                            (unit.get("share").number(Form::Percent)) ": " (unit.get("compared").number(Form::Count)) " of "
                            (unit.get("all").number(Form::Count)) " " (unit.get("of").text())
                        }
                        meter min="0" max="1" value=(unit.get("share").json().to_string()) aria-label=(format!("compared of the {}", unit.get("unit").text())) {}
                    }
                }
            }
            div class="card" {
                h4 { "Not compared" }
                ul class="open" { @for own in own.get("not_checked").all() { li { (own.text()) } } }
            }
        }
        p { "The Verilog ran under Verilator, with and without random stalls, beside the golden models (every bit) and the cycle models (every cycle)." }
    }
}

/// Parts of time or energy, a row a part.
fn parts(caption: &str, variants: &[Place<'_>], key: &str) -> Markup {
    let mut header = vec!["part"];
    header.extend(variants.iter().map(|own| own.get("name").text()));
    let mut names: Vec<&str> = vec![];
    for own in variants.iter().flat_map(|own| own.get(key).all()) {
        let name = own.get("0").text();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let rows = names.iter().map(|name| {
        let cell = |own: &Place<'_>| {
            let all = own.get(key).all();
            let found = all.iter().find(|own| own.get("0").text() == *name);
            found.map_or_else(|| html! { "-" }, |own| own.get("1").number(Form::Small))
        };
        let first = vec![html! { (name) }];
        first.into_iter().chain(variants.iter().map(cell)).collect()
    });
    html! { details { summary { (caption) } (table(caption, &header, rows.collect())) } }
}

fn paper(more: &Place<'_>) -> Markup {
    html! {
        (table("The paper's figures, and this scene's", &["figure", "the paper", "here", "unit", "why they differ"],
            more.get("paper").all().iter().map(|own| {
                let ours = own.get("ours");
                vec![
                    html! { (own.get("figure").text()) },
                    html! { (own.get("paper").text()) },
                    match ours.unknown() { Some(why) => html! { "-: " (why) }, None => ours.range() },
                    html! { (own.get("unit").text()) },
                    html! { (own.get("reason").text()) },
                ]
            }).collect()))
        p { "The paper is arXiv " (more.get("arxiv").text()) ". docs/explanation/beside-the-paper.md has all of its figures, with the change that closes each difference." }
    }
}

/// Areas and periods of a machine's blocks, each with its origin.
fn blocks(own: &Pair<'_>) -> Markup {
    let more = own.machine.get("more");
    html! {
        details {
            summary { "Blocks of " (own.machine.get("machine").text()) " for " (own.scene.get("name").text()) }
            (table("Areas before wires", &["block", "number", "logic, mm²", "memories, mm²", "origin"],
                more.get("area").get("blocks").all().iter().map(|own| vec![
                    html! { (own.get("block").text()) },
                    own.get("count").number(Form::Count),
                    own.get("logic_mm2").number(Form::Small),
                    own.get("memories_mm2").number(Form::Small),
                    html! { (own.get("from").text()) },
                ]).collect()))
            (table("Periods, the slowest first", &["block", "picoseconds", "origin"],
                more.get("clock").get("blocks").all().iter().map(|own| vec![
                    html! { (own.get("block").text()) },
                    own.get("ps").number(Form::Count),
                    html! { (own.get("from").text()) },
                ]).collect()))
        }
    }
}
