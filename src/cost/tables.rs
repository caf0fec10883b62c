//! Tables of points.

use std::fmt::Write as _;

use potamoi_explore::accuracy::knobs::Knob;
use potamoi_explore::accuracy::{
    ImageQuality, Point, Reference, ReferenceKind, SearchResult, Sweep,
};
use potamoi_system::system_model::ClockOrigin;

use crate::model::ladder;
use crate::stdout::{prose, say};
use crate::tables;

fn number(of: Option<f64>, digits: usize) -> String {
    of.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

fn db(of: ImageQuality) -> String {
    of.db
        .map_or_else(|| "equal".to_owned(), |v| format!("{v:.2}"))
}

/// Columns that narrow tables leave out, the first of them first.
const LAST: [&str; 12] = [
    "SSIM",
    "gathering cycles",
    "vector cycles",
    "PSNR at bounds, dB",
    "largest error bound",
    "largest pixel error",
    "softplus: max ulp (bound), mean",
    "sigmoid: max ulp (bound), mean",
    "gather: max ulp (bound), mean",
    "one minus exp: max ulp (bound), mean",
    "exp: max ulp (bound), mean",
    "PSNR to float, dB",
];

pub(super) fn print(report: &Sweep, knobs: &[Knob]) {
    prose!(
        0,
        "{} ({}), {} x {}: full frames on the gathering and vector units; warped frames in the \
         ratio of a warped path to the same path in full",
        report.scene,
        report.algorithm,
        report.size[0],
        report.size[1]
    );
    let default = report.default_point();
    let operations = default.units.named().into_iter().enumerate();
    let operations: Vec<_> = operations
        .filter(|(_, (_, error))| error.is_some())
        .collect();
    let of_units = operations
        .iter()
        .map(|(_, (name, _))| format!("{}: max ulp (bound), mean", name.replace('_', " ")));
    let head = ["knob", "setting"].map(str::to_owned).into_iter();
    let head = head.chain(of_units).chain(
        [
            "PSNR to truth, dB",
            "SSIM",
            "PSNR to converged, dB",
            "SSIM",
            "PSNR to float, dB",
            "largest pixel error",
            "largest error bound",
            "PSNR at bounds, dB",
            "gathering cycles",
            "vector cycles",
            "GHz",
            "us per frame",
            "relative to default",
            "mJ",
            "mm^2, 12 nm",
            "front",
        ]
        .map(str::to_owned),
    );
    let mut table = tables::lined(2, head.collect::<Vec<_>>());
    // The reference's own level is left out last.
    let mut last = vec![match report.reference.kind {
        ReferenceKind::Truth => "PSNR to converged, dB",
        ReferenceKind::Converged => "PSNR to truth, dB",
    }];
    last.extend(LAST);
    for (i, point) in report.points.iter().enumerate() {
        let errors = point.units.named();
        let of_units = operations.iter().map(|(at, _)| match errors[*at].1 {
            Some(e) => format!("{:.3} ({:.3}), {:.3}", e.max_ulp, e.bound(), e.mean_ulp),
            None => "-".to_owned(),
        });
        let truth = point.truth;
        let begin = [point.knob.clone(), point.setting.clone()].into_iter();
        table.add_row(begin.chain(of_units).chain([
            truth.map_or_else(|| "-".to_owned(), db),
            number(truth.and_then(|t| t.ssim), 5),
            db(point.converged),
            number(point.converged.ssim, 5),
            point.float.map_or_else(|| "-".to_owned(), db),
            number(point.worst.map(|w| w.measured), 6),
            number(point.worst.and_then(|w| w.bound), 6),
            number(point.worst.and_then(|w| w.bound_db), 1),
            point.gather_cycles.to_string(),
            point.vector_cycles.to_string(),
            clock(point),
            format!("{:.1}", point.frame_ns * 1e-3),
            format!("{:.3}", point.frame_ns / default.frame_ns),
            number(point.energy_mj, 3),
            match point.is_estimated && point.area_mm2.is_some() {
                true => format!("~{}", number(point.area_mm2, 4)),
                false => number(point.area_mm2, 4),
            },
            mark(report, i).to_owned(),
        ]));
    }
    say!("{}", tables::fitted(&table, &last));
    prose!(
        0,
        "GHz: 1 over the longest period of the accelerator's blocks at 12 nm, before wires: ~ \
         estimated, ! assumed, else synthesised; mm^2: cells of the units, ~ where formulas give the change of one \
         (potamoi compare adds memories, array and buffers); mJ and mm^2: - where no synthesis and no formula covers the units (potamoi synth \
         measures them); PSNR: - where there is no such picture; {MID}"
    );
    let mut points = report.points.iter();
    if points.any(|point| point.clock_origin == ClockOrigin::Guessed) {
        prose!(
            0,
            "GHz: ? a guess, since the period of a block is not known: the slowest of its kind"
        );
    }
    prose!(0, "{}", beside(&report.reference));
    for knob in knobs {
        prose!(0, "{}", sentence(knob, report));
    }
    let place = |i: usize| {
        let point = &report.points[i];
        format!(
            "{}, {} dB at {:.1} us",
            format!("{} {}", point.knob, point.setting).trim_end(),
            number(Some(point.place().quality).filter(|q| q.is_finite()), 2),
            point.frame_ns * 1e-3
        )
    };
    match (report.knee, report.front.as_slice()) {
        (Some(knee), _) => say!("the knee of the front: {}", place(knee)),
        (None, [fastest, .., best]) => say!(
            "the front has no knee: from {} to {}",
            place(*fastest),
            place(*best)
        ),
        (None, [only]) => say!("nothing is faster or better than {}", place(*only)),
        (None, []) => {}
    }
    for refused in &report.refused {
        prose!(
            0,
            "not possible for this scene and configuration: {} {}: {}",
            refused.knob,
            refused.setting,
            refused.why
        );
    }
    match report.ladder.as_slice() {
        [] => say!("time: by the cycle models; --ladder compares them with the Verilated units"),
        rungs => {
            say!("\nfidelity of the time model, for one full frame by itself");
            ladder::print(rungs);
        }
    }
}

fn mark(report: &Sweep, i: usize) -> &'static str {
    match (report.knee == Some(i), report.front.contains(&i)) {
        (true, _) => "knee",
        (_, true) => "yes",
        _ => "",
    }
}

