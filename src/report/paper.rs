//! Figures of the paper beside ours, each with the reason of their difference.

use potamoi_explore::system::{Modelled, Paper, gathering_speed_up};
use potamoi_system::system_model::{AtBounds, Outcome};

use super::document::{BesidePaper, Found};

/// Number of the paper on arXiv.
pub(super) const ARXIV: &str = "2408.06608";

/// Speed-ups, savings and losses that the paper has of this machine's variants.
pub(super) fn beside(found: &Modelled) -> Vec<BesidePaper> {
    let mut rows: Vec<BesidePaper> = vec![];
    for own in &found.outcomes {
        if own.variant.name != "baseline" {
            rows.extend(of_variant(found, own));
        }
    }
    let (paper, which) = gathering_speed_up(&found.algorithm);
    let gathered = found.gathered.gpu_ns.over(&found.gathered.unit_ns);
    rows.push(BesidePaper {
        figure: format!("gathering on the unit over gathering on the GPU ({which} in the paper)"),
        unit: "times as fast",
        paper: paper.to_string(),
        ours: match gathered.max.is_finite() && gathered.sum.is_finite() {
            true => Found::Known(gathered),
            false => Found::unknown("this scene gathers nothing on the unit"),
        },
        reason: "the paper timed a GPU whose kernels are not fused; ours gathers in one fused kernel, \
                 which is the conservative baseline",
    });
    rows
}

fn of_variant(found: &Modelled, own: &Outcome) -> Vec<BesidePaper> {
    let paper = Paper::of(own, found.options.window);
    let mut rows = vec![];
    let mut row = |what: &str, unit, paper: Option<f64>, ours, reason| {
        if let Some(paper) = paper {
            rows.push(BesidePaper {
                figure: format!("{}: {what}", own.variant.name),
                unit,
                paper: format!("{paper:.1}"),
                ours,
                reason,
            });
        }
    };
    row(
        "speed-up over the baseline",
        "times as fast",
        paper.speed_up,
        Found::Known(found.speed_up(own)),
        "the paper's is a mean over data sets of 800 x 800; its baseline runs published kernels, ours \
         fused ones, which leave less to gain",
    );
    let saving = found.saving(own);
    row(
        "energy saving over the baseline",
        "times less",
        paper.saving,
        saving.map_or_else(
            || Found::unknown("an energy of the configuration's units is not known"),
            Found::Known,
        ),
        "the GPU, which both share, takes most of the energy here; the paper states no power of its GPU",
    );
    let loss = own
        .float_quality
        .full_db
        .map(|db| AtBounds { max: db, sum: db });
    row(
        "loss of quality at most (paper), PSNR beside full frames (ours)",
        "dB",
        paper.lost_db,
        loss.map_or_else(
            || Found::unknown("the frames are equal to full ones"),
            Found::Known,
        ),
        "not the same measure: the paper's is a difference of two PSNRs beside photographs, which this \
         scene does not have",
    );
    rows
}
