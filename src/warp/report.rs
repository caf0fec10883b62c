//! What was found, as a table and as JSON.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use potamoi_golden::camera::Camera;
use potamoi_golden::warp::{Counts, Plan, PlanOptions, ReferenceFrom};
use serde::Serialize;

use super::measure::{FrameFound, Likeness, Measured, Part};
use super::timing::Timing;
use super::ways::{Method, Way};
use crate::say::say;
use crate::scene::say_not_checked;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 2;

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    #[serde(flatten)]
    pub(super) found: Found,
}

#[derive(Serialize)]
pub(super) struct Reports {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scenes: Vec<Found>,
}

/// What was found of one scene.
#[derive(Serialize)]
pub(super) struct Found {
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) frames: usize,
    /// Of a built-in way.
    pub(super) fps: Option<f64>,
    /// The model in full against ground truth.
    pub(super) model: Option<Likeness>,
    pub(super) variants: Vec<Variant>,
    /// What a model's file leaves open.
    pub(super) not_checked: Vec<String>,
    pub(super) seconds: f64,
}

/// One way of making the frames.
#[derive(Serialize)]
pub(super) struct Variant {
    name: String,
    method: &'static str,
    window: u32,
    phi_degrees: Option<f64>,
    /// Where depth is from.
    depth: String,
    references: usize,
    /// Frames that were to be warped and were rendered in full.
    fallbacks: usize,
    /// Pixels that the model renders, references included, of those of all
    /// frames in full.
    rendered_share: f64,
    frame: Part,
    foreground: Part,
    prediction: Option<Prediction>,
    /// Of the runtime, where it was scheduled or measured.
    timing: Option<Timing>,
    frames: Vec<FrameFound>,
    seconds: f64,
}

/// How far predicted references are from where the camera was.
#[derive(Serialize)]
struct Prediction {
    references: usize,
    mean_radians: f64,
    largest_radians: f64,
    /// In the scene's units.
    mean_distance: f64,
}

impl Variant {
    pub(super) fn new(
        way: &Way,
        depth: String,
        measured: Measured<'_>,
        plan: &Plan,
        path: &[Camera],
        seconds: f64,
        timing: Option<Timing>,
    ) -> Self {
        let [frame, foreground] = measured.totals();
        let pixels = frame.pixels.total() as f64;
        // References off the path are rendered beside the frames.
        let beside = plan.references.iter().filter(|r| r.target.is_none());
        let (references, extra) = match way.method {
            Method::Sparw => (plan.references.len(), beside.count()),
            Method::Temp => (path.len().div_ceil(way.window as usize), 0),
            Method::Ds2 => (0, 0),
        };
        let extra = extra as f64 * pixels / path.len().max(1) as f64;
        let rendered_share = match way.method {
            Method::Ds2 => 0.25,
            _ => (frame.pixels.rendered() as f64 + extra) / pixels,
        };
        Self {
            name: way.name.clone(),
            method: way.method.name(),
            window: way.window,
            phi_degrees: way.phi,
            depth,
            references,
            fallbacks: measured.frames.iter().filter(|f| f.fell_back).count(),
            rendered_share,
            frame,
            foreground,
            prediction: (way.method == Method::Sparw)
                .then(|| Prediction::of(&prediction_errors(plan, path)))
                .flatten(),
            timing,
            frames: measured.frames,
            seconds,
        }
    }

    /// By how much the model's own PSNR to ground truth falls, in dB, means of
    /// frames.
    fn loss(&self, model: Option<&Likeness>) -> Option<f64> {
        let psnr = |l: Option<&Likeness>| l?.mean_psnr_db;
        Some(psnr(model)? - psnr(self.frame.truth.as_ref())?)
    }

    /// The paper's loss in dB, of trained models.
    fn papers_loss(&self) -> Option<f64> {
        match (self.method, self.window, self.phi_degrees) {
            ("SpaRW", 6, None) => Some(1.0),
            ("SpaRW", 16, None) => Some(1.4),
            _ => None,
        }
    }
}

