//! Recorded results of made-up paths on every variant; `make refresh` writes them again.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;

use potamoi_warp::Profile;

use super::tests::{costs, memory};
use super::work::{
    Classes, FrameWork, PathOptions, PathParts, PathWork, Quality, Reads, TargetWork,
};
use super::*;
use potamoi_cycles::batch::Batch;

/// A splat or field frame of so many batches, each larger than the one before.
pub(super) fn frame(splats: bool, batches: u64, pixels: u64) -> FrameWork {
    let of = |n: u64| if splats { n } else { 0 };
    let batches: Vec<Batch> = (1..=batches)
        .map(|i| Batch {
            runs: 1,
            mvoxels: 3 * i,
            entries: 900 * i,
            gather_cycles: 4100 * i,
            gather_busy: 3600 * i,
            codes_read: 900 * i * 8 * 12,
            row_bytes: 40_000 * i,
            rit_bytes: 48 * 900 * i,
            rit_read_bytes: 2 * 48 * 900 * i,
            feature_bytes: 24 * 900 * i,
            operations: 4,
            elements: 30_000 * i,
            vector_cycles: 5000 * i,
            vector_busy: 4000 * i,
            operand_bytes: 200_000 * i,
            result_bytes: 120_000 * i,
            products: 3,
            macs: 2_000_000 * i,
            array_cycles: 7000 * i,
            input_bytes: 70_000 * i,
            weight_bytes: 34_560 * i,
            output_bytes: 11_000 * i,
            partial_bytes: 22_000 * i,
            ..Batch::default()
        })
        .collect();
    let entries: u64 = batches.iter().map(|b| b.entries).sum();
    FrameWork {
        pixels,
        frame_pixels: 4096,
        samples: if splats { 0 } else { 6 * pixels },
        gaussians: of(50_000),
        visible: of(45_000),
        left_out_coefficients: 0,
        pairs: of(20_000),
        pairs_tested: 0,
        pixel_pairs: None,
        record_bytes: of(288_000),
        spilled_bytes: 12_000,
        scattered_bytes: 9000,
        reads: Reads {
            tables: 1,
            model_bytes: 1 << 22,
            reads: entries * 8,
            bytes: entries * 8 * 24,
            sectors: entries * 9,
            missed_bytes: entries * 24,
            misses: entries,
            not_streaming: entries / 3,
            conflict_rate: 0.4,
        },
        batches,
    }
}

/// Twelve frames, with a reference for each three.
fn path(splats: bool) -> PathWork {
    let target = |number: usize, window: usize| TargetWork {
        reference: (!number.is_multiple_of(window)).then_some(number / window),
        classes: Classes {
            warped: 3800,
            void: 100,
            rendered: 196,
        },
        work: (!number.is_multiple_of(window)).then(|| frame(splats, 1, 196)),
    };
    PathWork {
        scene: "made up".to_owned(),
        algorithm: "none".to_owned(),
        size: [64, 64],
        options: PathOptions {
            frames: 12,
            fps: 30.0,
            window: 3,
            phi: None,
            profile: Profile::Potamoi,
            array: [24, 24],
            is_double_buffered: false,
            cache: 1 << 19,
            parts: PathParts::All,
        },
        references: (0..4).map(|i| frame(splats, 5 + i, 4096)).collect(),
        reference_frames: vec![(Some(0), 0), (None, 1), (None, 4), (None, 7)],
        // Only the first reference is a frame of the path, as `reference_frames` says.
        targets: (0..12)
            .map(|number| TargetWork {
                reference: (number > 0).then_some(number / 3),
                ..target(number, 12)
            })
            .collect(),
        chained: (0..12).map(|number| target(number, 3)).collect(),
        halves: vec![frame(splats, 2, 1024); 4],
        full_quality: Quality::default(),
        warped_quality: Quality::default(),
        chained_quality: Quality::default(),
        half_quality: Quality::default(),
    }
}

/// Times at both bounds, bytes and energies of all variants, for fields and splats, on the paper's system and on
/// one bound by buffers, memory and interconnect.
#[test]
fn figures_are_what_they_were() {
    let narrow = System {
        feature_buffer_bytes: 64 * 1024,
        feature_banks: 4,
        feature_block_banks: 2,
        groups_in_flight: 1,
        weight_buffer_bytes: 1024,
        interconnect_over_memory: 0.3125,
        ..System::default()
    };
    let mut text = String::new();
    for (name, system) in [("paper", System::default()), ("narrow", narrow)] {
        for splats in [false, true] {
            let work = path(splats);
            let model = Model {
                system: &system,
                memory: memory(4),
                costs: costs(Program::of(&work.references[0])),
                clock_ghz: 1.0,
                weight_bytes: 40_000,
                replay: None,
            };
            for scenario in [Scenario::Local, Scenario::Remote] {
                for variant in Variant::ALL {
                    let both = model.run(&work, variant, scenario).unwrap().0.run;
                    let run = &both.max;
                    let kind = if splats { "splats" } else { "field" };
                    write!(text, "{name} {kind} {scenario:?} {}:", variant.name).unwrap();
                    let moved = [run.spent.interconnect_bytes, run.spent.link_bytes];
                    let energies = run.energy.named().into_iter().map(|(_, mj)| mj.unwrap());
                    let energies: Vec<f64> = energies.collect();
                    for value in [&[run.span_ns, both.sum.span_ns][..], &moved, &energies].concat()
                    {
                        write!(text, " {value:.6e}").unwrap();
                    }
                    text.push('\n');
                }
            }
        }
    }
    insta::assert_snapshot!(text);
}
