//! Tables of results.

use std::path::PathBuf;

use potamoi_explore::warping::{ImageQuality, Part, Variant, Warping};
use potamoi_warp::Counts;

use super::report::Reports;
use super::timing;
use crate::scene::say_not_checked;
use crate::stdout::{prose, say};
use crate::tables;

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

fn percent(part: u64, all: u64) -> String {
    if all == 0 {
        return "-".to_owned();
    }
    format!("{:.1}", 100.0 * part as f64 / all as f64)
}

/// Columns of [`shares`] of the frame and of its foreground.
const SHARES: [&str; 10] = [
    "warped %",
    "disoccluded %",
    "angle %",
    "edge %",
    "void %",
    "foreground: warped %",
    "foreground: disoccluded %",
    "foreground: angle %",
    "foreground: edge %",
    "foreground: void %",
];

/// Columns that a narrow table leaves out first.
const LAST: [&str; 8] = [
    "foreground: void %",
    "foreground: angle %",
    "foreground: edge %",
    "foreground: disoccluded %",
    "foreground: warped %",
    "foreground: SSIM",
    "foreground: PSNR",
    "SSIM",
];

/// Shares of pixels in per cent: warped, disoccluded, by angle, at edges, void.
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

/// Prints one scene.
pub(super) fn print(found: &Warping, trace: Option<&PathBuf>) {
    let mut depths: Vec<&str> = vec![];
    for variant in &found.variants {
        if !depths.contains(&variant.depth.as_str()) {
            depths.push(&variant.depth);
        }
    }
    let pace = found.fps.map(|fps| format!(" at {fps} frames a second"));
    say!(
        "{}: {} frames of {} x {}{}, depth from {}",
        found.scene,
        found.frames,
        found.width,
        found.height,
        pace.unwrap_or_default(),
        depths.join(", ")
    );
    if let Some(model) = &found.model {
        say!(
            "  the model in full against ground truth: {} dB (mean of frames), SSIM {}",
            number(model.mean_psnr_db, 2),
            number(model.ssim, 4)
        );
    }
    if let [variant] = &found.variants[..] {
        print_frames(variant);
    }
    print_totals(found);
    for variant in &found.variants {
        if let Some(prediction) = &variant.prediction {
            prose!(
                2,
                "{}: prediction error of {} references: {:.4} rad on average, {:.4} rad at most; \
                 {:.4} units of the scene on average (the paper: below 0.01 rad)",
                variant.name,
                prediction.references,
                prediction.mean_radians,
                prediction.largest_radians,
                prediction.mean_distance
            );
        }
        if let Some(timing) = &variant.timing {
            timing::print(timing, &variant.name, trace);
        }
    }
    say_not_checked(&found.not_checked);
}

fn print_frames(variant: &Variant) {
    let mut header = vec!["frame", "reference"];
    header.extend(SHARES);
    for likeness in ["PSNR to model", "PSNR to truth"] {
        header.extend([likeness, "SSIM", "foreground: PSNR", "foreground: SSIM"]);
    }
    let mut all = tables::lined(1, &header);
    for frame in &variant.frames {
        let from = match (frame.reference, frame.fell_back) {
            (Some(_), true) => "full (fallback)".to_owned(),
            (Some(reference), false) => format!("R{reference}"),
            (None, _) => "full".to_owned(),
        };
        let Part { model, truth, .. } = &frame.frame;
        let fore = &frame.foreground;
        let psnr = |l: &Option<ImageQuality>, digits| number(l.and_then(|l| l.psnr_db), digits);
        let ssim = |l: &Option<ImageQuality>| number(l.and_then(|l| l.ssim), 4);
        let mut row = vec![frame.number.to_string(), from];
        row.extend(shares(&frame.frame.pixels));
        row.extend(shares(&fore.pixels));
        for likeness in [model, &fore.model, truth, &fore.truth] {
            row.extend([psnr(likeness, 2), ssim(likeness)]);
        }
        all.add_row(row);
    }
    say!("{}", tables::fitted(&all, &LAST));
}

fn print_totals(found: &Warping) {
    let mut quality = tables::lined(
        1,
        [
            "",
            "PSNR to truth, dB",
            "loss, dB",
            "the paper's",
            "SSIM",
            "foreground: PSNR",
            "foreground: SSIM",
            "PSNR to model, dB",
            "SSIM",
            "foreground: PSNR",
            "foreground: SSIM",
        ],
    );
    let mut header = vec![""];
    header.extend(SHARES);
    header.extend(["fallbacks", "rendered in total %"]);
    let mut pixels = tables::lined(1, &header);
    for variant in &found.variants {
        let [frame, fore] = [&variant.frame, &variant.foreground];
        let mean = |l: Option<ImageQuality>| number(l.and_then(|l| l.mean_psnr_db), 2);
        let psnr = |l: Option<ImageQuality>| number(l.and_then(|l| l.psnr_db), 2);
        let ssim = |l: Option<ImageQuality>| number(l.and_then(|l| l.ssim), 4);
        // Of its pace.
        let papers = variant.papers_loss().filter(|_| found.fps == Some(30.0));
        quality.add_row([
            variant.name.clone(),
            mean(frame.truth),
            number(variant.loss(found.model.as_ref()), 2),
            papers.map_or_else(String::new, |l| format!("{l:.1}")),
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
    say!("{}", tables::fitted(&quality, &LAST));
    say!("{}", tables::fitted(&pixels, &LAST));
    prose!(
        2,
        "loss: fall of the PSNR to ground truth below that of the model's own frames; PSNR to truth \
         is the mean over frames, PSNR to model is over all pixels; the paper's loss is of trained \
         models"
    );
    prose!(
        2,
        "rendered in total: pixels that the model renders, references included, as a share of all \
         frames in full"
    );
}

/// Value of a method in a table of several scenes.
type Value = fn(&Warping, &Variant) -> Option<f64>;

impl Reports {
    /// One row a scene, one column a method.
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
            let mut all = tables::lined(1, &header);
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
            say!("{}", tables::fitted(&all, &LAST));
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
