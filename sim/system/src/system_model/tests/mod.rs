//! Frames and paths on the system, of work that was made up.
#![allow(clippy::unwrap_used)]

mod conservation;
mod given;
mod gpu;
mod parts;
mod rooms;
mod traffic;

use std::sync::OnceLock;

use potamoi_formats::config::Config;
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthReport, Synthesised, UnitKind};
use potamoi_warp::Profile;
use proptest::prelude::*;

use potamoi_cycles::batch::Batch;

use super::work::{
    Classes, FrameWork, PathOptions, PathParts, PathReplay, PathWork, Quality, Reads, Replay,
    Replayed, TargetWork,
};
use super::*;

pub(in crate::system_model) fn costs(program: Program) -> &'static Costs {
    static ALL: OnceLock<[Costs; 2]> = OnceLock::new();
    let make = |program| {
        let reports = Synthesised::checked_in().unwrap();
        let records = SynthReport::of_records().unwrap();
        let parameters = Parameters {
            given: None,
            system: &reports[0].report,
            reports: &reports,
            estimated: &[],
            records: &records,
            sizes: OnChipSizes::default(),
            wire_margin: 0.0,
        };
        let fit = Fit::checked_in().unwrap();
        Costs::new(&Config::paper(), program, fit, &parameters).unwrap()
    };
    let all = ALL.get_or_init(|| [make(Program::Fields), make(Program::Splats)]);
    &all[usize::from(program == Program::Splats)]
}

/// Of four channels, or of eight.
pub(in crate::system_model) fn memory(channels: u32) -> &'static Memory {
    static ALL: OnceLock<[Memory; 2]> = OnceLock::new();
    let all = ALL.get_or_init(|| [4, 8].map(Memory::with_channels));
    &all[usize::from(channels == 8)]
}

/// Batches that a frame could have, and counts beside them.
fn any_work() -> impl Strategy<Value = FrameWork> {
    let batch = (1u64..5_000, 1u64..40_000, 1u64..200_000, 1u64..200_000).prop_map(
        |(entries, rows, array, vector)| Batch {
            runs: 1,
            mvoxels: 1 + rows / 512,
            entries,
            gather_cycles: 4 * entries + rows / 8,
            gather_busy: 4 * entries,
            codes_read: entries * 8 * 13,
            row_bytes: rows * 26,
            rit_bytes: entries * 48,
            rit_read_bytes: entries * 48,
            feature_bytes: entries * 26,
            operations: 1,
            elements: vector,
            vector_cycles: vector,
            vector_busy: vector,
            operand_bytes: vector * 6,
            result_bytes: vector * 4,
            products: 1,
            macs: array * 100,
            array_cycles: array,
            input_bytes: entries * 26,
            weight_bytes: 1152,
            output_bytes: entries * 6,
            partial_bytes: entries * 12,
            ..Batch::default()
        },
    );
    let batches = prop::collection::vec(batch, 1..12);
    (batches, 1u64..1_000_000, any::<bool>()).prop_map(|(batches, samples, splats)| {
        let entries: u64 = batches.iter().map(|b| b.entries).sum();
        let own = |n: u64| if splats { n } else { 0 };
        FrameWork {
            pixels: 4096,
            frame_pixels: 4096,
            samples: samples - own(samples),
            gaussians: own(samples / 10 + 1),
            visible: own(samples / 20),
            left_out_coefficients: 0,
            pairs: own(entries),
            pairs_tested: 0,
            pixel_pairs: None,
            record_bytes: own(samples),
            spilled_bytes: samples / 3,
            scattered_bytes: batches[0].row_bytes,
            reads: Reads {
                tables: 1,
                model_bytes: 1 << 22,
                reads: entries * 8,
                bytes: entries * 8 * 26,
                sectors: entries * 8,
                missed_bytes: entries * 26,
                misses: entries,
                not_streaming: entries / 2,
                conflict_rate: 0.4,
            },
            batches,
        }
    })
}