/// Sentence on a knob's best setting.
fn sentence(knob: &Knob, report: &Sweep) -> String {
    let Some((point, lost)) = report.best_setting(knob.name) else {
        return format!(
            "{}: none of its settings is possible for this scene and configuration",
            knob.name
        );
    };
    format!(
        "{} {} ({}): {:+.2} dB, {:+.1} % of the frame's time",
        knob.name,
        point.setting,
        knob.what,
        -lost,
        100.0 * (point.frame_ns / report.default_point().frame_ns - 1.0)
    )
}

/// Sentence on what quality is measured against.
fn beside(reference: &Reference) -> String {
    let first = match reference.kind {
        ReferenceKind::Truth => {
            "truth, the analytic field that the model was sampled from; converged"
        }
        ReferenceKind::Converged => "converged",
    };
    format!(
        "reference of quality, front, knee and goals: {first}, the model without approximations of \
         the renderer ({}); float: the same settings in floating point, the error of the formats \
         alone",
        reference.converged.words()
    )
}

pub(super) fn found(found: &SearchResult, default: &Point, kind: ReferenceKind) {
    let SearchResult {
        settings,
        point,
        tried,
    } = found;
    let quality = |p: &Point| number(Some(p.place().quality).filter(|q| q.is_finite()), 2);
    say!("");
    prose!(
        0,
        "found after {tried} combinations beside single settings: {}",
        match settings.is_empty() {
            true => "the default itself".to_owned(),
            false => settings.join(", "),
        }
    );
    let less = |own: f64, of: f64| match 100.0 * (1.0 - own / of) {
        saved if saved.abs() < 0.05 => "equal".to_owned(),
        saved if saved < 0.0 => format!("{:.1} % more", -saved),
        saved => format!("{saved:.1} % less"),
    };
    prose!(
        2,
        "{} dB PSNR to {} instead of {}; {:.1} us a frame instead of {:.1}: {}{}",
        quality(point),
        kind.name(),
        quality(default),
        point.frame_ns * 1e-3,
        default.frame_ns * 1e-3,
        less(point.frame_ns, default.frame_ns),
        match (point.energy_mj, default.energy_mj) {
            (Some(own), Some(of)) => format!("; {own:.3} mJ instead of {of:.3}: {}", less(own, of)),
            _ => String::new(),
        }
    );
    prose!(2, "{MID}");
}

/// What a time in these tables is.
const MID: &str = "us: the geometric mean of a frame's time where all demands of the GPU's kernels \
                   overlap and where none do (potamoi model prints both)";

/// The accelerator's clock, marked where it is not synthesised.
fn clock(point: &Point) -> String {
    format!("{}{:.2}", point.clock_origin.mark(), point.clock_ghz)
}

/// One line a point.
pub(super) fn csv(report: &Sweep) -> String {
    let units = report.default_point().units.named();
    let units = units.map(|(name, _)| format!("{name}_max_ulp,{name}_bound_ulp,{name}_mean_ulp"));
    let mut text = format!(
        "knob,setting,{},reference,truth_db,truth_ssim,converged_db,converged_ssim,float_db,worst_pixel,worst_pixel_bound,gather_cycles,vector_cycles,array_cycles,clock_ghz,clock_origin,frame_ns,energy_mj,area_mm2,front,estimated\n",
        units.join(",")
    );
    let field = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    for (i, p) in report.points.iter().enumerate() {
        let units = p.units.named().map(|(_, error)| {
            [
                error.map(|e| e.max_ulp),
                error.map(|e| e.bound()),
                error.map(|e| e.mean_ulp),
            ]
        });
        let numbers = [
            p.truth.and_then(|t| t.db),
            p.truth.and_then(|t| t.ssim),
            p.converged.db,
            p.converged.ssim,
            p.float.and_then(|f| f.db),
            p.worst.map(|w| w.measured),
            p.worst.and_then(|w| w.bound),
        ];
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            p.knob,
            p.setting,
            units
                .concat()
                .into_iter()
                .map(field)
                .collect::<Vec<_>>()
                .join(","),
            report.reference.kind.name(),
            numbers.map(field).join(","),
            p.gather_cycles,
            p.vector_cycles,
            p.array_cycles,
            p.clock_ghz,
            p.clock_origin.word(),
            p.frame_ns,
            field(p.energy_mj),
            field(p.area_mm2),
            mark(report, i),
            p.is_estimated
        );
    }
    text
}
