//! What `potamoi effects` says.

use potamoi_analysis::{Analysis, Finding, Hardware, LeftOut};
use potamoi_base::effects::Effect;
use potamoi_scene::Scene;
use serde::Serialize;

use super::compare::{Forced, Without};
use super::measure::{Pairs, RtlWall, Wall};
use crate::stdout::say;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scene: String,
    pub(super) algorithm: &'static str,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) frames: usize,
    /// 12 hexadecimal digits.
    pub(super) configuration: String,
    pub(super) preset: Option<&'static str>,
    /// Of runs whose medians are wall times.
    pub(super) pairs: u32,
    pub(super) effects: Vec<Found>,
    pub(super) units: Vec<UnitReport>,
    pub(super) forced: Option<Forced>,
    pub(super) without: Vec<Without>,
    pub(super) rtl: Option<RtlWall>,
    pub(super) seconds: f64,
}

/// An effect.
#[derive(Serialize)]
pub(super) struct Found {
    name: &'static str,
    /// Of spherical harmonics.
    degree: Option<u8>,
    called_for: bool,
    evidence: String,
    cost: Cost,
    saving: Saving,
}

/// What an effect takes when it is simulated.
#[derive(Serialize)]
struct Cost {
    #[serde(flatten)]
    work: Work,
    /// Wall time of the simulator with it, less that without it, where both were run; nothing, 0, of
    /// what there is nothing of to simulate.
    wall_ms: Option<f64>,
    /// What was timed, and how long it took.
    wall: Option<Wall>,
}

/// What is saved by leaving an effect out that is not called for.
#[derive(Serialize)]
struct Saving {
    /// Of the simulator's wall time; nothing, 0, of one that is called for, since it is not left out;
    /// nor of one that there is nothing of to simulate. None where nothing was timed.
    wall_ms: Option<f64>,
    /// Of modelled cycles: none, since the hardware does no work that is not called for.
    cycles: u64,
}

/// Where work is done, and how much.
#[derive(Serialize)]
pub(super) struct Work {
    unit: &'static str,
    cycles: Option<u64>,
    amount: Option<u64>,
    amount_of: Option<&'static str>,
}

impl Work {
    pub(super) const fn cycles(unit: &'static str, cycles: u64) -> Self {
        Self {
            unit,
            cycles: Some(cycles),
            amount: None,
            amount_of: None,
        }
    }

    pub(super) const fn amount(unit: &'static str, amount: u64, of: &'static str) -> Self {
        Self {
            unit,
            cycles: None,
            amount: Some(amount),
            amount_of: Some(of),
        }
    }

    fn words(&self) -> String {
        match (self.cycles, self.amount, self.amount_of) {
            (Some(cycles), _, _) => format!("{}: {cycles} cycles (cycle model)", self.unit),
            (_, Some(amount), Some(of)) => format!("{}: {amount} {of}", self.unit),
            _ => self.unit.to_owned(),
        }
    }
}

impl Found {
    /// `is_there` says whether the simulator could do something of it.
    pub(super) fn new(
        finding: &Finding,
        work: Work,
        wall: Option<Wall>,
        is_there: bool,
        scene: &Scene,
    ) -> Self {
        let called_for = finding.is_called_for;
        // What is not called for is not in what was counted, but for what all models have.
        let work = match (called_for, finding.effect) {
            (true, _) | (false, Effect::Warping) => work,
            (false, Effect::ViewMlp) if scene.facts().perceptron.is_some() => work,
            (false, _) => Work {
                cycles: work.cycles.map(|_| 0),
                amount: work.amount.map(|_| 0),
                ..work
            },
        };
        let nothing = (!called_for && !is_there).then_some(0.0);
        let taken = wall.map(|wall| wall.pairs.difference_ms).or(nothing);
        Self {
            name: finding.effect.name(),
            degree: finding.effect.degree(),
            called_for,
            evidence: finding.evidence.clone(),
            cost: Cost {
                work,
                wall_ms: taken,
                wall,
            },
            saving: Saving {
                wall_ms: match called_for {
                    true => Some(0.0),
                    false => taken,
                },
                cycles: 0,
            },
        }
    }

    pub(super) const fn called_for(&self) -> bool {
        self.called_for
    }