/// Bytes of the weights of a model.
const WEIGHTS: u64 = 40_000;

const GATHERING: [Gathering; 3] = [Gathering::PixelOrder, Gathering::Streamed, Gathering::Unit];

/// A frame at both bounds of the GPU's kernels.
fn bounds(system: &System, work: &FrameWork, gathering: Gathering) -> AtBounds<Run> {
    let model = Model {
        system,
        memory: memory(system.memory_channels),
        costs: costs(Program::of(work)),
        clock_ghz: 1.0,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    model.frame(work, gathering).unwrap()
}

/// A frame where the demands of the GPU's kernels overlap.
fn frame(system: &System, work: &FrameWork, gathering: Gathering) -> Run {
    bounds(system, work, gathering).max
}

/// A path of two references that serve three targets each.
fn path(full: &FrameWork, sparse: &FrameWork) -> PathWork {
    let target = |number: usize| TargetWork {
        reference: (number > 0).then_some(number / 3),
        classes: Classes {
            warped: 4000,
            void: 0,
            rendered: 96,
        },
        work: (number > 0).then(|| sparse.clone()),
    };
    PathWork {
        scene: "made up".to_owned(),
        algorithm: "none".to_owned(),
        size: [64, 64],
        options: PathOptions {
            frames: 6,
            fps: 30.0,
            window: 3,
            phi: None,
            profile: Profile::Potamoi,
            array: [24, 24],
            is_double_buffered: false,
            cache: 1 << 19,
            parts: PathParts::All,
        },
        references: vec![full.clone(), full.clone()],
        reference_frames: vec![(Some(0), 0), (None, 1)],
        targets: (0..6).map(target).collect(),
        chained: (0..6)
            .map(|number| TargetWork {
                reference: (number % 3 > 0).then_some(number / 3),
                work: (number % 3 > 0).then(|| sparse.clone()),
                ..target(number)
            })
            .collect(),
        halves: vec![sparse.clone(); 2],
        full_quality: Quality::default(),
        warped_quality: Quality::default(),
        chained_quality: Quality::default(),
        half_quality: Quality::default(),
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1.0)
}

/// Work of one batch.
fn some_work() -> FrameWork {
    FrameWork {
        pixels: 4096,
        frame_pixels: 4096,
        samples: 10_000,
        gaussians: 0,
        visible: 0,
        left_out_coefficients: 0,
        pairs: 0,
        pairs_tested: 0,
        pixel_pairs: None,
        record_bytes: 0,
        spilled_bytes: 0,
        scattered_bytes: 0,
        reads: Reads {
            reads: 8000,
            bytes: 16_000,
            sectors: 8000,
            ..Reads::default()
        },
        batches: vec![Batch {
            runs: 1,
            entries: 1000,
            gather_cycles: 4100,
            gather_busy: 4000,
            codes_read: 8000,
            ..Batch::default()
        }],
    }
}

/// A path in which the camera stands still is the same frame again and again, and frames that overlap take
/// less time than frames alone.
#[test]
fn a_frame_again_and_again_is_a_path_of_full_frames() {
    let (system, work) = (System::default(), some_work());
    let model = Model {
        system: &system,
        memory: memory(4),
        costs: costs(Program::Fields),
        clock_ghz: 1.0,
        weight_bytes: 0,
        replay: None,
    };
    let variant = Variant {
        name: "",
        frames: Frames::Full,
        gathering: Gathering::Unit,
    };
    let path = path(&work, &work);
    let (whole, _) = model.run(&path, variant, Scenario::Local).unwrap();
    let own = model.repeated(&work, Gathering::Unit, path.targets.len());
    let own = own.unwrap();
    assert_eq!(own, whole.run);
    let alone = model.frame(&work, Gathering::Unit).unwrap();
    assert!(own.max.span_ns < 6.0 * alone.max.span_ns);
    assert!(own.max.span_ns >= alone.max.span_ns);
}
