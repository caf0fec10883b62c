//! What bounds each variant, and the GPU alone.

use potamoi_explore::system::Modelled;
use potamoi_system::system_model::{AtBounds, Outcome, Run};

use super::clock;
use crate::bounds::{range, ratio, tight, times, with_mid};
use crate::tables;

/// What bounds each variant, what the best units would give, and the GPU alone.
pub(super) fn table(found: &Modelled, own: &[&Outcome]) -> comfy_table::Table {
    let gpu = &found.gpu_only;
    let mut header = vec![
        format!("what bounds it, {}", clock::at(&found.clock)),
        "bottleneck, demands overlapped".to_owned(),
        "and not overlapped".to_owned(),
        "frames/s if the units took no time".to_owned(),
        "that speed-up at most".to_owned(),
        "over the GPU alone, fused program".to_owned(),
    ];
    header.extend((gpu.published.as_ref()).map(|of| format!("over {} on it", of.program)));
    header.push("the GPU alone is".to_owned());
    let mut table = tables::plain(header);
    let busiest = |run: &Run| {
        let (name, share) = run.bottleneck();
        format!("{name}, {:.0} %", 100.0 * share)
    };
    for o in own {
        let frames = o.run.max.frames as f64;
        let free = o.run.map(|run| run.free_units_ns);
        let over = found.over_gpu(o, &gpu.fused);
        let mut row = vec![
            clock::marked(o.variant.name, &found.clock),
            busiest(&o.run.max),
            busiest(&o.run.sum),
            range(&free.map(|ns| frames / ns * 1e9)),
            range(&found.baseline(o).run.span_ns().over(&free)),
            ratio(&over),
        ];
        row.extend((gpu.published.as_ref()).map(|of| ratio(&found.over_gpu(o, of))));
        row.push(faster(&over).to_owned());
        table.add_row(row);
    }
    let per_second = |ns: &AtBounds<f64>| with_mid(&ns.map(|ns| 1e9 / ns));
    let mut row = vec![
        "the GPU alone, frames/s".to_owned(),
        String::new(),
        String::new(),
        String::new(),
        String::new(),
        per_second(&gpu.fused.frame_ns),
    ];
    row.extend((gpu.published.as_ref()).map(|of| per_second(&of.frame_ns)));
    table.add_row(row);
    table
}

/// Frames a second if hardware beside the GPU did a part of its work in no time, and over those of the
/// variant as it is.
pub(super) fn moved(found: &Modelled, own: &[&Outcome]) -> comfy_table::Table {
    let first = "frames/s if the GPU had no".to_owned();
    let parts = found.moved.iter().map(|part| part.work.to_owned());
    let mut table = tables::plain(std::iter::once(first).chain(parts).collect::<Vec<_>>());
    for (at, o) in own.iter().enumerate() {
        let rates = found.moved.iter().map(|part| {
            let rate = &part.frames_per_second[at];
            let by = rate.over(&o.run.frames_per_second());
            format!("{}, x {}", tight(rate), times(&by))
        });
        let name = std::iter::once(clock::marked(o.variant.name, &found.clock));
        table.add_row(name.chain(rates).collect::<Vec<_>>());
    }
    table
}

/// Whether the GPU alone, with its own memory and the fused program, is faster than a variant.
const fn faster(over: &AtBounds<f64>) -> &'static str {
    match (over.decides(), over.low() < 1.0) {
        (false, _) => "faster or slower",
        (true, true) => "faster",
        (true, false) => "slower",
    }
}