/// Of references that are taken on the path, how far off they would be if they
/// were predicted.
fn prediction_errors(plan: &Plan, path: &[Camera]) -> Vec<(f64, f64)> {
    if plan.references.iter().any(|r| r.predicted_for.is_some()) {
        return plan.prediction_errors(path);
    }
    let first = |reference| {
        plan.targets
            .iter()
            .filter(|t| t.reference == reference)
            .count()
    };
    let options = PlanOptions {
        window: (0..plan.references.len()).map(first).max().unwrap_or(1) as u32,
        reference: ReferenceFrom::Predicted,
        lead: None,
    };
    let other = Plan::new(path, &options);
    other.map_or_else(|_| vec![], |other| other.prediction_errors(path))
}

impl Prediction {
    fn of(errors: &[(f64, f64)]) -> Option<Self> {
        let count = errors.len() as f64;
        (count > 0.0).then(|| Self {
            references: errors.len(),
            mean_radians: errors.iter().map(|e| e.0).sum::<f64>() / count,
            largest_radians: errors.iter().map(|e| e.0).fold(0.0, f64::max),
            mean_distance: errors.iter().map(|e| e.1).sum::<f64>() / count,
        })
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

fn percent(part: u64, all: u64) -> String {
    if all == 0 {
        return "-".to_owned();
    }
    format!("{:.1}", 100.0 * part as f64 / all as f64)
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(header);
    table
}

fn print(table: &mut Table) {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{table}");
}

/// Shares of a part in percent: warped, hidden, by angle, at edges, void.
fn shares(counts: &Counts) -> [String; 5] {
    let all = counts.total();
    [
        percent(counts.warped, all),
        percent(counts.disoccluded, all),
        percent(counts.angle, all),
        percent(counts.edge, all),
        percent(counts.void, all),
    ]
}

impl Found {
    pub(super) fn print(&self, trace: Option<&PathBuf>) {
        let mut depths: Vec<&str> = vec![];
        for variant in &self.variants {
            if !depths.contains(&variant.depth.as_str()) {
                depths.push(&variant.depth);
            }
        }
        let pace = self.fps.map(|fps| format!(" at {fps} frames a second"));
        say!(
            "{}: {} frames of {} x {}{}, depth from {}",
            self.scene,
            self.frames,
            self.width,
            self.height,
            pace.unwrap_or_default(),
            depths.join(", ")
        );
        if let Some(model) = &self.model {
            say!(
                "  the model in full against ground truth: {} dB (mean of frames), SSIM {}",
                number(model.mean_psnr_db, 2),
                number(model.ssim, 4)
            );
        }
        if let [variant] = &self.variants[..] {
            Self::print_frames(variant);
        }
        self.print_totals();
        for variant in &self.variants {
            if let Some(prediction) = &variant.prediction {
                say!(
                    "  {}: {} references as predicted, off by {:.4} rad on average, {:.4} at most, \
                     {:.4} of the scene's units (the paper: below 0.01 rad)",
                    variant.name,
                    prediction.references,
                    prediction.mean_radians,
                    prediction.largest_radians,
                    prediction.mean_distance
                );
            }
            if let Some(timing) = &variant.timing {
                timing.print(&variant.name, trace);
            }
        }
        say_not_checked(&self.not_checked);
    }

    fn print_frames(variant: &Variant) {
        let mut all = table(&[
            "frame",
            "from",
            "warped %",
            "hidden %",
            "angle %",
            "edge %",
            "void %",
            "of the foreground: warped %",
            "hidden %",
            "angle %",
            "edge %",
            "void %",
            "PSNR to model",
            "SSIM",
            "of the foreground: PSNR",
            "SSIM",
            "PSNR to truth",
            "SSIM",
            "of the foreground: PSNR",
            "SSIM",
        ]);
        for frame in &variant.frames {
            let from = match (frame.reference, frame.fell_back) {
                (Some(_), true) => "full (fallback)".to_owned(),
                (Some(reference), false) => format!("R{reference}"),
                (None, _) => "full".to_owned(),
            };
            let Part { model, truth, .. } = &frame.frame;
            let fore = &frame.foreground;
            let psnr = |l: &Option<Likeness>, digits| number(l.and_then(|l| l.psnr_db), digits);
            let ssim = |l: &Option<Likeness>| number(l.and_then(|l| l.ssim), 4);
            let mut row = vec![frame.number.to_string(), from];
            row.extend(shares(&frame.frame.pixels));
            row.extend(shares(&fore.pixels));
            for likeness in [model, &fore.model, truth, &fore.truth] {
                row.extend([psnr(likeness, 2), ssim(likeness)]);
            }
            all.add_row(row);
        }
        print(&mut all);
    }

    fn print_totals(&self) {
        let mut quality = table(&[
            "",
            "PSNR to truth, dB",
            "loss, dB",
            "the paper's",
            "SSIM",
            "of the foreground: PSNR",
            "SSIM",
            "PSNR to model, dB",
            "SSIM",
            "of the foreground: PSNR",
            "SSIM",
        ]);
        let mut pixels = table(&[
            "",
            "warped %",
            "hidden %",
            "angle %",
            "edge %",
            "void %",
            "of the foreground: warped %",
            "hidden %",
            "angle %",
            "edge %",
            "void %",
            "fallbacks",
            "rendered in all %",
        ]);
        for variant in &self.variants {
            let [frame, fore] = [&variant.frame, &variant.foreground];
            let mean = |l: Option<Likeness>| number(l.and_then(|l| l.mean_psnr_db), 2);
            let psnr = |l: Option<Likeness>| number(l.and_then(|l| l.psnr_db), 2);
            let ssim = |l: Option<Likeness>| number(l.and_then(|l| l.ssim), 4);
            quality.add_row([
                variant.name.clone(),
                mean(frame.truth),
                number(variant.loss(self.model.as_ref()), 2),
                variant
                    .papers_loss()
                    .map_or_else(String::new, |l| format!("{l:.1}")),
                ssim(frame.truth),
                mean(fore.truth),
                ssim(fore.truth),
                psnr(frame.model),
                ssim(frame.model),
                psnr(fore.model),
                ssim(fore.model),
            ]);
            let mut row = vec![variant.name.clone()];
            row.extend(shares(&frame.pixels));
            row.extend(shares(&fore.pixels));
            row.push(variant.fallbacks.to_string());
            row.push(format!("{:.1}", 100.0 * variant.rendered_share));
            pixels.add_row(row);
        }
        print(&mut quality);
        print(&mut pixels);
        say!(
            "  loss: by how much the model's own PSNR to ground truth falls; PSNR to truth: means of \
             frames, to model: of all pixels; the paper's loss is of trained models\n  \
             rendered in all: pixels that the model renders, references included, of those of all \
             frames in full"
        );
    }
}

/// What a table of several scenes shows of each.
type Value = fn(&Found, &Variant) -> Option<f64>;

impl Reports {
    /// A row a scene, a column a way.
    pub(super) fn print(&self) {
        let Some(first) = self.scenes.first() else {
            return;
        };
        let kinds: [(&str, Value); 3] = [
            ("loss, dB", |f, v| v.loss(f.model.as_ref())),
            ("PSNR to model, dB", |_, v| v.frame.model?.psnr_db),
            ("rendered, %", |_, v| Some(100.0 * v.rendered_share)),
        ];
        let names: Vec<&str> = first.variants.iter().map(|v| v.name.as_str()).collect();
        for (what, value) in kinds {
            let mut header = vec![what, "model to truth, dB"];
            header.extend(&names);
            let mut all = table(&header);
            let mut sums = vec![(0.0, 0u32); names.len() + 1];
            for found in &self.scenes {
                let model = found.model.and_then(|m| m.mean_psnr_db);
                let own = found.variants.iter().map(|v| value(found, v));
                let row: Vec<Option<f64>> = std::iter::once(model).chain(own).collect();
                for (sum, v) in sums.iter_mut().zip(&row) {
                    if let Some(v) = v {
                        *sum = (sum.0 + v, sum.1 + 1);
                    }
                }
                all.add_row(cells(found.scene.clone(), &row));
            }
            let means: Vec<Option<f64>> = sums
                .iter()
                .map(|(sum, count)| (*count > 0).then(|| sum / f64::from(*count)))
                .collect();
            all.add_row(cells("mean".to_owned(), &means));
            if what == "loss, dB" {
                let papers = first.variants.iter().map(Variant::papers_loss);
                let row: Vec<Option<f64>> = std::iter::once(None).chain(papers).collect();
                all.add_row(cells("the paper, trained models".to_owned(), &row));
            }
            print(&mut all);
        }
        for found in self.scenes.iter().filter(|f| !f.not_checked.is_empty()) {
            say!("{}:", found.scene);
            say_not_checked(&found.not_checked);
        }
    }
}

fn cells(name: String, values: &[Option<f64>]) -> Vec<String> {
    let values = values.iter().map(|v| number(*v, 2));
    std::iter::once(name).chain(values).collect()
}