    /// Medians of pairs, where it was timed.
    pub(super) fn timed(&self) -> Option<Pairs> {
        self.cost.wall.map(|wall| wall.pairs)
    }

    /// Where it takes how much, if it is called for.
    pub(super) fn cost_words(&self) -> String {
        match self.called_for {
            true => self.cost.work.words(),
            false => "not called for".to_owned(),
        }
    }

    pub(super) fn title(&self) -> String {
        match self.degree {
            Some(degree) => format!("{}:{degree}", self.name),
            None => self.name.to_owned(),
        }
    }

    fn print(&self) {
        let asked = if self.called_for {
            "called for    "
        } else {
            "not called for"
        };
        say!("  {:<22} {asked}  {}", self.title(), self.evidence);
        let pad = " ".repeat(41);
        let timed = self
            .cost
            .wall
            .as_ref()
            .map(|wall| format!("{} for {}", wall.pairs.words(), wall.of));
        match (self.called_for, timed) {
            (true, Some(timed)) => say!("{pad}costs {}; {timed}", self.cost.work.words()),
            (true, None) => say!("{pad}costs {}", self.cost.work.words()),
            (false, Some(timed)) => say!("{pad}saves {timed}"),
            (false, None) if self.saving.wall_ms == Some(0.0) => {
                say!("{pad}saves nothing: none of it would be simulated, forced or not");
            }
            (false, None) => {}
        }
    }
}

/// A unit, and what of it is instantiated.
#[derive(Serialize)]
pub(super) struct UnitReport {
    unit: &'static str,
    /// In RTL simulation, and in Verilog that is emitted for the scene.
    instantiated: bool,
    /// By the path's cameras.
    used_by_path: bool,
    left_out: Vec<LeftOut>,
}

impl UnitReport {
    pub(super) fn new(hardware: &Hardware, analysis: &Analysis) -> Vec<Self> {
        let splats = |prefix: &str| {
            let own = hardware.left_out.iter();
            own.filter(|part| part.field.starts_with(prefix))
                .cloned()
                .collect()
        };
        // Colours of Gaussians are made of a field's features, whether one is in view or not.
        let makes_colours = analysis.calls_for(Effect::Trilinear);
        let is_in_view = analysis.seen.in_view > 0;
        vec![
            Self {
                unit: "gathering_unit",
                instantiated: hardware.gathers,
                used_by_path: hardware.gathers && (is_in_view || makes_colours),
                left_out: splats("g"),
            },
            Self {
                unit: "vector_unit",
                instantiated: hardware.computes,
                used_by_path: analysis.calls_for(Effect::Exponential) || makes_colours,
                left_out: splats("v"),
            },
        ]
    }

    fn print(&self) {
        let is = match (self.instantiated, self.used_by_path) {
            (false, _) => "not instantiated",
            (true, false) => "not loaded: no camera of the path needs it",
            (true, true) => "instantiated",
        };
        say!("  {:<22} {is}", self.unit);
        for part in &self.left_out {
            say!(
                "    {}: {} instead of {}, since {}",
                part.field,
                part.left,
                part.asked,
                part.reason
            );
        }
    }
}

impl Report {
    pub(super) fn print(&self) {
        say!(
            "{} ({}) at {} x {}, {} frame{} of its path, configuration {}",
            self.scene,
            self.algorithm,
            self.width,
            self.height,
            self.frames,
            if self.frames == 1 { "" } else { "s" },
            self.configuration
        );
        self.effects.iter().for_each(Found::print);
        if self.pairs > 0 {
            say!(
                "  wall times are the simulator's, medians of {} interleaved pairs",
                self.pairs
            );
        }
        self.units.iter().for_each(UnitReport::print);
        if let Some(forced) = &self.forced {
            say!("  {}", forced.sentence());
        }
        for without in &self.without {
            say!("  {}", without.sentence());
        }
        if let Some(rtl) = &self.rtl {
            say!(
                "  Verilated, what the scene does not call for takes {}; without it {} picture, \
                 counts and cycles ({} gathering, {} vector)",
                rtl.wall
                    .map_or_else(|| "an unknown time".to_owned(), |wall| wall.words()),
                if rtl.is_same { "the same" } else { "ANOTHER" },
                rtl.cycles.gather,
                rtl.cycles.vector
            );
        }
    }
}
