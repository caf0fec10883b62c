//! Knobs of rendering: rules, order, sampling, precision and effects.

use potamoi_base::effects::Effect;
use potamoi_base::precision::Precision;
use potamoi_scene::Scene;
use potamoi_splats::{Order, Profile};

use super::{Knob, RenderChange, config, rendered};

pub(super) fn splatting() -> Vec<Knob> {
    let alphas = [0.008, 0.016, 0.03];
    let cut_off = |at| Precision {
        alpha_min: Some(at),
        ..Precision::default()
    };
    let conic = |n| Precision {
        conic_bits: Some(n),
        ..Precision::default()
    };
    let widths = [10, 12, 14, 18, 22];
    vec![
        Knob {
            name: "order",
            what: "Gaussians in the order in which MVoxels bring them",
            settings: vec![rendered(
                "streamed",
                RenderChange::Order(Order::Approximate),
            )],
        },
        Knob {
            name: "extent",
            what: "which tiles a Gaussian is drawn in, and the cap of alpha",
            settings: vec![
                rendered("box", RenderChange::Profile(Profile::GsplatCap99)),
                rendered("ellipse", RenderChange::Profile(Profile::Brush)),
            ],
        },
        Knob {
            name: "cut-off",
            what: "the alpha below which a Gaussian is skipped",
            settings: alphas
                .map(|at| rendered(&at.to_string(), RenderChange::Precision(cut_off(at))))
                .to_vec(),
        },
        Knob {
            name: "conic-bits",
            what: "fraction bits of the factors of conics",
            settings: widths
                .map(|n| rendered(&n.to_string(), RenderChange::Precision(conic(n))))
                .to_vec(),
        },
        Knob {
            name: "records-a-row",
            what: "splat records that share a row of the feature table",
            settings: vec![config("2", "[gu]\nrecords_a_row = 2")],
        },
    ]
}

pub(super) fn interpolation() -> Vec<Knob> {
    let codes = [8, 10, 12, 14];
    let weights = [4, 6, 8, 10, 12];
    let inputs = [12, 14, 16, 18];
    vec![
        Knob {
            name: "feature-bits",
            what: "bits of a feature's code",
            settings: codes
                .map(|n| config(format!("{n}"), format!("[gu]\nfeature_bits = {n}")))
                .to_vec(),
        },
        Knob {
            name: "weight-bits",
            what: "fraction bits of interpolation weights",
            settings: weights
                .map(|n| config(format!("{n}"), format!("[gu]\nweight_bits = {n}")))
                .to_vec(),
        },
        Knob {
            name: "density-bits",
            what: "fraction bits of the power of 1 - exp(-s)",
            settings: inputs
                .map(|n| {
                    config(
                        format!("{n}"),
                        format!("[vu.exp]\none_minus_frac_bits = {n}"),
                    )
                })
                .to_vec(),
        },
        Knob {
            name: "sums",
            what: "whether interpolated sums are rounded",
            settings: vec![config("exact", "[gu]\nsums = \"exact\"")],
        },
    ]
}

/// Early-termination thresholds, without the profile's own.
pub(super) fn stops(scene: &Scene) -> Knob {
    let rules = scene.facts().thickness.stop;
    let stop = |at: f64| Precision {
        stop_below: Some(at),
        ..Precision::default()
    };
    // Rules are of numbers of 32 bits.
    let others = [1e-4, 1e-3, 0.004, 0.02, 0.05].into_iter();
    let others = others.filter(|at| (at / rules - 1.0).abs() > 1e-6);
    Knob {
        name: "stop",
        what: "the transmittance at which a pixel stops",
        settings: others
            .map(|at| rendered(&at.to_string(), RenderChange::Precision(stop(at))))
            .collect(),
    }
}

/// Fraction bits of transmittances.
pub(super) fn transmittances() -> Knob {
    let bits = |n| Precision {
        transmittance_bits: Some(n),
        ..Precision::default()
    };
    let widths = [8, 10, 12, 14, 16, 18];
    Knob {
        name: "transmittance-bits",
        what: "fraction bits of transmittances",
        settings: widths
            .map(|n| rendered(&n.to_string(), RenderChange::Precision(bits(n))))
            .to_vec(),
    }
}

/// Effects that the scene calls for, each left out.
pub(super) fn left_out(scene: &Scene) -> Vec<Knob> {
    let facts = scene.facts();
    let mut knobs = vec![];
    let degrees = facts.highest_harmonic().min(3) as u8;
    if degrees > 0 {
        let without = |d: u8| RenderChange::Without(Effect::SphericalHarmonics(d + 1));
        knobs.push(Knob {
            name: "sh-degree",
            what: "the highest degree of spherical harmonics",
            settings: (0..degrees)
                .map(|d| rendered(&d.to_string(), without(d)))
                .collect(),
        });
    }
    let levels = facts.hashed_tables() as u32;
    if levels > 0 {
        let first = |n| Precision {
            hashed_levels: Some(n),
            ..Precision::default()
        };
        // The finest one by one, as they are the most bytes; then halves.
        let mut kept: Vec<u32> = vec![0, levels / 2, levels.saturating_sub(2), levels - 1];
        kept.sort_unstable();
        kept.dedup();
        knobs.push(Knob {
            name: "hash-levels",
            what: "levels of which vertices share entries that are gathered, from the coarsest",
            settings: (kept.into_iter())
                .map(|n| rendered(&n.to_string(), RenderChange::Precision(first(n))))
                .collect(),
        });
    }
    if facts.sees_directions() {
        knobs.push(Knob {
            name: "directions",
            what: "whether the perceptron sees the viewing direction",
            settings: vec![rendered("none", RenderChange::Without(Effect::ViewMlp))],
        });
    }
    knobs
}
