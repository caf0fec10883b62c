//! What was found, as a table and as JSON.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use potamoi_golden::camera::Camera;
use potamoi_golden::warp::{Counts, Plan};
use serde::Serialize;

use super::measure::{FrameFound, Likeness, Measured, Part};
use super::timing::Timing;
use super::{Method, Way};
use crate::say::say;

#[derive(Serialize)]
pub(super) struct Report<'a> {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scene: &'a str,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) frames: usize,
    /// Of a built-in way.
    pub(super) fps: Option<f64>,
    pub(super) depth: &'static str,
    /// The model in full against ground truth.
    pub(super) model: Option<Likeness>,
    pub(super) variants: Vec<Variant>,
    pub(super) seconds: f64,
}

/// One way of making the frames.
#[derive(Serialize)]
pub(super) struct Variant {
    method: &'static str,
    window: u32,
    phi_degrees: Option<f64>,
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
            method: way.method.name(),
            window: way.window,
            phi_degrees: way.phi,
            references,
            fallbacks: measured.frames.iter().filter(|f| f.fell_back).count(),
            rendered_share,
            frame,
            foreground,
            prediction: (way.method == Method::Sparw)
                .then(|| Prediction::of(&plan.prediction_errors(path)))
                .flatten(),
            timing,
            frames: measured.frames,
            seconds,
        }
    }

    fn name(&self) -> String {
        let phi = self.phi_degrees.map(|phi| format!(", phi {phi}"));
        let window = match self.method {
            "DS-2" => String::new(),
            _ => format!("-{}", self.window),
        };
        format!("{}{window}{}", self.method, phi.unwrap_or_default())
    }
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

/// Shares of a part in percent: warped, hidden, by angle, void.
fn shares(counts: &Counts) -> [String; 4] {
    let all = counts.total();
    [
        percent(counts.warped, all),
        percent(counts.disoccluded, all),
        percent(counts.angle, all),
        percent(counts.void, all),
    ]
}

impl Report<'_> {
    pub(super) fn print(&self, trace: Option<&PathBuf>) {
        let pace = self.fps.map(|fps| format!(" at {fps} frames a second"));
        say!(
            "{}: {} frames of {} x {}{}, depth from {}",
            self.scene,
            self.frames,
            self.width,
            self.height,
            pace.unwrap_or_default(),
            self.depth
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
                    "  {}: {} predicted references, off by {:.4} rad on average, {:.4} at most, \
                     {:.4} of the scene's units (the paper: below 0.01 rad)",
                    variant.name(),
                    prediction.references,
                    prediction.mean_radians,
                    prediction.largest_radians,
                    prediction.mean_distance
                );
            }
            if let Some(timing) = &variant.timing {
                timing.print(&variant.name(), trace);
            }
        }
    }

    fn print_frames(variant: &Variant) {
        let mut all = table(&[
            "frame",
            "from",
            "warped %",
            "hidden %",
            "angle %",
            "void %",
            "of the foreground:",
            "warped %",
            "hidden %",
            "angle %",
            "PSNR to model",
            "SSIM",
            "PSNR to truth",
            "SSIM",
        ]);
        for frame in &variant.frames {
            let from = match (frame.reference, frame.fell_back) {
                (Some(_), true) => "full (fallback)".to_owned(),
                (Some(reference), false) => format!("R{reference}"),
                (None, _) => "full".to_owned(),
            };
            let [warped, hidden, angle, void] = shares(&frame.frame.pixels);
            let [fore_warped, fore_hidden, fore_angle, _] = shares(&frame.foreground.pixels);
            let Part { model, truth, .. } = &frame.frame;
            let psnr = |l: &Option<Likeness>, digits| number(l.and_then(|l| l.psnr_db), digits);
            let ssim = |l: &Option<Likeness>| number(l.and_then(|l| l.ssim), 4);
            all.add_row([
                frame.number.to_string(),
                from,
                warped,
                hidden,
                angle,
                void,
                String::new(),
                fore_warped,
                fore_hidden,
                fore_angle,
                psnr(model, 2),
                ssim(model),
                psnr(truth, 2),
                ssim(truth),
            ]);
        }
        print(&mut all);
    }

    fn print_totals(&self) {
        let mut all = table(&[
            "",
            "PSNR to truth, dB",
            "loss, dB",
            "the paper's",
            "SSIM to truth",
            "PSNR to model, dB",
            "of the foreground",
            "SSIM to model",
            "hidden %",
            "of the foreground",
            "angle %",
            "edge %",
            "rendered %",
            "fallbacks",
        ]);
        let own = self.model.and_then(|m| m.mean_psnr_db);
        for variant in &self.variants {
            let truth = variant.frame.truth;
            let psnr = truth.and_then(|t| t.mean_psnr_db);
            let loss = own.zip(psnr).map(|(own, psnr)| own - psnr);
            let paper = match (variant.method, variant.window, variant.phi_degrees) {
                ("SpaRW", 6, None) => "1.0",
                ("SpaRW", 16, None) => "1.4",
                _ => "",
            };
            let model = variant.frame.model;
            let counts = &variant.frame.pixels;
            let fore = &variant.foreground.pixels;
            all.add_row([
                variant.name(),
                number(psnr, 2),
                number(loss, 2),
                paper.to_owned(),
                number(truth.and_then(|t| t.ssim), 4),
                number(model.and_then(|m| m.psnr_db), 2),
                number(variant.foreground.model.and_then(|m| m.psnr_db), 2),
                number(model.and_then(|m| m.ssim), 4),
                percent(counts.disoccluded, counts.total()),
                percent(fore.disoccluded, fore.total()),
                percent(counts.angle, counts.total()),
                percent(counts.edge, counts.total()),
                format!("{:.1}", 100.0 * variant.rendered_share),
                variant.fallbacks.to_string(),
            ]);
        }
        print(&mut all);
        say!(
            "  loss: by how much the model's own PSNR to ground truth falls, means of frames; \
             rendered: pixels that the model renders, references included, of those of all frames \
             in full"
        );
    }
}
